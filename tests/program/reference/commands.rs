//! The command line according to clap, exit codes, events.

use super::{codes, head, row, sentence};
use bladeoff::cli::{Exit, commands};
use bladeoff::run::{EVENTS, EVENTS_VERSION};
use clap::{Arg, Command};

pub fn page() -> String {
    let mut program = commands();
    program.build();
    let mut page = String::from("## Exit codes\n\n");
    page += &head(&["exit code", "meaning"]);
    for exit in Exit::ALL {
        page += &row(&[(exit as u8).to_string(), sentence(exit.meaning())]);
    }
    page += "\n";
    for command in shown(&program) {
        page += &described("bladeoff", command, 2);
    }
    page
}

/// Subcommands of a command, as its help lists them.
fn shown(command: &Command) -> impl Iterator<Item = &Command> {
    command.get_subcommands().filter(|command| command.get_name() != "help" && !command.is_hide_set())
}

/// Description of a command with its options, and of its subcommands.
fn described(above: &str, command: &Command, level: usize) -> String {
    let name = format!("{above} {}", command.get_name());
    let about = command.get_long_about().or(command.get_about()).map(ToString::to_string).unwrap_or_default();
    let mut text = format!("{} {name}\n\n{}\n", "#".repeat(level), markdown(&about));
    let usage = command.clone().render_usage().to_string();
    text += &format!("\n```text\n{}\n```\n", usage.trim());
    let args: Vec<&Arg> = command.get_arguments().filter(|arg| arg.get_id() != "help" && !arg.is_hide_set()).collect();
    if !args.is_empty() {
        text += &format!("\n{}", head(&["option", "meaning"]));
        for arg in args {
            text += &row(&[format!("`{}`", spelling(arg)), meaning(arg)]);
        }
    }
    if let Some(examples) = command.get_after_help() {
        text += &format!("\n{}\n", markdown(&examples.to_string()));
    }
    text += "\n";
    for below in shown(command) {
        text += &described(&name, below, level + 1);
    }
    text
}

/// Paragraphs of a help text as Markdown, with its indented lines as blocks.
fn markdown(text: &str) -> String {
    let mut found = String::new();
    let mut is_block = false;
    for paragraph in text.trim_end().split("\n\n") {
        for line in paragraph.lines() {
            if line.starts_with("  ") != is_block {
                found += if is_block { "```\n\n" } else { "\n```text\n" };
                is_block = !is_block;
            }
            found += &if is_block { line.strip_prefix("  ").unwrap_or(line).to_owned() } else { plain(line) };
            found.push('\n');
        }
        if !is_block {
            found.push('\n');
        } else if let Some(next) = text.split("\n\n").skip_while(|other| *other != paragraph).nth(1)
            && next.starts_with("  ")
        {
            found.push('\n');
        }
    }
    if is_block {
        found += "```\n";
    }
    found.replace("\n\n\n", "\n\n").trim().to_owned()
}

/// Text with the special characters of Markdown and HTML escaped, except within backquotes.
fn plain(text: &str) -> String {
    let pieces = text.split('`').enumerate().map(|(place, piece)| match place % 2 {
        0 => piece.replace('<', "&lt;").replace('*', "\\*"),
        _ => piece.to_owned(),
    });
    pieces.collect::<Vec<_>>().join("`")
}

fn spelling(arg: &Arg) -> String {
    let values = arg.get_value_names().filter(|_| arg.get_action().takes_values()).unwrap_or_default();
    let values: Vec<String> = values.iter().map(|name| format!("<{name}>")).collect();
    match arg.get_long() {
        Some(long) if values.is_empty() => format!("--{long}"),
        Some(long) => format!("--{long} {}", values.join(" ")),
        None => values.join(" "),
    }
}

fn meaning(arg: &Arg) -> String {
    let help = arg.get_long_help().or(arg.get_help()).map(ToString::to_string).unwrap_or_default();
    let mut text = sentence(&plain(&help.replace('\n', " ")));
    let values: Vec<String> = arg.get_possible_values().iter().map(|value| value.get_name().to_owned()).collect();
    if arg.get_action().takes_values() && !values.is_empty() {
        text += &format!(" One of {}.", codes(&values.iter().map(String::as_str).collect::<Vec<_>>()));
    }
    let defaults: Vec<String> =
        arg.get_default_values().iter().map(|value| value.to_string_lossy().into_owned()).collect();
    if arg.get_action().takes_values() && !defaults.is_empty() {
        text += &format!(" Default: `{}`.", defaults.join(" "));
    }
    text
}

pub fn events() -> String {
    let mut page = format!("## Kinds of events\n\nThe version of this format is {EVENTS_VERSION}.\n");
    for event in EVENTS {
        page += &format!("\n### {}\n\n{}\n\n{}", event.name, sentence(event.meaning), head(&["field", "content"]));
        for (name, meaning) in event.fields {
            page += &row(&[format!("`{name}`").as_str(), meaning]);
        }
    }
    page
}
