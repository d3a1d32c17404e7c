//! Cores and memory that a scheduler has allotted to this task on a shared node.
//!
//! The system reports affinity and cgroups. Schedulers that use neither set environment variables.

use std::path::Path;

/// Variables with the number of cores: Slurm, PBS, LSF, HyperQueue.
const CORES: [&str; 4] = ["SLURM_CPUS_ON_NODE", "NCPUS", "LSB_DJOB_NUMPROC", "HQ_CPUS_COUNT"];
/// Memory of the task's first process \[bytes\].
const OWN: u64 = 512 << 20;
/// Smallest memory limit of a worker \[bytes\]: a smaller one would fail ordinary samples.
const LEAST: u64 = 256 << 20;

/// Cores of this task, at most those that the system allows.
#[must_use]
pub fn cores(usable: usize) -> usize {
    cores_by(|name| std::env::var(name).ok(), usable)
}

fn cores_by(variable: impl Fn(&str) -> Option<String>, usable: usize) -> usize {
    let told = CORES.iter().find_map(|name| variable(name)?.trim().parse::<usize>().ok()).filter(|cores| *cores > 0);
    told.map_or(usable, |told| told.min(usable)).max(1)
}

/// Memory limit of a worker, if the task has a limit that all workers together could exceed. A sample that needs too much memory
/// then ends its worker and not the whole task.
#[must_use]
pub fn memory_of_worker(workers: usize) -> Option<u64> {
    of_worker(memory_by(|name| std::env::var(name).ok(), workers).into_iter().chain(cgroup()).min()?, workers)
}

fn of_worker(memory: u64, workers: usize) -> Option<u64> {
    let each = memory.checked_sub(OWN)? / workers.max(1) as u64;
    (each >= LEAST).then_some(each)
}

/// Memory limit of the task by the variables of Slurm, which are in MB.
fn memory_by(variable: impl Fn(&str) -> Option<String>, cores: usize) -> Option<u64> {
    let megabytes = |name: &str| variable(name)?.trim().parse::<u64>().ok().filter(|megabytes| *megabytes > 0);
    let of_node = megabytes("SLURM_MEM_PER_NODE");
    let of_cores = || megabytes("SLURM_MEM_PER_CPU").map(|each| each.saturating_mul(cores as u64));
    of_node.or_else(of_cores).map(|megabytes| megabytes.saturating_mul(1 << 20))
}

/// Memory limit of the control groups of this process.
fn cgroup() -> Option<u64> {
    let own = std::fs::read_to_string("/proc/self/cgroup").ok()?;
    let own = own.lines().find_map(|line| line.strip_prefix("0::/"))?;
    let limit = |folder: &Path| std::fs::read_to_string(folder.join("memory.max")).ok()?.trim().parse().ok();
    Path::new("/sys/fs/cgroup")
        .join(own)
        .ancestors()
        .take_while(|path| path.starts_with("/sys/fs/cgroup"))
        .filter_map(limit)
        .min()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_task_takes_what_it_was_given() {
        let variables = |pairs: &'static [(&str, &str)]| {
            move |name: &str| pairs.iter().find(|(known, _)| *known == name).map(|(_, value)| (*value).to_owned())
        };
        assert_eq!(cores_by(variables(&[("SLURM_CPUS_ON_NODE", "4")]), 64), 4);
        assert_eq!(cores_by(variables(&[("SLURM_CPUS_ON_NODE", "4")]), 2), 2, "affinity allows less");
        assert_eq!(cores_by(variables(&[("NCPUS", "none")]), 8), 8);
        assert_eq!(memory_by(variables(&[("SLURM_MEM_PER_NODE", "2048")]), 4), Some(2 << 30));
        assert_eq!(memory_by(variables(&[("SLURM_MEM_PER_CPU", "1024")]), 4), Some(4 << 30));
        assert_eq!(memory_by(variables(&[]), 4), None);
        assert_eq!(of_worker(4608 << 20, 4), Some(1 << 30));
        assert_eq!(of_worker(600 << 20, 4), None, "a limit would fail what may well fit");
    }
}
