//! Contents of an animation.

use super::*;
use crate::figures::{CRITICAL_SPEEDS, contacts};
use crate::page::shell::shell_tests::{base64, sha256};

fn series(name: &str, unit: &str, values: Vec<f64>) -> Series {
    Series { name: name.into(), unit: unit.into(), values }
}

/// A rotor that circles outwards in a ring of 8 nodes while its speed falls; the contact begins at 1.5 s.
fn history(records: u32) -> History {
    let time: Vec<f64> = (0..records).map(|k| 2.0 * f64::from(k) / f64::from(records - 1)).collect();
    let of = |value: &dyn Fn(f64) -> f64| time.iter().map(|t| value(*t)).collect::<Vec<f64>>();
    let radius = |t: f64| 1e-4 * (1.0 + t);
    let angle = |t: f64| 200.0 * t - 25.0 * t * t;
    let touches = |t: f64| if t >= 1.5 { 40.0 } else { 0.0 };
    let mut channels = vec![
        series("rotor.speed_rad_s", "rad/s", of(&|t| 200.0 - 50.0 * t)),
        series("rotor.angle_rad", "rad", of(&angle)),
        series("contact.rotor_x_m", "m", of(&|t| radius(t) * angle(t).cos())),
        series("contact.rotor_y_m", "m", of(&|t| radius(t) * angle(t).sin())),
        series("contact.gap_m", "m", of(&|t| 2.5e-4 - radius(t))),
        series("contact.angle_rad", "rad", of(&angle)),
        series("contact.peak_force_N", "N", of(&touches)),
        series("contact.filtered_force_N", "N", of(&touches)),
    ];
    channels.extend((0..8).map(|node| series(&format!("ring.radial{node:03}_m"), "m", of(&|t| 1e-5 * t))));
    let about = [("contact.gap_m", "0.00025"), (CRITICAL_SPEEDS, "150.0 500.0")];
    let about = about.into_iter().map(|(key, value)| (key.to_owned(), value.to_owned())).collect();
    History { time, channels, about, ..History::default() }
}

fn page(history: &History) -> String {
    animation(history, "a <b> & c", &contacts(history)[0]).expect("places")
}

fn data(page: &str) -> Value {
    let from = page.find("id=\"frames\">").expect("data") + 12;
    let to = from + page[from..].find("</script>").expect("its end");
    serde_json::from_str(&page[from..to]).expect("JSON")
}

#[test]
fn an_animation_has_the_instants_and_marks_of_its_history() {
    let history = history(20_001);
    let page = page(&history);
    let data = data(&page);
    let list = |key: &str| data[key].as_array().expect(key).clone();
    let number = |key: &str, at: usize| list(key)[at].as_f64().expect("a number");
    let count = list("time").len();
    assert!((FRAMES..FRAMES + 3).contains(&count), "{count}");
    for key in ["speed", "clearance", "force", "angle", "from", "to", "ring"] {
        assert_eq!(list(key).len(), count, "{key}");
    }
    // the marked instants are frames: the first contact, and the passage of the one critical speed below 200 rad/s
    let first = data["first"].as_u64().expect("a frame") as usize;
    assert!(
        (number("time", first) - 1.5).abs() < 1e-9 && number("force", first) > 0.0 && number("force", first - 1) == 0.0
    );
    let passed = (0..count).find(|at| (number("time", *at) - 1.0).abs() < 1.5e-4).expect("the passage");
    assert!((number("speed", passed) - 150.0 * 30.0 / std::f64::consts::PI).abs() < 0.1);
    assert!(page.contains(&format!("data-frame=\"{first}\">first contact, 1.5 s<")), "{first}");
    assert!(
        page.contains("critical speed 1432 rpm, 1") && page.matches("<button type=\"button\" data-frame").count() == 2
    );
    // the clearance is that of the history, and the path ends at the rotor's place
    assert!((number("clearance", first) - (250.0 - 250.0)).abs() < 0.1 && (number("clearance", 0) - 150.0).abs() < 0.1);
    let end = number("to", first) as usize - 1;
    let radius = number("x", end).hypot(number("y", end));
    let gap = list("ring")[first][0].as_f64().expect("a radius");
    assert!((gap / radius - (2.5e-4 + 1.5e-5) / 2.5e-4).abs() < 1e-3, "{gap} {radius}");
    // a turn at 125 rad/s is 50 ms: 503 records of 0.1 ms
    let points = number("to", first) - number("from", first);
    assert!((points - 503.0).abs() < 20.0, "{points}");
    assert!(page.contains(&format!("{count} of 20001 instants are shown")) && page.len() < 2_000_000, "{}", page.len());
    assert!(!page.contains("NaN") && page.contains("a &lt;b&gt; &amp; c"));
    assert_eq!(page, super::animation(&history, "a <b> & c", &contacts(&history)[0]).expect("the same bytes"));
}

#[test]
fn numbers_that_are_none_are_not_drawn() {
    let mut history = history(200);
    for channel in history.channels.iter_mut().filter(|channel| channel.name != "rotor.angle_rad") {
        channel.values[190..].fill(f64::NAN);
    }
    history.channels[4].values[100] = f64::INFINITY;
    let page = page(&history);
    assert!(!page.contains("NaN") && !page.contains("inf\"") && !page.contains(":inf"), "{page}");
    assert_eq!(data(&page)["time"].as_array().map(Vec::len), Some(190));
    history.channels[2].values.fill(f64::NAN);
    assert!(animation(&history, "a", &contacts(&history)[0]).is_none());
}

#[test]
fn the_policy_knows_the_script_and_nothing_else_runs() {
    assert_eq!(base64(&sha256(SCRIPT)), HASH);
    assert!(!SCRIPT.contains("</script") && !SCRIPT.contains('\r') && !STYLE.contains("url("));
    let page = page(&history(100));
    assert_eq!(page.matches("<script").count(), 2, "data and the script");
    assert!(page.contains(&format!("'sha256-{HASH}'")) && !page.contains("http://example"));
}
