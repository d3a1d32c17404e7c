//! Expected release times of unbalances in a run without contact.
//!
//! ```text
//! J W' = T(W) + sum_k T_k(t), or W(t) as prescribed       crossing of a release speed between two of [`STEPS`] times: linear
//! ```
//! Source: the braking of docs/theory/01-shaft-line.md. Limits: friction and the speed ripple caused by unbalances are neglected. So a run
//! may miss an expected release, and a friction torque may cause others. Verified by the tests below.

use super::unbalance::LinearRotor;
use bladeoff_model::machine::{Machine, Release};

/// Number of time steps of the speed curve.
const STEPS: usize = 2000;

/// Returns the time \[s\] and mean spin \[rad/s\] at which each unbalance appears, in the machine's order; `None` if the run ends before.
#[must_use]
pub fn expected_releases(machine: &Machine) -> Vec<Option<[f64; 2]>> {
    let speed = machine.rotor.initial_speed;
    if machine.rotor.unbalances.iter().all(|unbalance| !unbalance.is_awaited(speed)) {
        return vec![Some([0.0, speed]); machine.rotor.unbalances.len()];
    }
    let course = expected_course(machine);
    let find = |is_passed: &dyn Fn([f64; 2], [f64; 2]) -> Option<f64>| {
        course.windows(2).find_map(|ends| {
            let share = is_passed(ends[0], ends[1])?;
            Some([0, 1].map(|i| ends[0][i] + share * (ends[1][i] - ends[0][i])))
        })
    };
    let unbalances = machine.rotor.unbalances.iter();
    unbalances
        .map(|unbalance| match unbalance.release.filter(|_| unbalance.is_awaited(speed)) {
            None => Some([0.0, speed]),
            Some(Release::Time(time)) => {
                find(&|[from, _], [to, _]| (from < time && time <= to).then(|| (time - from) / (to - from)))
            }
            Some(Release::Speed(speed)) => find(&|[_, from], [_, to]| {
                let [from, to] = [from - speed, to - speed];
                (from * to <= 0.0 && from != to).then(|| from / (from - to))
            }),
        })
        .collect()
}

/// Returns times \[s\] and mean spins \[rad/s\] of a run without contact, up to its end.
#[must_use]
pub fn expected_course(machine: &Machine) -> Vec<[f64; 2]> {
    let (first, h) = (machine.rotor.initial_speed, machine.run.end_time / STEPS as f64);
    let mut course = vec![[0.0, first]];
    if let Some(law) = &machine.rotor.speed_law {
        let corners = law.times.iter().copied().zip(law.speeds.iter().copied());
        let within = corners.filter(|(time, _)| *time > 0.0 && *time < machine.run.end_time);
        course.extend(within.map(|(time, speed)| [time, speed]));
        let after = law.times.iter().position(|time| *time >= machine.run.end_time);
        let end = match after {
            Some(at) if at > 0 => {
                let share = (machine.run.end_time - law.times[at - 1]) / (law.times[at] - law.times[at - 1]);
                law.speeds[at - 1] + share * (law.speeds[at] - law.speeds[at - 1])
            }
            _ => law.speeds.last().copied().unwrap_or(first),
        };
        course.push([machine.run.end_time, end]);
        return course;
    }
    let rotor = LinearRotor::new(machine);
    let mut speed = first;
    for step in 1..=STEPS {
        speed = turned(machine, &rotor, [(step - 1) as f64 * h, h], speed);
        course.push([step as f64 * h, speed]);
        if speed <= machine.run.end_speed {
            break;
        }
    }
    course
}

/// Speed after one step of length `h` from `time` under braking and torques alone \[rad/s\], by the midpoint rule; a prescribed speed does not
/// change.
pub(super) fn turned(machine: &Machine, rotor: &LinearRotor, [time, h]: [f64; 2], speed: f64) -> f64 {
    if machine.rotor.speed_law.is_some() {
        return speed;
    }
    let braking = &machine.braking;
    let torque = machine.torques.iter().map(|torque| torque.moments([time, time + h])[0]).sum::<f64>() / h;
    let taken = |speed: f64| braking.constant + speed * (braking.linear + braking.quadratic * speed);
    let rate = |speed: f64| (torque - braking.table_torque(speed) - taken(speed)) / rotor.inertia;
    let middle = (speed + 0.5 * h * rate(speed)).max(0.0);
    (speed + h * rate(middle)).max(0.0)
}

/// Highest mean spin of a run without contact \[rad/s\].
pub(crate) fn highest_speed(machine: &Machine) -> f64 {
    expected_course(machine).iter().map(|[_, speed]| *speed).fold(machine.rotor.initial_speed, f64::max)
}

#[cfg(test)]
mod tests {
    use super::*;
    use bladeoff_model::machine::MachineDef;

    fn expected(release: &str, more: &str) -> Option<[f64; 2]> {
        let text = format!(
            "schema = 1\nname = \"r\"\n[run]\nend_time = 4\n[rotor]\nkind = \"point-mass\"\nmass = 1\npolar_inertia = 2\ninitial_speed = 100\n\
             [rotor.bearings.b]\nstiffness = 1e4\n[rotor.unbalances.u]\nmass = 0.1\nradius = 0.1\n{release}\n{more}"
        );
        let machine = MachineDef::parse("r.toml", &text).expect("parses").build().expect("valid");
        expected_releases(&machine)[0]
    }

    #[test]
    fn a_release_is_expected_where_the_run_passes_it() {
        let braking = "[braking]\nconstant = 20\n";
        let close = |found: Option<[f64; 2]>, [time, speed]: [f64; 2]| {
            let [t, w] = found.expect("expected");
            assert!((t - time).abs() < 1e-9 && (w - speed).abs() < 1e-9, "{t} {w}");
        };
        close(expected("", braking), [0.0, 100.0]);
        close(expected("release_time = 1.3", braking), [1.3, 87.0]);
        close(expected("release_speed = 90", braking), [1.0, 90.0]);
        let law = "[rotor.speed_law]\nacceleration = 5\n";
        close(expected("release_speed = 110", law), [2.0, 110.0]);
        for never in ["release_time = 4.1", "release_speed = 101", "release_speed = 59"] {
            assert_eq!(expected(never, braking), None, "{never}");
        }
    }
}
