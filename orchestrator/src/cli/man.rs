//! `bladeoff man`: the help of every command as manual pages.

use super::commands;
use super::error::CliError;
use super::exit::Exit;
use super::output::print;
use bladeoff_system::files::{FileError, write_whole};
use bladeoff_system::shown;
use clap_mangen::Man;
use std::path::PathBuf;

/// Write manual pages to a directory
///
/// One page for the program (bladeoff.1) and one for each subcommand (bladeoff-run.1). The directory is created if it does
/// not exist; existing pages are replaced. Prints the path of each page.
#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:
  bladeoff man ~/.local/share/man/man1
  man bladeoff-run")]
pub struct Args {
    /// Directory for the pages
    directory: PathBuf,
}

/// Runs the subcommand.
pub fn main(args: &Args) -> Result<Exit, CliError> {
    std::fs::create_dir_all(&args.directory).map_err(FileError::at("create", &args.directory))?;
    let mut written = String::new();
    for (name, page) in pages() {
        let path = args.directory.join(name);
        write_whole(&path, &page)?;
        written += &format!("{}\n", shown(&path));
    }
    print(&written)?;
    Ok(Exit::Ok)
}

/// Name and content of every page.
fn pages() -> Vec<(String, Vec<u8>)> {
    let mut program = commands().disable_help_subcommand(true);
    program.build();
    let mut pages = Vec::new();
    add(&program, &mut pages);
    pages
}

/// Adds the page of a command and the pages of its subcommands.
fn add(command: &clap::Command, pages: &mut Vec<(String, Vec<u8>)>) {
    let man = Man::new(command.clone());
    let mut page = Vec::new();
    man.render(&mut page).expect("writing to memory cannot fail");
    pages.push((man.get_filename(), page));
    command.get_subcommands().filter(|below| !below.is_hide_set()).for_each(|below| add(below, pages));
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_command_has_a_page_with_its_options_and_examples() {
        let pages = pages();
        let page = |name: &str| {
            let (_, page) =
                pages.iter().find(|(known, _)| known == name).unwrap_or_else(|| panic!("{name}: {pages:?}"));
            String::from_utf8_lossy(page).into_owned()
        };
        for command in commands().get_subcommands() {
            page(&format!("bladeoff-{}.1", command.get_name()));
        }
        assert!(page("bladeoff.1").contains("bladeoff\\-run(1)"));
        let run = page("bladeoff-run.1");
        assert!(run.contains("\\-\\-workers") && run.contains("Examples:"), "{run}");
        // the page of a subcommand of a subcommand
        assert!(page("bladeoff-bench-dispatch.1").contains("\\-\\-json"));
    }
}
