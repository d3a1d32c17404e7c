//! Settings with which `ok` promises less: marks of the report.

use crate::report::{own, page};
use crate::support::{Folder, say};
use std::fs;

/// A number of the torsional moment is restricted by modes that the file sets; an approximate detection restricts every number.
#[test]
fn settings_that_weaken_ok_restrict_the_numbers_that_they_concern() {
    let folder = Folder::new();
    let rig = crate::support::root().join("studies/machines/lab_rig.toml");
    folder.write("rig.toml", &fs::read_to_string(rig).expect("the rig"));
    let ask = |column: &str| format!("[[question]]\nname = \"{column}\"\nprobability = \"{column} > 0\"\n");
    let text = format!(
        "schema = 1\nname = \"weak\"\nmachine = \"rig.toml\"\n[set]\n\"run.end_time\" = \"10 ms\"\n\"run.torsional_modes\" = 1\n\
         [design]\nkind = \"monte-carlo\"\nsamples = 4\n[[uncertain]]\npath = \"contact.friction\"\ndistribution = \"uniform\"\n\
         lower = 0.1\nupper = 0.2\n{}{}",
        ask("max_torsional_moment_Nm"),
        ask("max_bearing_load_N")
    );
    let marks = |name: &str, text: &str| -> Vec<String> {
        let (study, out) = (folder.write(&format!("{name}.toml"), text), folder.name(name));
        let run = say(&["run", &study, "--out", &out, "--workers", "1"]);
        assert_eq!(run.code, 0, "{}", run.err);
        let page = page(&folder, &out, &format!("{name}.html"));
        let page = own(&page);
        let after = page.split_once("<section id=\"use\"").expect("the section").1;
        let (section, _) = after.split_once("</section>").expect("its end");
        section.split("<tr>").filter(|row| row.contains("answer ")).map(str::to_owned).collect()
    };
    let found = marks("modes", &text);
    let of = |found: &[String], column: &str| found.iter().find(|row| row.contains(column)).expect("a row").clone();
    let (moment, load) = (of(&found, "max_torsional_moment_Nm"), of(&found, "max_bearing_load_N"));
    assert!(moment.contains("restricted") && moment.contains("see torsional modes below"), "{moment}");
    assert!(load.contains("yes") && !load.contains("restricted"), "{load}");
    let hyp1 = text.replace("\"run.torsional_modes\" = 1", "\"contact.detection\" = \"hyp1\"");
    let load = of(&marks("detection", &hyp1), "max_bearing_load_N");
    assert!(load.contains("restricted") && load.contains("see contact detection below"), "{load}");
}
