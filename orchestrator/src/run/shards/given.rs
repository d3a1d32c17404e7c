//! What a scheduler has given to this task: cores and memory of the node, which others share.
//!
//! The system tells of affinity and of cgroups; a scheduler that uses neither tells by its variables alone.

use std::path::Path;

/// Cores by the variables of Slurm, PBS, LSF, HyperQueue.
const CORES: [&str; 4] = ["SLURM_CPUS_ON_NODE", "NCPUS", "LSB_DJOB_NUMPROC", "HQ_CPUS_COUNT"];
/// Memory that the first process of a task takes itself.
const OWN: u64 = 512 << 20;
/// Least memory of a worker that a limit is set to: less would fail samples that are none of the worst.
const LEAST: u64 = 256 << 20;

/// Cores of this task: at most those that the system lets it use.
#[must_use]
pub fn cores(usable: usize) -> usize {
    cores_by(|name| std::env::var(name).ok(), usable)
}

fn cores_by(variable: impl Fn(&str) -> Option<String>, usable: usize) -> usize {
    let told = CORES.iter().find_map(|name| variable(name)?.trim().parse::<usize>().ok()).filter(|cores| *cores > 0);
    told.map_or(usable, |told| told.min(usable)).max(1)
}

/// What a worker may allocate, where this task has a limit that all of them together would exceed otherwise: then a sample that takes
/// too much loses its worker, and not the task all of its work.
#[must_use]
pub fn memory_of_worker(workers: usize) -> Option<u64> {
    of_worker(memory_by(|name| std::env::var(name).ok(), workers).into_iter().chain(cgroup()).min()?, workers)
}

fn of_worker(memory: u64, workers: usize) -> Option<u64> {
    let each = memory.checked_sub(OWN)? / workers.max(1) as u64;
    (each >= LEAST).then_some(each)
}

/// By the variables of Slurm, in MB.
fn memory_by(variable: impl Fn(&str) -> Option<String>, cores: usize) -> Option<u64> {
    let megabytes = |name: &str| variable(name)?.trim().parse::<u64>().ok().filter(|megabytes| *megabytes > 0);
    let of_node = megabytes("SLURM_MEM_PER_NODE");
    let of_cores = || megabytes("SLURM_MEM_PER_CPU").map(|each| each.saturating_mul(cores as u64));
    of_node.or_else(of_cores).map(|megabytes| megabytes.saturating_mul(1 << 20))
}

/// By the control group that this process is in, and those above it.
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
