//! Settings that weaken the meaning of `ok`, and events after the end of the runs: marks in the report.

use crate::report::{own, page};
use crate::support::{Folder, say};
use std::fs;

/// The torsional moment is restricted by the number of modes that the file sets; an approximate detection restricts every number.
#[test]
fn settings_that_weaken_ok_restrict_the_numbers_that_they_concern() {
    let folder = Folder::new();
    let rig = crate::support::root().join("studies/machines/lab_rig.toml");
    folder.write("rig.toml", &fs::read_to_string(rig).expect("the rig"));
    let ask = |column: &str| format!("[[question]]\nname = \"{column}\"\nprobability = \"{column} > 0\"\n");
    let text = format!(
        "schema = 1\nname = \"weak\"\nmachine = \"rig.toml\"\n[set]\n\"run.end_time\" = \"10 ms\"\n\"run.torsional_modes\" = 1\n\
         [design]\nkind = \"monte-carlo\"\nsamples = 4\n[[uncertain]]\npath = \"contact.friction\"\ndistribution = \"uniform\"\n\
         lower = 0.1\nupper = 0.2\n{}{}[[gate]]\nrequire = \"P(max_shear_stress_Pa > 1 GPa) < 0.9\"\n",
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
        section.split("<tr>").skip(1).map(str::to_owned).collect()
    };
    let found = marks("modes", &text);
    let of = |found: &[String], text: &str| -> String {
        found.iter().find(|row| row.contains(text)).unwrap_or_else(|| panic!("{text}: {found:#?}")).clone()
    };
    let (moment, load) = (of(&found, "max_torsional_moment_Nm"), of(&found, "max_bearing_load_N"));
    assert!(moment.contains("restricted") && moment.contains("see modes below"), "{moment}");
    assert!(load.contains("yes") && !load.contains("restricted"), "{load}");
    for text in ["gate P(max_shear_stress_Pa", "results of the ok runs"] {
        assert!(of(&found, text).contains("see modes below"), "{text}: {found:?}");
    }
    let modes = of(&found, "torsional modes = 1 (default ");
    assert!(modes.contains("no check of a run finds it"), "{modes}");
    let hyp1 = text.replace("\"run.torsional_modes\" = 1", "\"contact.detection\" = \"hyp1\"");
    let load = of(&marks("detection", &hyp1), "max_bearing_load_N");
    assert!(load.contains("restricted") && load.contains("see contact detection below"), "{load}");
    // A run that ends above its critical speed does not pass through it.
    let early = text.replace("\"run.torsional_modes\" = 1", "\"run.end_speed\" = \"2999 rpm\"").replace("10 ms", "2 s");
    let end = of(&marks("speed", &early), "events after the end of the runs");
    assert!(
        end.contains("no")
            && end.contains("4 of 4 ok runs ended at their end speed, 2999 rpm; what happens at lower speeds"),
        "{end}"
    );
    // Implausible values are reported on the page, too.
    let odd = text.replace("\"run.torsional_modes\" = 1", "\"seal.material.yield_strength\" = \"300 GPa\"");
    let load = of(&marks("odd", &odd), "answer max_bearing_load_N");
    assert!(load.contains("restricted") && load.contains("see implausible values below"), "{load}");
}
