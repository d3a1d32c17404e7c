//! `bladeoff verify`: comparison of the solver with reference results, on this machine.

use super::error::CliError;
use super::exit::Exit;
use super::json::{number, quoted};
use super::output::{print, print_json};
use crate::questions::known_probabilities;
use bladeoff_answers::summary::{Align, TextTable};
use bladeoff_core::verification::{Check, verify};

/// Recompute reference cases and compare them with published and independent numbers
///
/// Whirl frequencies, critical speeds and unbalance responses of published rotors, ring frequencies, passages through
/// resonance with prescribed and with free spin, closed forms of rubs, small probabilities. Each is printed beside its
/// reference, with the tolerance that the source supports (of a probability: four standard errors of 131 072 points). No
/// file is read. It takes some seconds on one core.
///
/// Exit code 0 if every case holds, else 1.
#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:\n  bladeoff verify\n  bladeoff verify --json")]
pub struct Args {
    /// Print one JSON object instead of the table
    #[arg(long)]
    json: bool,
}

/// Runs the subcommand.
pub fn main(args: &Args) -> Result<Exit, CliError> {
    let mut checks = verify();
    checks.extend(known_probabilities());
    if args.json {
        print_json(&json(&checks))?
    } else {
        print(&table(&checks))?
    }
    Ok(exit(&checks))
}

/// A case that does not hold is an error of the program.
fn exit(checks: &[Check]) -> Exit {
    if checks.iter().all(Check::holds) { Exit::Ok } else { Exit::Bug }
}

fn table(checks: &[Check]) -> String {
    let header = [
        ("case", Align::Left),
        ("engine", Align::Left),
        ("quantity", Align::Left),
        ("ours", Align::Right),
        ("reference", Align::Right),
        ("unit", Align::Left),
        ("error", Align::Right),
        ("allowed", Align::Right),
        ("", Align::Left),
        ("source", Align::Left),
    ];
    let mut table = TextTable::new(&header);
    for check in checks {
        table.row(vec![
            check.case.to_owned(),
            check.engine.to_owned(),
            check.quantity.clone(),
            check.ours.map_or_else(|| "-".to_owned(), digits),
            digits(check.reference),
            check.unit.to_owned(),
            check.error().map_or_else(|| "-".to_owned(), |error| format!("{error:.1e}")),
            format!("{:.1e}", check.tolerance),
            if check.holds() { "pass" } else { "FAIL" }.to_owned(),
            check.source.to_owned(),
        ]);
    }
    let failed = checks.iter().filter(|check| !check.holds()).count();
    let verdict = match failed {
        0 => format!("all {} numbers hold", checks.len()),
        failed => format!("{failed} of {} values are out of tolerance", checks.len()),
    };
    format!("{}\n{verdict}\n", table.render(""))
}

/// Ten significant digits, more than any comparison here uses.
fn digits(value: f64) -> String {
    if value == 0.0 || (1e-3..1e6).contains(&value.abs()) {
        let places = (9 - value.abs().max(1e-3).log10().floor() as i32).clamp(0, 12);
        format!("{value:.*}", usize::try_from(places).unwrap_or(0))
    } else {
        format!("{value:.9e}")
    }
}

fn json(checks: &[Check]) -> String {
    let optional = |value: Option<f64>| value.map_or_else(|| "null".to_owned(), number);
    let rows: Vec<String> = checks
        .iter()
        .map(|check| {
            format!(
                "    {{\"case\": {}, \"engine\": {}, \"quantity\": {}, \"ours\": {}, \"reference\": {}, \"unit\": {}, \"error\": {}, \
                 \"tolerance\": {}, \"holds\": {}, \"source\": {}}}",
                quoted(check.case),
                quoted(check.engine),
                quoted(&check.quantity),
                optional(check.ours),
                number(check.reference),
                quoted(check.unit),
                optional(check.error()),
                number(check.tolerance),
                check.holds(),
                quoted(check.source),
            )
        })
        .collect();
    let all = checks.iter().all(Check::holds);
    format!("{{\n  \"holds\": {all},\n  \"checks\": [\n{}\n  ]\n}}\n", rows.join(",\n"))
}

#[cfg(test)]
mod tests {
    use super::*;
    use bladeoff_core::verification::NO_RUN;

    fn check(ours: Option<f64>) -> Check {
        Check {
            case: "ring \"a\"",
            engine: NO_RUN,
            quantity: "f2".to_owned(),
            ours,
            reference: 211.331,
            tolerance: 1e-5,
            unit: "Hz",
            source: "closed form",
        }
    }

    #[test]
    fn one_number_that_does_not_hold_is_exit_code_1() {
        assert_eq!(exit(&[check(Some(211.331))]) as u8, 0);
        assert_eq!(exit(&[check(Some(211.331)), check(Some(212.0))]) as u8, 1);
        assert_eq!(exit(&[check(None)]) as u8, 1);
    }

    #[test]
    fn the_table_says_what_fails() {
        let text = table(&[check(Some(211.331)), check(Some(212.0)), check(None)]);
        assert!(text.contains("pass") && text.contains("FAIL"), "{text}");
        assert!(text.ends_with("2 of 3 values are out of tolerance\n"), "{text}");
        assert!(text.contains("211.3310000") && text.contains("3.2e-3"), "{text}");
    }

    #[test]
    fn the_json_is_json_with_null_for_what_is_missing() {
        let parsed: serde_json::Value =
            serde_json::from_str(&json(&[check(Some(211.331)), check(None)])).expect("valid");
        assert_eq!(parsed["holds"], false);
        assert_eq!(parsed["checks"][0]["holds"], true);
        assert_eq!(parsed["checks"][0]["case"], "ring \"a\"");
        assert_eq!(parsed["checks"][0]["engine"], "-");
        assert!(parsed["checks"][1]["ours"].is_null() && parsed["checks"][1]["error"].is_null());
    }

    #[test]
    fn digits_are_readable_at_every_size() {
        assert_eq!(digits(1.4), "1.400000000");
        assert_eq!(digits(4_870.364_187_969_99), "4870.364188");
        assert_eq!(digits(5.721e-4), "5.721000000e-4");
    }
}
