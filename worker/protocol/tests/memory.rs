//! Creation of ports in a full /dev/shm.

#[path = "../../../tests/support/skipped.rs"]
mod skipped;

use std::io::Write;
use std::path::Path;
use std::process::Command;

use bladeoff_protocol::domain::{Address, Domain};
use bladeoff_protocol::ipc::{IpcHub, IpcWorker};
use bladeoff_protocol::messages::WorkerId;
use bladeoff_protocol::transport::PortError;

/// Environment variable that marks the child process with its own /dev/shm.
const INSIDE: &str = "BLADEOFF_TEST_OWN_MEMORY";
const SHM: &str = "/dev/shm";

/// Fills the memory except for this many pages.
fn fill_but(pages: usize) {
    let filler = Path::new(SHM).join("filler");
    let mut file = std::fs::File::create(&filler).expect("created");
    while file.write_all(&[0; 4096]).is_ok() {}
    let length = file.metadata().expect("there").len();
    file.set_len(length - 4096 * pages as u64).expect("cut");
}

/// Number of missing pages for which the creation fails; with more pages it must succeed, without gaps in between.
fn in_order<K, F>(prepare: impl Fn() -> (K, F)) -> usize
where
    F: FnOnce() -> Result<(), PortError> + Send + 'static,
{
    for pages in 0..1000 {
        let (_kept, make) = prepare();
        fill_but(pages);
        let made = std::thread::spawn(make).join().expect("no panic");
        std::fs::remove_file(Path::new(SHM).join("filler")).expect("removed");
        match made {
            Err(PortError::MemoryFull { .. }) => {}
            Err(error) => panic!("with {pages} pages: {error}"),
            Ok(()) => return pages,
        }
    }
    panic!("it never has enough");
}

/// Child process of the test below: runs in its own mount namespace.
#[test]
fn own_memory() {
    if std::env::var_os(INSIDE).is_none() {
        return;
    }
    let base = tempfile::Builder::new().prefix("bo").tempdir_in("/tmp").expect("temporary directory");
    // Memory runs out at each page of the creation in turn, each time on a new thread, because a thread stays failed.
    let hub = |address: Address| IpcHub::create(&address, 1).map(drop);
    let failures_of_hub = in_order(|| {
        let domain = Domain::create_below(&base.path().join("b"), 1).expect("a domain");
        let address = domain.address().clone();
        (domain, move || hub(address))
    });
    let failures_of_worker = in_order(|| {
        let domain = Domain::create_below(&base.path().join("b"), 1).expect("a domain");
        let hub = IpcHub::create(domain.address(), 1).expect("a hub");
        let address = domain.address().clone();
        ((hub, domain), move || IpcWorker::connect(&address, WorkerId(1), None).map(drop))
    });
    // Approximate number of pages that a hub and a worker take.
    assert!((50..200).contains(&failures_of_hub) && (20..100).contains(&failures_of_worker));
    println!("failed in order {failures_of_hub} and {failures_of_worker} times");
}

#[test]
fn memory_that_runs_out_anywhere_in_the_making_of_a_port_is_an_error() {
    let script = "mount -t tmpfs -o size=2m,mode=1777 tmpfs /dev/shm && exec \"$@\"";
    let own = |program: &Path, args: &[&str]| {
        let mut command = Command::new("unshare");
        command.args(["--mount", "sh", "-c", script, "sh"]).arg(program).args(args).env(INSIDE, "1");
        command.output()
    };
    if !own(Path::new("true"), &[]).is_ok_and(|output| output.status.success()) {
        return skipped::skipped("ports in a /dev/shm that is full", "takes root and `unshare --mount`");
    }
    let output = own(&std::env::current_exe().expect("this program"), &["--exact", "own_memory", "--nocapture"]);
    let output = output.expect("started");
    let said = String::from_utf8_lossy(&output.stdout);
    assert!(output.status.success() && said.contains("failed in order"), "{}: {output:?}", output.status);
}
