//! Worker process, from its command line to its exit code.

use std::ffi::OsString;
use std::process::ExitCode;
use std::time::Duration;

use bladeoff_protocol::ipc::IpcWorker;
use bladeoff_protocol::link::WorkerLink;
use bladeoff_protocol::messages::Hello;
use bladeoff_protocol::transport::PortError;
use bladeoff_system::with_causes;

use crate::args::{ArgsError, WorkerArgs};
use crate::core_solver::{CoreSolver, SolverError};
use crate::fault::Faults;
use crate::function_solver::{FunctionSolver, FunctionSolverError};
use crate::heartbeat::Heartbeat;
use crate::job_spec::{JobSpec, JobSpecError};
use crate::noop::NoopSolver;
use crate::process::{self, EXIT_CONNECTION, EXIT_PLAN, EXIT_USAGE, ProcessError};
use crate::serve::{ServeError, serve};

/// Error that ends a worker.
#[derive(Debug, thiserror::Error)]
pub enum WorkerError {
    /// Command line.
    #[error(transparent)]
    Args(#[from] ArgsError),
    /// Set-up of the process.
    #[error(transparent)]
    Process(#[from] ProcessError),
    /// Plan.
    #[error(transparent)]
    Plan(#[from] JobSpecError),
    /// Solver of the plan.
    #[error(transparent)]
    Solver(#[from] SolverError),
    /// Solver of the formulas of the plan.
    #[error(transparent)]
    Function(#[from] FunctionSolverError),
    /// Connection to the orchestrator.
    #[error(transparent)]
    Connection(#[from] PortError),
    /// Invalid message.
    #[error(transparent)]
    Serve(#[from] ServeError),
}

/// Runs a worker with the arguments after `bladeoff worker`. An error is written to standard error, which the
/// orchestrator collects.
pub fn worker_main(args: impl IntoIterator<Item = OsString>, faults: &dyn Faults) -> ExitCode {
    let Err(error) = run(args, faults) else { return ExitCode::SUCCESS };
    eprintln!("{}", with_causes(&error));
    ExitCode::from(match error {
        WorkerError::Args(_) => EXIT_USAGE,
        WorkerError::Plan(_) | WorkerError::Solver(_) | WorkerError::Function(_) => EXIT_PLAN,
        WorkerError::Process(_) | WorkerError::Connection(_) | WorkerError::Serve(_) => EXIT_CONNECTION,
    })
}

fn run(args: impl IntoIterator<Item = OsString>, faults: &dyn Faults) -> Result<(), WorkerError> {
    let args = WorkerArgs::parse(args)?;
    process::take_name();
    let watch = || args.parent.map(process::end_with_parent).transpose();
    let (for_link, for_pulse) = (watch()?, watch()?);
    let hello = Hello { pid: std::process::id(), build: process::build_id() };
    let heartbeat = Heartbeat::default();
    let connect = || -> Result<WorkerLink<IpcWorker>, WorkerError> {
        heartbeat
            .start(for_pulse)
            .map_err(|source| ProcessError::System { doing: "starting the heartbeat", source })?;
        let port = IpcWorker::connect(&args.address, args.worker, for_link)?;
        if let Some(bytes) = args.memory_limit {
            process::limit_memory(bytes)?;
        }
        Ok(WorkerLink::new(port, args.run, args.worker))
    };
    if let Some(micros) = args.noop {
        let mut solver = NoopSolver { busy: Duration::from_micros(micros) };
        serve(connect()?, hello, &mut solver, &heartbeat, faults)?;
    } else {
        let job = JobSpec::read(&args.run_dir, &args.plan_hash)?;
        match job {
            JobSpec::Machine(job) => {
                let mut solver = CoreSolver::new(&job)?;
                drop(job);
                serve(connect()?, hello, &mut solver, &heartbeat, faults)?;
            }
            JobSpec::Function(job) => {
                let mut solver = FunctionSolver::new(&job)?;
                serve(connect()?, hello, &mut solver, &heartbeat, faults)?;
            }
        }
    }
    Ok(())
}
