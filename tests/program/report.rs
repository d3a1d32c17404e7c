//! `bladeoff report`: a single self-contained page, identical for identical results, tested in a real browser.

use crate::support::processes::signal;
use crate::support::shared_studies::slow_outputs;
use crate::support::skipped::skipped;
use crate::support::{Folder, said, say};
use std::fs;
use std::io::{BufRead, BufReader};
use std::process::{Command, Stdio};

/// A study with runs that fail where the square root has no value, every kind of question, and two values of a varied parameter. The comment and the
/// directory name would be markup if they were not escaped.
pub const STUDY: &str = r#"# </script><script>document.documentElement.dataset.hostile = 1</script><img src=http://127.0.0.1:9/x>
schema = 1
name = "stress"
model = "function"
seed = 3
[function]
margin = "strength - load * sqrt(1.2 - slope)"
damage = "load^2 * (1 + slope)"
[design]
kind = "monte-carlo"
samples = 2000
[[uncertain]]
name = "load"
distribution = "normal"
mean = 2
sd = 0.3
[[uncertain]]
name = "slope"
distribution = "exponential"
mean = 0.3
[[vary]]
name = "strength"
values = [3, 2.5]
[[question]]
name = "breaks"
probability = "margin < 0"
[[question]]
name = "damage-95"
quantile = 0.95
of = "damage"
[[question]]
name = "curve"
exceedance = "damage"
[[question]]
name = "by-load"
fragility = "load"
probability = "margin < 0"
[[question]]
name = "by-strength"
fragility = "strength"
probability = "margin < 0"
[[question]]
name = "weaker"
difference = [2.5, 3]
vary = "strength"
probability = "margin < 0"
[[question]]
name = "what-decides"
sensitivity = "damage"
method = "given-data"
[[question]]
name = "where"
map = ["load", "slope"]
of = "P(margin < 0)"
[[gate]]
require = "P(margin < 0) < 0.01"
"#;

/// A directory name that would be markup if it were not escaped.
const DIRECTORY: &str = "run <img src=x onerror=alert(1)>";

pub fn run(folder: &Folder, text: &str) -> String {
    let study = folder.write("stress.toml", text);
    let out = folder.name(DIRECTORY);
    let run = say(&["run", &study, "--out", &out, "--workers", "1"]);
    assert_eq!(run.code, 0, "{}", run.err);
    out
}

pub fn page(folder: &Folder, directory: &str, name: &str) -> String {
    let path = folder.name(name);
    let made = say(&["report", directory, "--out", &path]);
    assert_eq!((made.code, made.out.as_str()), (0, ""), "{}", made.err);
    fs::read_to_string(path).expect("UTF-8")
}

/// The page without its scripts and styles.
pub fn own(page: &str) -> String {
    let (head, rest) = page.split_once("<style>").expect("a style");
    let body = rest.split_once("</style>").expect("its end").1;
    let before = body.split_once("<script>").expect("the library").0;
    head.to_owned() + before
}

#[test]
fn a_page_says_what_answer_and_gate_say_and_is_the_same_bytes_again() {
    let folder = Folder::new();
    let directory = run(&folder, STUDY);
    let text = page(&folder, &directory, "a.html");
    assert_eq!(text, page(&folder, &directory, "b.html"), "no clock, no chance");
    let shown = own(&text)
        .replace("&lt;", "<")
        .replace("&gt;", ">")
        .replace("&quot;", "\"")
        .replace("&#39;", "'")
        .replace("&amp;", "&");
    let answers = say(&["answer", &directory]);
    assert_eq!(answers.code, 0, "{}", answers.err);
    let sentences: Vec<&str> = answers.out.lines().filter(|line| line.contains(" bad run")).map(str::trim).collect();
    assert!(sentences.len() > 6, "{}", answers.out);
    for sentence in sentences {
        assert!(shown.contains(sentence), "{sentence}");
    }
    let gate = say(&["gate", &directory]);
    assert_eq!(gate.code, 4, "{}", gate.err);
    let decision = gate.out.lines().find(|line| line.contains("failed, at least")).expect("a failed gate");
    assert!(shown.contains(decision), "{decision}");
    // every bad run is counted and drawn, and the page names a command that explains one of them
    let status = say(&["status", &directory, "--json"]);
    let status: serde_json::Value = serde_json::from_str(&status.out).expect("JSON");
    let failed = status["by_cause"]["non_finite"].as_u64().expect("some fail");
    assert!(failed > 20, "{status}");
    assert!(
        shown.contains(&format!("{failed} runs (")) && shown.contains(&format!("all {failed} failed by non_finite"))
    );
    let why = shown.split("bladeoff why ").nth(1).and_then(|rest| rest.split("</code>").next()).expect("a command");
    let command = format!("{} why {why}", env!("CARGO_BIN_EXE_bladeoff"));
    let asked = said(Command::new("sh").args(["-c", &command]).output().expect("a shell"));
    assert!(asked.code == 0 && asked.out.contains("non_finite"), "{command}: {}{}", asked.out, asked.err);
}

#[test]
fn hostile_names_and_files_stay_text_and_nothing_is_asked_of_elsewhere() {
    let folder = Folder::new();
    let directory = run(&folder, STUDY);
    let text = page(&folder, &directory, "a.html");
    let own = own(&text);
    assert!(own.contains("&lt;script&gt;document") && own.contains("onerror=alert(1)&gt;"), "they are shown");
    assert!(!own.contains("<img") && !own.contains("<script>document"));
    assert!(own.contains("default-src 'none'; script-src 'sha256-"), "{}", &own[..600]);
    // links lead to anchors of the page
    let links: Vec<&str> = own.split("href=\"").skip(1).map(|rest| rest.split('"').next().expect("an end")).collect();
    assert!(links.len() > 10, "{links:?}");
    for link in links {
        let id = link.strip_prefix('#').unwrap_or_else(|| panic!("{link} leaves the page"));
        assert!(own.contains(&format!("id=\"{id}\"")), "{link} leads nowhere");
    }
    for attribute in ["src=\"", "action=\"", "@import", "url("] {
        assert!(!own.contains(attribute), "{attribute}");
    }
}

#[test]
fn half_way_it_says_so_and_of_a_grid_it_has_no_answers() {
    let folder = Folder::new();
    let (quick, _) = STUDY.split_once("[[question]]\nname = \"what-decides\"").expect("questions that take longer");
    let study = folder.write("stress.toml", &quick.replace("samples = 2000", "samples = 200000"));
    let out = folder.name("half");
    let ended = say(&["run", &study, "--out", &out, "--workers", "1", "--max-failures", "20"]);
    assert_eq!(ended.code, 5, "failures ended it: {}", ended.err);
    assert!(folder.path("half/parts/part-000001.parquet").is_file());
    let text = own(&page(&folder, &out, "half.html"));
    assert!(text.contains("This study is not complete") && text.contains("the samples that end first are not random"));
    assert!(text.len() < 3_500_000, "{}", text.len());
    let none = say(&["report", &folder.name("nothing")]);
    assert_eq!(none.code, 3, "{}", none.err);

    let table = folder.name("half/results.parquet");
    let refused = say(&["report", &out, "--out", &table]);
    assert!(refused.code == 3 && refused.err.contains(".html"), "{}", refused.err);

    let grid = folder.small_study();
    let out = folder.name("grid");
    let run = say(&["run", &grid, "--out", &out]);
    assert_eq!(run.code, 0, "{}", run.err);
    let text = own(&page(&folder, &out, "grid.html"));
    assert!(!text.contains("id=\"answers\"") && text.contains("id=\"regimes\"") && text.contains("id=\"limits\""));
    let again = text.split("bladeoff replay ").nth(1).and_then(|rest| rest.split("</code>").next()).expect("a command");
    let replay = said(
        Command::new("sh")
            .args(["-c", &format!("{} replay {again}", env!("CARGO_BIN_EXE_bladeoff"))])
            .output()
            .expect("a shell"),
    );
    assert_eq!(replay.code, 0, "{again}: {}", replay.err);
}

/// The verdict comes first; the histogram shows the limit of the gate; the history of the worst run reaches the peak in its row; the machine is shown.
#[test]
fn a_page_has_verdict_distributions_and_the_history_of_the_worst_run() {
    let folder = Folder::new();
    let turbine = crate::support::root().join("studies/machines/lab_rig.toml");
    folder.write("rig.toml", &fs::read_to_string(turbine).expect("the rig"));
    let study = folder.write(
        "rub.toml",
        "schema = 1\nname = \"rub\"\nmachine = \"rig.toml\"\n[set]\n\"run.end_time\" = \"0.1 s\"\n\
         [design]\nkind = \"monte-carlo\"\nsamples = 12\n[[uncertain]]\npath = \"contact.gap\"\ndistribution = \"uniform\"\n\
         lower = \"0.3 mm\"\nupper = \"0.4 mm\"\n\
         [[gate]]\nrequire = \"P(max_bearing_load_N > 120 N) < 0.9\"\n",
    );
    let out = folder.name("rub");
    let run = say(&["run", &study, "--out", &out, "--workers", "1"]);
    assert!(
        run.code == 0 && run.out.contains("hyp2            12            12  12"),
        "all touch: {}{}",
        run.out,
        run.err
    );
    let text = page(&folder, &out, "rub.html");
    assert_eq!(text, page(&folder, &out, "again.html"), "the history is the same bytes, too");
    let text = own(&text);
    let place = |what: &str| text.find(what).unwrap_or_else(|| panic!("{what} is not in the page"));
    assert!(place("Verdict: 1 gate decision: ") < place("<nav"), "above everything");
    assert!(place("id=\"gates\"") < place("id=\"assumptions\""), "decisions before assumptions");
    place("max bearing load: 12 runs, ");
    place("limit 120 N");
    place("contact.gap: 12 runs, 3");
    place("The machine of sample 0 from the side");
    place("<summary>Program, engine, times and checksums</summary>");
    let worst =
        text.split("bladeoff replay ").nth(1).and_then(|rest| rest.split("</code>").next()).expect("a worst run");
    let sample = worst.split("--sample ").nth(1).expect("its sample");
    place(&format!("History of sample {sample}, the worst run by max bearing load"));
    for name in ["speed", "bearing load", "eccentricity at the diaphragm", "contact force, 1 ms mean"] {
        place(&format!("Sample {sample}: {name}, over time."));
    }
    let short = own(&{
        let path = folder.name("short.html");
        assert_eq!(say(&["report", &out, "--no-history", "--out", &path]).code, 0);
        fs::read_to_string(path).expect("UTF-8")
    });
    assert!(!short.contains("History of sample") && short.contains("Verdict: "));
}

/// The page is written while the study runs, with the element that makes a browser reload it, and once more after the end of the study, without
/// this element.
#[test]
fn a_page_is_refreshed_until_the_study_has_ended() {
    let folder = Folder::new();
    let (quick, _) = STUDY.split_once("[[question]]\nname = \"what-decides\"").expect("questions that take longer");
    let slow = quick.replace("[function]\n", &format!("[function]\n{}", slow_outputs(10, "load")));
    let study = folder.write("stress.toml", &slow.replace("samples = 2000", "samples = 200000"));
    let (out, path) = (folder.name("out"), folder.name("live.html"));
    let bladeoff = || Command::new(env!("CARGO_BIN_EXE_bladeoff"));
    let mut run = bladeoff()
        .args(["run", &study, "--out", &out, "--workers", "1"])
        .stdout(Stdio::null())
        .stderr(Stdio::null())
        .spawn()
        .expect("it starts");
    while !folder.path("out/ledger.redb").is_file() {
        assert!(run.try_wait().expect("a child").is_none(), "the study ended before it began");
        std::thread::sleep(std::time::Duration::from_millis(50));
    }
    let mut refresh = bladeoff();
    refresh.args(["report", &out, "--refresh", "1s", "--out", &path]).stdout(Stdio::null()).stderr(Stdio::piped());
    let mut report = refresh.spawn().expect("it starts");
    // The study ends when the first page has been written, so that the test does not depend on the speed of the computer.
    let mut lines = BufReader::new(report.stderr.take().expect("piped")).lines().map(|line| line.expect("UTF-8"));
    let mut told: Vec<String> = Vec::new();
    while !told.last().is_some_and(|line| line.starts_with("wrote ")) {
        told.push(lines.next().unwrap_or_else(|| panic!("no page: {told:?}")));
    }
    assert!(run.try_wait().expect("a child").is_none(), "the study ended before the first page");
    assert!(signal(run.id(), "INT"));
    assert!(run.wait().is_ok(), "the run has ended");
    told.extend(lines);
    let told = told.join("\n");
    assert_eq!(report.wait().expect("a child").code(), Some(0), "{told}");
    assert!(told.matches("wrote ").count() >= 2, "while it runs and at its end: {told}");
    assert!(!fs::read_to_string(&path).expect("the page").contains("http-equiv=\"refresh\""), "it stays now");
    let refused = say(&["report", &out, "--refresh", "10 ms"]);
    assert!(refused.code == 2 || refused.code == 3, "{}: {}", refused.code, refused.err);
    assert!(refused.err.contains("at least 1 s"), "{}", refused.err);
}

/// Two runs with backward whirl push the ring outwards by a quarter of its radius; two runs rub lightly.
#[test]
fn limits_are_listed_and_noted_ones_are_reported_wherever_numbers_are() {
    let folder = Folder::new();
    let turbine = crate::support::root().join("studies/machines/lp_turbine_paper.toml");
    folder.write("turbine.toml", &fs::read_to_string(turbine).expect("the turbine"));
    let study = folder.write(
        "whips.toml",
        "schema = 1\nname = \"whips\"\nmachine = \"turbine.toml\"\n[set]\n\"run.end_time\" = \"0.3 s\"\n\
             \"run.limit.ring_displacement.on_exceed\" = \"note\"\n\"run.guard.penetration\" = 0.2\n\
             [design]\nkind = \"monte-carlo\"\nsamples = 2\n[[uncertain]]\npath = \"contact.gap\"\ndistribution = \"uniform\"\n\
             lower = \"4 mm\"\nupper = \"4.2 mm\"\n[[vary]]\npath = \"contact.friction\"\nvalues = [0.5, 0.05]\n\
             [[question]]\nname = \"loads\"\nprobability = \"max_bearing_load_N > 1 MN\"\n\
             [[gate]]\nrequire = \"P(max_bearing_load_N > 1 MN) < 0.5\"\n",
    );
    let out = folder.name("whips");
    let run = say(&["run", &study, "--out", &out, "--workers", "1"]);
    assert_eq!(run.code, 0, "{}", run.err);
    assert!(
        run.out.contains("hyp2             4             4   4  0       0        0"),
        "all touch, all are ok: {}",
        run.out
    );
    // two of the four runs have a ring displacement of a quarter of the radius: more than five times the limit
    let line = run.out.lines().find(|line| line.contains("ring_displacement ")).expect("a table of limits");
    assert!(line.contains(" mm (0.05 of mean radius)") && line.contains("note         2 of 4 runs  5."), "{line}");
    let unjudged =
        "  ring_yield: not judged: no diaphragms.NAME.material.yield_strength; largest stress of the ok runs ";
    assert!(run.out.contains(unjudged), "{}", run.out);
    let warning = "stresses of ring, blades and shaft are not judged, because no yield_strength is given";
    assert!(
        run.out.find(&format!("warning: {warning}")) < run.out.find("\ndetection "),
        "above the summary: {}",
        run.out
    );
    let said = "2 runs with status ok exceed the limit ring_displacement (largest ratio 5.";
    let (answer, gate) = (say(&["answer", &out]), say(&["gate", &out]));
    assert!(answer.err.contains(said) && gate.err.contains(said), "{} {}", answer.err, gate.err);
    let page = page(&folder, &out, "whips.html");
    assert!(own(&page).contains(said) && own(&page).contains(warning) && page.contains("Limits of the model"));
    // Settings that weaken the meaning of "ok" are reported where results are judged, and before the run.
    let weak = [
        "run.guard.penetration = 0.2 (default 0.02): an ok run may fail the default check",
        "run.limit.ring_displacement.on_exceed = \"note\": a run above this limit stays ok",
    ];
    let check = say(&["check", &study]);
    for text in weak {
        assert!(check.err.contains(&format!("note: {text}")), "{text}: {}", check.err);
        assert!(own(&page).contains(&text.replace('"', "&quot;")) || own(&page).contains(text), "{text}");
    }
    assert!(own(&page).contains("; but see guards, limits below"), "the answers are restricted");

    let study =
        folder.write("light.toml", &fs::read_to_string(&study).expect("written").replace("[0.5, 0.05]", "[0.05]"));
    let out = folder.name("light");
    let run = say(&["run", &study, "--out", &out, "--workers", "1"]);
    assert!(run.out.contains("2             2   2  0") && run.out.contains("note         0 of 2 runs"), "{}", run.out);
    assert!(!say(&["answer", &out]).err.contains("exceed the limit"));
}

#[test]
fn bearings_whose_peak_loads_are_not_the_machines_are_said_wherever_loads_are() {
    let folder = Folder::new();
    let rig = crate::support::root().join("studies/machines/lab_rig.toml");
    folder.write("rig.toml", &fs::read_to_string(rig).expect("the rig"));
    let damped = "schema = 1\nname = \"damped\"\nmachine = \"rig.toml\"\n[set]\n\"run.end_time\" = \"10 ms\"\n\"run.engine\" = \"reduced\"\n\
                  [design]\nkind = \"monte-carlo\"\nsamples = 2\n[[uncertain]]\npath = \"contact.friction\"\ndistribution = \"uniform\"\n\
                  lower = 0.1\nupper = 0.2\n[[vary]]\npath = \"rotor.bearings.right.damping\"\nvalues = [1e6, 10]\n\
                  [[question]]\nname = \"loads\"\nprobability = \"max_bearing_load_N > 1 kN\"\n\
                  [[gate]]\nrequire = \"P(max_bearing_load_N > 1 kN) < 0.5\"\n";
    let said = "the step does not resolve the damping of bearing right: c dt/(2 m) = ";
    let which = "rotor.bearings.right.damping = 1e6 N s/m)";
    let of = "(in 2 of the study's 4 samples; most with ";
    let (study, out) = (folder.write("damped.toml", damped), folder.name("damped"));
    let check = say(&["check", &study]);
    assert!(check.err.contains(said) && check.err.contains(which) && check.err.contains(of), "{}", check.err);
    let run = say(&["run", &study, "--out", &out]);
    assert!(run.code == 0 && run.out.contains(said) && run.out.contains(which), "{} {}", run.out, run.err);
    let (answer, gate) = (say(&["answer", &out]), say(&["gate", &out]));
    assert!(answer.err.contains(said) && gate.err.contains(which), "{} {}", answer.err, gate.err);
    assert!(own(&page(&folder, &out, "damped.html")).contains(said));

    // A step that resolves the damping: 100 times shorter.
    let fine = damped.replace("\"run.engine\"", "\"run.step\" = \"0.03 us\"\n\"run.engine\"");
    assert!(!say(&["check", &folder.write("fine.toml", &fine)]).err.contains("does not resolve"));

    // A bearing so stiff that most of its flexibility is in truncated modes: reported for the exponential engine, too, and for every
    // sample.
    let stiff = damped
        .replace("reduced", "exponential")
        .replace("right.damping\"\nvalues = [1e6, 10]", "right.stiffness\"\nvalues = [1e12, 1e13]");
    let check = say(&["check", &folder.write("stiff.toml", &stiff)]);
    let said = "of the flexibility at bearing right is in truncated modes";
    assert!(
        check.err.contains(said) && check.err.contains("(in 4 of the study's 4 samples; most with "),
        "{}",
        check.err
    );
    assert!(!check.err.contains("does not resolve"), "the exponential engine has no such step: {}", check.err);

    // One excessive damping among 200 values is found at any position, and the step that is suggested resolves it.
    let many = damped.replace("values = [1e6, 10]", "from = 10\nto = 70e3\ncount = 200");
    let check = say(&["check", &folder.write("many.toml", &many)]);
    let line = check.err.lines().find(|line| line.contains("does not resolve")).expect("said");
    assert!(line.contains("of 400: ") && line.contains("right.damping = 70000 N s/m"), "{line}");
    let step = line.split("below ").nth(1).and_then(|rest| rest.split(" resolves").next()).expect("a step");
    let resolved = many.replace("\"run.engine\"", &format!("\"run.step\" = \"{step}\"\n\"run.engine\""));
    let check = say(&["check", &folder.write("resolved.toml", &resolved)]);
    assert!(check.code == 0 && !check.err.contains("does not resolve"), "{step}: {}", check.err);

    // a machine without a study
    let alone = fs::read_to_string(crate::support::root().join("studies/machines/lab_rig.toml")).expect("the rig");
    let alone = alone.replacen("damping = \"600 N s/m\"", "damping = \"1e6 N s/m\"", 1);
    let check = say(&["check", &folder.write("alone.toml", &alone)]);
    assert!(check.err.contains("bearing left is damped so strongly"), "{}", check.err);
}

#[test]
fn limits_of_the_model_are_those_of_their_page() {
    let page = fs::read_to_string(crate::support::root().join("docs/limits.md")).expect("the page");
    let words = |text: &str| text.split_whitespace().collect::<Vec<_>>().join(" ");
    let page = words(&page);
    let [first @ .., _] = bladeoff::html_report::LIMITS;
    for limit in first {
        assert!(page.contains(&words(limit)), "{limit}");
    }
}

/// Path of an installed browser.
pub fn browser() -> Option<&'static str> {
    ["chromium-headless-shell", "chromium"].into_iter().find(|name| {
        let said = Command::new(name).arg("--version").stdout(Stdio::null()).stderr(Stdio::null()).status();
        said.is_ok_and(|status| status.success())
    })
}

#[test]
fn a_browser_draws_every_figure_without_a_word_and_asks_nobody() {
    let folder = Folder::new();
    let Some(browser) = browser() else {
        skipped("the page of `report` in a browser", "no chromium-headless-shell and no chromium");
        return;
    };
    let directory = run(&folder, STUDY);
    let text = page(&folder, &directory, "a.html");
    let figures = own(&text).matches("class=\"plot\"").count();
    assert!(figures >= 9, "{figures}");
    let log = folder.name("net.json");
    let opened = Command::new("timeout")
        .args(["600", browser])
        // the sandbox does not work for root; the proxy address blocks the network
        .args([
            "--headless",
            "--no-sandbox",
            "--disable-gpu",
            "--virtual-time-budget=20000",
            "--proxy-server=127.0.0.1:9",
        ])
        .args(["--disable-background-networking", "--no-first-run", "--enable-logging=stderr", "--v=0"])
        .arg(format!("--user-data-dir={}", folder.name("profile")))
        .arg(format!("--log-net-log={log}"))
        .args(["--dump-dom", &format!("file://{}", folder.name("a.html"))])
        .output()
        .expect("it starts");
    let (dom, told) = (String::from_utf8_lossy(&opened.stdout), String::from_utf8_lossy(&opened.stderr));
    assert!(dom.contains(&format!("data-drawn=\"{figures} of {figures}\"")), "{figures} figures; {told}");
    assert!(dom.matches("class=\"main-svg\"").count() >= figures, "the library has drawn");
    assert!(!dom.contains("data-hostile"), "what the file says was done");
    let console: Vec<&str> = told.lines().filter(|line| line.contains("CONSOLE")).collect();
    assert!(console.is_empty(), "{console:?}");
    // links that the plotting library made from names stay within the page, too
    let body = own(&dom);
    let links = body.split("href=\"").skip(1).map(|rest| rest.split('"').next().unwrap_or_default());
    // a heat map is an image within the page
    let away: Vec<&str> = links.filter(|link| !link.starts_with('#') && !link.starts_with("data:image/png;")).collect();
    assert!(away.is_empty(), "{away:?}");
    let asked = fs::read_to_string(&log).expect("a log of the network");
    assert!(asked.contains("\"constants\""), "it was written");
    assert!(!asked.contains("127.0.0.1:9/x") && !asked.contains("plot.ly") && !asked.contains("plotly.com"));
}

#[test]
fn a_map_of_sixty_thousand_cells_is_no_page_of_ten_megabytes() {
    let folder = Folder::new();
    let study = folder.write(
        "s.toml",
        "schema = 1\nname = \"wide\"\nmodel = \"function\"\n[function]\ng = \"x + y\"\n\
         [[vary]]\nname = \"x\"\nfrom = 0\nto = 1\ncount = 301\n[[vary]]\nname = \"y\"\nfrom = 0\nto = 1\ncount = 201\n\
         [[question]]\nname = \"m\"\nmap = [\"x\", \"y\"]\nof = \"g\"\n",
    );
    let (out, page) = (folder.name("out"), folder.name("out.html"));
    assert_eq!(say(&["run", &study, "--out", &out]).code, 0);
    let said = say(&["report", &out, "--out", &page]);
    assert_eq!(said.code, 0, "{}", said.err);
    let text = fs::read_to_string(&page).expect("the page");
    assert!(text.len() < 5_000_000, "{} bytes", text.len());
    assert!(text.contains("one of 3 values along each axis is drawn"));
    assert!(text.contains("60501 cells, 60501 runs"), "what is told is of all");
}
