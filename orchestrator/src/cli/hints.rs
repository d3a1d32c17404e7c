//! Suggestions for a rejected word of the command line, where clap has none.

use bladeoff_system::call::word;

/// Suggestion for a rejected word; `arguments`: the command line, beginning with the program; `refused`: the part that clap rejected.
pub(super) fn hint(command: &clap::Command, arguments: &[String], refused: &str) -> Option<String> {
    let given = arguments.get(1..).unwrap_or_default();
    let mut named = command;
    for argument in given {
        let Some(below) = named.find_subcommand(argument) else { break };
        named = below;
    }
    let takes = |option: &str| named.get_arguments().any(|known| known.get_long() == Some(option));
    if refused.starts_with('-') {
        // For `-set` clap reports only the first letter.
        let long = |argument: &&String| {
            let option = argument.strip_prefix('-').unwrap_or_default().split('=').next().unwrap_or_default();
            argument.starts_with(refused) && option.len() > 1 && takes(option)
        };
        return given.iter().find(long).map(|argument| format!("hint: options have two dashes: -{argument}"));
    }
    if takes("set") {
        let at = given.iter().position(|argument| argument == refused)?;
        let before = &given[..at];
        if let [.., option, path] = before
            && option == "--set"
            && !path.contains('=')
        {
            return Some(format!("hint: the value follows `=`: --set {}", word(format!("{path}={refused}"))));
        }
        if refused.contains('=') {
            return Some(format!("hint: a parameter is set with --set {}", word(refused)));
        }
    }
    takes("out").then(|| format!("hint: --out {} chooses the file", word(refused)))
}

#[cfg(test)]
mod tests {
    use super::super::command_line;
    use super::*;

    fn of(line: &[&str]) -> Option<String> {
        let arguments: Vec<String> = [&["bladeoff"], line].concat().into_iter().map(str::to_owned).collect();
        let error = command_line().try_get_matches_from(&arguments).expect_err("refused");
        let refused = error.get(clap::error::ContextKind::InvalidArg).expect("a word").to_string();
        hint(&command_line(), &arguments, &refused)
    }

    #[test]
    fn what_was_meant_is_said_where_it_can_be_known() {
        for (line, meant) in [
            (&["new", "machine", "mine.toml"][..], "--out mine.toml chooses the file"),
            (&["simulate", "m.toml", "run.step=1e-5"], "a parameter is set with --set run.step=1e-5"),
            (&["simulate", "m.toml", "--set", "run.step", "1 us"], "the value follows `=`: --set 'run.step=1 us'"),
            (&["simulate", "m.toml", "-set", "run.step=1"], "options have two dashes: --set"),
            (&["run", "s.toml", "-workers=3"], "options have two dashes: --workers=3"),
            (&["run", "s.toml", "runs/mine"], "--out runs/mine chooses the file"),
        ] {
            assert_eq!(of(line).as_deref(), Some(&*format!("hint: {meant}")), "{line:?}");
        }
        for line in
            [&["paths", "m.toml", "--sett", "a=b"][..], &["status", "one", "two"], &["simulate", "m.toml", "-x"]]
        {
            assert_eq!(of(line), None, "{line:?}");
        }
    }
}
