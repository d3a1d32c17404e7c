//! Settings of a machine with which the status `ok` guarantees less than with the defaults, one line each, for `check` and the report.
//!
//! All of them are allowed: a convergence study sets modes, a comparison with the article uses `hyp1`, a test of a limit changes the limit. But
//! a reader of results for design has to know them. Verified by `each_setting_that_weakens_ok_is_named`.

use super::build::guard_of;
use super::model::{Detection, Diaphragm, DiaphragmKind, Engine, Machine, OnExceed, RotorKind};
use super::schema::{Need, TWIN_LIMIT_DEFAULT, default_of};
use bladeoff_text::document::units::format_digits;

/// One setting with its consequence.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Reservation {
    /// Part of the machine file: the same word for every machine.
    pub topic: &'static str,
    /// The setting and its consequence, one line.
    pub text: String,
    /// Parts of the names of the result columns concerned; empty: all columns.
    pub columns: &'static [&'static str],
}

impl Machine {
    /// The settings of this machine that weaken `ok`; empty with the defaults.
    #[must_use]
    pub fn reservations(&self) -> Vec<Reservation> {
        let all = |topic, text| Reservation { topic, text, columns: &[] };
        let mut found: Vec<Reservation> = loosened_guards(self).into_iter().map(|text| all("guards", text)).collect();
        found.extend((self.run.twin > 0.0 && self.run.twin_limit > TWIN_LIMIT_DEFAULT).then(|| {
            let [set, usual] = [self.run.twin_limit, TWIN_LIMIT_DEFAULT].map(|value| format_digits(value, "", 3));
            all("sensitivity", format!("run.twin_limit = {set} (default {usual}): a sensitive run may not be named so"))
        }));
        found.extend(loosened_limits(self).into_iter().map(|text| all("limits", text)));
        found.extend(approximate_detection(self).map(|text| all("contact detection", text)));
        found.extend(neglected_gyroscopics(self).map(|text| all("torques", text)));
        found
    }
}

/// Guards that allow more than their defaults.
fn loosened_guards(machine: &Machine) -> Vec<String> {
    let (set, usual) = (&machine.run.guard, guard_of(machine.run.engine));
    let flexible = machine.diaphragms.iter().any(|one| matches!(one.kind, DiaphragmKind::Flexible(_)));
    let largest = [
        ("normal_work", set.normal_work, usual.normal_work),
        ("energy_balance", set.energy_balance, usual.energy_balance),
        ("penetration", set.penetration, usual.penetration),
    ];
    let above = largest.into_iter().filter(|(_, set, usual)| set > usual);
    let below = (flexible && set.impact_steps < usual.impact_steps).then_some((
        "impact_steps",
        set.impact_steps,
        usual.impact_steps,
    ));
    above
        .chain(below)
        .map(|(name, set, usual)| {
            let [set, usual] = [set, usual].map(|value| format_digits(value, "", 3));
            format!("run.guard.{name} = {set} (default {usual}): an ok run may fail the default check")
        })
        .collect()
}

/// Checked limits of the model that allow more than their defaults.
fn loosened_limits(machine: &Machine) -> Vec<String> {
    let judged = machine.run.limits.iter().filter(|one| machine.lacks(one.limit).is_none());
    let mut found = Vec::new();
    for one in judged {
        let name = one.limit.word();
        if let Some(Need::Number(usual)) = default_of(&format!("run.limit.{name}.value"))
            && one.value > usual
        {
            let [set, usual] = [one.value, usual].map(|value| format_digits(value, "", 3));
            found.push(format!(
                "run.limit.{name}.value = {set} (default {usual}): an ok run may exceed the default limit"
            ));
        }
        if let Some(Need::Word("beyond")) = default_of(&format!("run.limit.{name}.on_exceed"))
            && one.on_exceed == OnExceed::Note
        {
            found.push(format!("run.limit.{name}.on_exceed = \"note\": a run above this limit stays ok"));
        }
    }
    found
}

/// The contact on a deformed ring is not at the angle of the rotor centre, unlike on a circle.
fn approximate_detection(machine: &Machine) -> Option<String> {
    let is_flexible = |one: &&Diaphragm| matches!(one.kind, DiaphragmKind::Flexible(_));
    let mut used = machine.diaphragms.iter().filter(is_flexible).filter(|one| one.contact.detection == Detection::Hyp1);
    used.next().map(|one| {
        format!("diaphragms.{}.contact.detection = \"hyp1\": its contact force acts at an approximate place and does work of its own (model_work_J), which changes loads and \
         forces by 15 % and more in a heavy rub; for design use \"hyp2\"",
            one.name
        )
    })
}

/// Torsional vibration changes the gyroscopic moments of the discs, which the exponential engine neglects.
fn neglected_gyroscopics(machine: &Machine) -> Option<String> {
    let is_shaft = matches!(machine.rotor.kind, RotorKind::Shaft(_));
    let neglects = is_shaft && machine.run.engine == Engine::Exponential && !machine.torques.is_empty();
    neglects.then(|| {
        "run.engine = \"exponential\" with torques: it neglects what torsional vibration does to the gyroscopic moments of the discs, 0.4 % of the loads \
         on the shipped turbine, 4 % and more near a bending resonance; compare with \"reduced\""
            .to_owned()
    })
}

#[cfg(test)]
mod tests {
    use super::super::def::MachineDef;

    const RIG: &str = include_str!("../../../../studies/machines/lab_rig.toml");

    fn of(from: &str, to: &str) -> Vec<(&'static str, String)> {
        assert!(RIG.contains(from), "{from}");
        let machine = MachineDef::parse("m.toml", &RIG.replacen(from, to, 1)).and_then(|def| def.build());
        let found = machine.unwrap_or_else(|problems| panic!("{problems}")).reservations();
        found.into_iter().map(|one| (one.topic, one.text)).collect()
    }

    #[test]
    fn each_setting_that_weakens_ok_is_named() {
        assert_eq!(of("[run]\n", "[run]\n"), []);
        for (key, topic, text) in [
            ("guard.normal_work = 1e9", "guards", "run.guard.normal_work = 1e9 (default 0.01)"),
            ("guard.energy_balance = 1e-3", "guards", "run.guard.energy_balance = 0.001 (default 1e-5)"),
            ("guard.penetration = 0.5", "guards", "run.guard.penetration = 0.5 (default 0.02)"),
            ("guard.impact_steps = 0", "guards", "run.guard.impact_steps = 0 (default 20)"),
            ("limit.ring_displacement.value = 9", "limits", "run.limit.ring_displacement.value = 9 (default 0.05)"),
            (
                "limit.ring_displacement.on_exceed = \"note\"",
                "limits",
                "run.limit.ring_displacement.on_exceed = \"note\"",
            ),
            ("twin = 1e-6\ntwin_limit = 0.1", "sensitivity", "run.twin_limit = 0.1 (default 0.02)"),
        ] {
            let found = of("[run]\n", &format!("[run]\n{key}\n"));
            assert!(found.len() == 1 && found[0].0 == topic && found[0].1.starts_with(text), "{key}: {found:?}");
        }
        // a stricter check guarantees more
        for key in ["guard.normal_work = 1e-3", "guard.impact_steps = 64", "limit.ring_displacement.value = 0.01"] {
            assert_eq!(of("[run]\n", &format!("[run]\n{key}\n")), [], "{key}");
        }
        let found = of("detection = \"hyp2\"", "detection = \"hyp1\"");
        assert!(found.len() == 1 && found[0].0 == "contact detection", "{found:?}");
        assert!(found[0].1.starts_with("diaphragms.seal.contact.detection = \"hyp1\""), "{found:?}");
        let torque = "[torques.fan]\nposition = 0.5\nbalance = true\n[run]\n";
        assert_eq!(of("[run]\n", torque), [], "auto takes another engine");
        let found = of("[run]\n", &format!("{torque}engine = \"exponential\"\n"));
        assert!(found.len() == 1 && found[0].0 == "torques", "{found:?}");
    }
}
