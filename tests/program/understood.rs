//! Interpretation of studies with random points: zipped parameters, units of variables, limits, differences from an earlier study.

use crate::support::{Folder, json, say, table};
use std::fs;

/// A study with a design of `u`, crossed with the given parameters.
fn study(design: &str, more: &str) -> String {
    format!(
        "schema = 1\nmodel = \"function\"\nseed = 3\n[function]\no = \"u*a + b + c\"\n[design]\n{design}\n\
         [[uncertain]]\nname = \"u\"\ndistribution = \"uniform\"\nlower = 0\nupper = 1\n{more}"
    )
}

fn vary(name: &str, values: &str) -> String {
    let zip = if name == "c" { "" } else { "zip = \"z\"\n" };
    format!("[[vary]]\nname = \"{name}\"\nvalues = {values}\n{zip}")
}

#[test]
fn zipped_parameters_are_compared_along_their_group() {
    let folder = Folder::new();
    let axes = vary("a", "[1, 2]") + &vary("b", "[0, 1]") + &vary("c", "[0, 0.5, 1]");
    let asked = "[[question]]\nname = \"apart\"\ndifference = [2, 1]\nvary = \"a\"\nmean = \"o\"\n\
                 [[question]]\nname = \"along\"\nfragility = \"a\"\nprobability = \"o > 1\"\n\
                 [[question]]\nname = \"across\"\nfragility = \"c\"\nprobability = \"o > 1\"\n";
    let text = study("kind = \"monte-carlo\"\nsamples = 200", &(axes + asked));
    let (path, out) = (folder.write("s.toml", &text), folder.name("out"));
    let said = say(&["run", &path, "--out", &out]);
    assert_eq!(said.code, 0, "{}", said.err);
    let found = json(&fs::read_to_string(folder.path("out/answers.json")).expect("answers"));
    let answers = found["answers"].as_array().expect("a list");
    let of = |name: &str| answers.iter().filter(|answer| answer["name"] == name).collect::<Vec<_>>();
    // (u*2 + 1) - (u*1 + 0) = u + 1, for every c
    let (header, rows) = table(&out);
    let place = header.iter().position(|name| name == "u").expect("u");
    let mean = rows.iter().map(|row| row[place].parse::<f64>().expect("a number")).sum::<f64>() / rows.len() as f64;
    assert_eq!((rows.len(), of("apart").len(), of("along").len(), of("across").len()), (1200, 3, 3, 2));
    for (answer, c) in of("apart").into_iter().zip([0.0, 0.5, 1.0]) {
        assert_eq!(answer["group"], serde_json::json!({ "c": c }));
        assert!((answer["estimate"].as_f64().expect("a number") - mean - 1.0).abs() < 1e-12, "{answer}");
        assert!(answer["notes"].to_string().contains("b goes with a (zip)"), "{answer}");
    }
    // a value that occurs twice does not identify a position
    let twice = text.replace("values = [1, 2]", "values = [2, 1, 1]").replace("values = [0, 1]", "values = [0, 1, 2]");
    let refused = say(&["check", &folder.write("twice.toml", &twice)]);
    assert_eq!(refused.code, 3, "{}", refused.out);
    for key in ["question[0].vary", "question[1].fragility"] {
        assert!(refused.err.contains(&format!("{key} = \"a\": 1 occurs more than once along `a`")), "{}", refused.err);
    }
    assert!(refused.err.contains("2 problems in"), "{}", refused.err);
}

#[test]
fn numbers_of_a_law_have_one_dimension() {
    let folder = Folder::new();
    let law = |keys: &str| {
        let more = format!("[[uncertain]]\nname = \"x\"\n{keys}{}", vary("c", "[1]"));
        let text = study("kind = \"monte-carlo\"\nsamples = 4", &more).replace("u*a + b + c", "x*c");
        say(&["check", &folder.write("s.toml", &text)])
    };
    folder.write("good.csv", "v\n1 mm\n0.02 in\n3\n");
    folder.write("bad.csv", "v\n1 mm\n2 kg\n");
    for (keys, wrong) in [
        ("distribution = \"normal\"\nmean = \"1 mm\"\nsd = \"2 kg\"\n", "uncertain[1].sd = \"2 kg\": the unit `kg`"),
        (
            "distribution = \"discrete\"\nvalues = [\"1 mm\", \"2 kg\"]\n",
            "uncertain[1].values[1] = \"2 kg\": the unit `kg`",
        ),
        (
            "distribution = \"empirical\"\nfile = \"bad.csv\"\ncolumn = \"v\"\n",
            "bad.csv:3:1: v = \"2 kg\": the unit `kg`",
        ),
        (
            "distribution = \"empirical\"\nfile = \"good.csv\"\ncolumn = \"v\"\nupper = \"1 s\"\n",
            "good.csv:2:1: v = \"1 mm\": the unit `mm` does not fit: other numbers of the same distribution are in `s`",
        ),
    ] {
        let said = law(keys);
        assert!(said.code == 3 && said.err.contains(wrong), "{}", said.err);
    }
    for keys in [
        "distribution = \"normal\"\nmean = \"1 mm\"\nsd = \"0.01 in\"\nupper = 0.1\n",
        "distribution = \"empirical\"\nfile = \"good.csv\"\ncolumn = \"v\"\n",
    ] {
        let said = law(keys);
        assert_eq!(said.code, 0, "{}", said.err);
    }
    let near = law("distribution = \"normal\"\nmean = 2\nsd = 1\nlower = 2\nupper = 2.0000000000001\n");
    assert!(near.code == 0 && near.out.contains("cut at 2 and 2.0000000000001:"), "{}{}", near.out, near.err);
    // for a table with an unknown name its other mistake is reported, too
    let both =
        law("distribution = \"normal\"\nmean = 2\nsd = 1\n[[correlation]]\nbetween = [\"u\", \"y\"]\nrank = 2\n");
    for part in ["correlation[0].between", "correlation[0].rank: `rank` = 2", "2 problems in"] {
        assert!(both.err.contains(part), "{part}\n{}", both.err);
    }
}

#[test]
fn a_limit_leaves_hypercubes_that_have_an_interval() {
    let folder = Folder::new();
    for kind in ["latin-hypercube", "sobol"] {
        let asked = "[[question]]\nname = \"m\"\nmean = \"o\"\n[[question]]\nname = \"p\"\nprobability = \"o > 1.5\"\n";
        let axes = vary("a", "[1, 2]") + &vary("b", "[0, 1]") + &vary("c", "[1]");
        let text = study(&format!("kind = {kind:?}\nsamples = 64\nreplicates = 16"), &(axes + asked));
        let (path, out) = (folder.write("s.toml", &text), folder.name(kind));
        let word = "--limit 100 takes the first 64 points: 4 in each replicate, a power of two";
        let check = say(&["check", &path, "--limit", "100"]);
        assert!(
            check.err.contains(word) && check.out.contains("64 points of 1 uncertain"),
            "{}{}",
            check.out,
            check.err
        );
        let run = say(&["run", &path, "--out", &out, "--limit", "100"]);
        assert!(run.code == 0 && run.err.contains(word), "{}", run.err);
        assert!(!run.out.contains("no interval"), "{}", run.out);
        assert_eq!(table(&out).1.len(), 128);
        // no message if the limit is exactly kept
        assert!(!say(&["check", &path, "--limit", "128"]).err.contains("--limit"));
    }
}

#[test]
fn another_design_is_refused_with_what_differs() {
    let folder = Folder::new();
    let text = study(
        "kind = \"sobol\"\nsamples = 8\nreplicates = 4",
        &(vary("a", "[1]") + &vary("b", "[0]") + &vary("c", "[1]")),
    );
    let (path, out) = (folder.write("s.toml", &text), folder.name("out"));
    assert_eq!(say(&["run", &path, "--out", &out]).code, 0);
    for (from, to, told) in [
        ("seed = 3", "seed = 4", "  seed: 3 -> 4\n"),
        ("\"sobol\"", "\"halton\"", "  design.kind: sobol -> halton\n"),
        ("samples = 8", "samples = 4", "  points of the design: 32 -> 16\n"),
        ("replicates = 4", "replicates = 2", "  design.replicates: 4 -> 2\n"),
    ] {
        assert!(text.contains(from));
        folder.write("s.toml", &text.replace(from, to));
        let said = say(&["run", &path, "--out", &out]);
        assert!(said.code == 3 && said.err.contains("was computed with another study"), "{}", said.err);
        assert!(said.err.contains(told), "{told}{}", said.err);
        assert_eq!(said.err.matches(" -> ").count(), 1, "{}", said.err);
    }
}
