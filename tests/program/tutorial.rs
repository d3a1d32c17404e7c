//! Test of docs/tutorial.md: its files and commands in the order of the page, and every number that the page states.

use crate::support::{Folder, bladeoff, root, said, says_the_same};
use std::collections::BTreeMap;
use std::fs;

const PAGE: &str = "docs/tutorial.md";

/// The fenced blocks of the page: language and text.
fn blocks(page: &str) -> Vec<(&str, &str)> {
    let fenced = page.split("```").skip(1).step_by(2);
    fenced.map(|block| block.split_once('\n').expect("a language and a text")).collect()
}

/// Words of a command, with quotes as the page uses them.
fn words(line: &str) -> Vec<String> {
    let quoted = line.split('"').enumerate();
    let spaced = quoted.map(|(place, piece)| if place % 2 == 0 { piece.replace(' ', "\n") } else { piece.to_owned() });
    spaced.collect::<String>().split('\n').filter(|word| !word.is_empty()).map(str::to_owned).collect()
}

#[test]
fn the_files_and_commands_of_the_tutorial_give_what_it_shows() {
    let page = fs::read_to_string(root().join(PAGE)).expect("the page");
    let folder = Folder::new();
    let mut files: BTreeMap<String, String> = BTreeMap::new();
    let (mut printed, mut commands, mut shown) = (String::new(), 0, 0);
    for (language, text) in blocks(&page) {
        match language {
            "toml" => {
                let (first, rest) = text.split_once('\n').expect("lines");
                let name = first.strip_prefix("# ").expect("the name of the file").trim_end_matches(", continued");
                let file = files.entry(name.to_owned()).or_default();
                assert_eq!(file.is_empty(), !first.ends_with(", continued"), "{first}");
                file.push_str(rest);
                file.push('\n');
                folder.write(name, file);
            }
            "sh" => {
                printed.clear();
                for line in text.lines() {
                    let words = words(line);
                    let words: Vec<&str> = words.iter().map(String::as_str).collect();
                    assert_eq!(words[0], "bladeoff", "{line}");
                    let said = said(bladeoff(&words[1..]).current_dir(folder.path("")).output().expect("it starts"));
                    let expected = if words[1] == "gate" { 5 } else { 0 };
                    assert_eq!(said.code, expected, "{line}: {}", said.err);
                    printed.push_str(&said.out);
                    commands += 1;
                }
            }
            "text" => {
                for line in text.lines() {
                    assert!(
                        printed.lines().any(|found| says_the_same(found, line)),
                        "not printed: {line:?}\n{printed}"
                    );
                    shown += 1;
                }
            }
            other => panic!("a block of language {other:?}"),
        }
    }
    assert!(commands >= 10 && shown >= 13, "{commands} commands, {shown} lines");
    assert!(["machine.svg", "my_turbine-time.svg"].iter().all(|name| folder.path("figures").join(name).is_file()));
    assert!(folder.path("risk.html").is_file());
    numbers_of_the_text(&page);
}

/// The numbers in the text are those of its blocks, and the numbers of the disc follow from its dimensions.
fn numbers_of_the_text(page: &str) {
    let text: String = page.split("```").step_by(2).collect();
    let output: String =
        blocks(page).iter().filter(|(language, _)| *language == "text").map(|(_, text)| *text).collect();
    // the text on the page, the line of the output, and the number in it
    for (told, beside, number) in [
        ("critical speed is 5252 rpm", "5251.9  87.532", 5251.9),
        ("log decrement 0.57", "0.56949  forward", 0.569),
        ("critical speed by 9 %", "4804  80.067", 100.0 * (1.0 - 4804.0 / 5251.9)),
        ("reaches 26 % of their yield", "limit_ratio_blade_yield          0.260316", 26.0),
        ("moves 1.3 times its clearance", "limit_ratio_journal_clearance    1.28491", 1.285),
        ("rub begins at 0.31 s", "first_contact                    0.307188 s", 0.307),
        ("In 22 runs the blades", "22 of 128, 22 runs beyond", 22.0),
        ("In 9 of them", "9 runs beyond the model undecided", 9.0),
        ("probability of 17 %", "P(beyond_s > 0) = 17 %", 17.0),
    ] {
        assert!(text.contains(told), "the text has no {told:?}");
        assert!(output.contains(beside), "no block has {beside:?}");
        let of_text = told.split(' ').find_map(|word| word.parse::<f64>().ok()).expect("a number");
        assert!((of_text - number).abs() <= 0.06 * number, "{told}: {number}");
    }
    let (outer, inner, thickness, density) = (0.35_f64, 0.16_f64, 0.06, 7850.0);
    let mass = density * std::f64::consts::PI * (outer.powi(2) - inner.powi(2)) * thickness;
    let polar = mass * (outer.powi(2) + inner.powi(2)) / 2.0;
    let transverse = polar / 2.0 + mass * thickness.powi(2) / 12.0;
    for (value, words) in
        [(mass, "mass is 143 kg"), (polar, "polar inertia 10.6 kg m2"), (transverse, "inertia 5.3 kg m2")]
    {
        let number: f64 = words.split(' ').find_map(|word| word.parse().ok()).expect("a number");
        assert!(text.contains(words) && (value - number).abs() < 0.01 * number, "{words}: {value}");
    }
}
