//! `bladeoff new`: commented templates.

use super::error::CliError;
use super::exit::Exit;
use super::output::{print, remark};
use bladeoff_model::machine::machine_template;
use bladeoff_study::{RISK_TEMPLATE, STUDY_MACHINE, STUDY_TEMPLATE};
use bladeoff_system::call::{command, word};
use bladeoff_system::files::write_new;
use bladeoff_system::shown;
use std::path::PathBuf;

/// Write a commented template of a machine or study file
///
/// The template is a complete, valid file: change what differs and delete what you do not need. Its first line names the
/// JSON Schema that editors use (`bladeoff schema`). An existing file is not overwritten.
#[derive(Debug, clap::Args)]
#[command(
    after_help = "Examples:\n  bladeoff new machine --out studies/machines/my_rig.toml\n  bladeoff new study > studies/my-study.toml\n  bladeoff new study --kind risk > studies/my-risk.toml"
)]
pub struct Args {
    /// What to write
    #[arg(value_enum)]
    what: What,

    /// Kind of study: a `grid` of values, or uncertain parameters with a `risk` question [default: grid]
    #[arg(long, value_enum)]
    kind: Option<StudyKind>,

    /// Write to this file instead of standard output
    #[arg(long, value_name = "FILE")]
    out: Option<PathBuf>,
}

#[derive(Debug, Clone, Copy, clap::ValueEnum)]
enum What {
    /// A machine file
    Machine,
    /// A study file
    Study,
}

#[derive(Debug, Clone, Copy, clap::ValueEnum)]
enum StudyKind {
    /// Values combined with one another
    Grid,
    /// Uncertain parameters, probabilities, a gate
    Risk,
}

/// Runs the subcommand.
pub fn main(args: &Args) -> Result<Exit, CliError> {
    if args.kind.is_some() && matches!(args.what, What::Machine) {
        return Err(CliError::NoKind);
    }
    let (format, text) = match args.what {
        What::Machine => ("machine", machine_template()),
        What::Study if matches!(args.kind, Some(StudyKind::Risk)) => ("study", RISK_TEMPLATE.to_owned()),
        What::Study => ("study", STUDY_TEMPLATE.to_owned()),
    };
    let schema = format!("{format}.schema.json");
    let text = format!("#:schema {schema}\n{text}");
    match &args.out {
        None => print(&text)?,
        Some(path) if path.symlink_metadata().is_ok() => return Err(CliError::Exists { path: path.clone() }),
        Some(path) => {
            write_new(path, text.as_bytes())?;
            remark(&format!("wrote {}", shown(path)));
            let schema = path.with_file_name(&schema);
            if !schema.exists() {
                let (command, schema) = (command(["schema", format]), word(&schema));
                remark(&format!("for completion of keys in editors with taplo: {command} > {schema}"));
            }
            if let What::Study = args.what
                && !path.with_file_name(STUDY_MACHINE).exists()
            {
                remark(&format!(
                    "hint: its machine, {STUDY_MACHINE}, does not exist (paths are relative to the study): let \
                     `machine` name your machine file, or write the study into the folder studies/ of bladeoff"
                ));
            }
        }
    }
    Ok(Exit::Ok)
}
