//! Progress of a single run on standard error: a bar on a terminal, occasional lines elsewhere.

use super::bar::{Bar, fitting};
use bladeoff_answers::summary::duration;
use bladeoff_core::record::{Follower, Frame};
use bladeoff_model::machine::Machine;
use bladeoff_text::document::units::format_digits;
use std::collections::VecDeque;
use std::io::Write;
use std::time::{Duration, Instant};

/// Time before the bar, or the first line, appears.
const FIRST_AFTER: Duration = Duration::from_secs(2);
const FIRST_LINE_AFTER: Duration = Duration::from_secs(5);
/// Time between two lines, and between two updates of the bar.
const LINE_EVERY: Duration = Duration::from_secs(30);
const BAR_EVERY: Duration = Duration::from_millis(200);
/// Steps between two checks of the clock.
const STEPS: u64 = 64;
/// Number of the last checks that determine the pace: a run becomes slower during contact.
const LOOKS: usize = 25;

/// Forwards a run to another follower, if any, and shows its progress.
pub struct RunWatch<'a> {
    inner: Option<&'a mut dyn Follower>,
    bar: Option<Bar>,
    started: Instant,
    /// Time of the next update.
    due: Instant,
    end_time: f64,
    end_speed: f64,
    /// Times of the last checks, and the simulated time \[s\] at each.
    looks: VecDeque<(Instant, f64)>,
    /// Whether the instant is wanted by the other follower, and by the display.
    wanted: (bool, bool),
}

impl<'a> RunWatch<'a> {
    /// Watch of a run that begins now.
    pub fn new(machine: &Machine, inner: Option<&'a mut dyn Follower>) -> Self {
        let (bar, now) = (Bar::on_terminal(), Instant::now());
        let first = if bar.is_some() { FIRST_AFTER } else { FIRST_LINE_AFTER };
        Self {
            inner,
            bar,
            started: now,
            due: now + first,
            end_time: machine.run.end_time,
            end_speed: machine.run.end_speed,
            looks: VecDeque::from([(now, 0.0)]),
            wanted: (false, false),
        }
    }

    /// Removes the bar.
    pub fn finish(&mut self) {
        self.bar.iter_mut().for_each(Bar::clear);
    }

    fn show(&mut self, time: f64, speed: f64) {
        let now = Instant::now();
        self.looks.push_back((now, time));
        if self.looks.len() > LOOKS {
            self.looks.pop_front();
        }
        let pace = self.looks.front().map_or(0.0, |(then, before)| (time - before) / (now - *then).as_secs_f64());
        let texts = texts(time, speed, (self.end_time, self.end_speed), pace, now - self.started);
        match &mut self.bar {
            Some(bar) => {
                bar.draw(fitting((time / self.end_time).clamp(0.0, 1.0), &texts, Bar::columns()));
                self.due = now + BAR_EVERY;
            }
            None => {
                // a closed standard error does not stop the run
                let _ = writeln!(std::io::stderr(), "{}", texts[0]);
                self.due = now + LINE_EVERY;
            }
        }
    }
}

/// Texts from long to short; `ends`: time and speed at which the run ends, `pace`: simulated seconds per second.
fn texts(time: f64, speed: f64, ends: (f64, f64), pace: f64, elapsed: Duration) -> [String; 3] {
    let of = format!("{} of {}", format_digits(time, "s", 3), format_digits(ends.0, "s", 6));
    let rpm = format!("{of}, {:.0} rpm", speed * 30.0 / std::f64::consts::PI);
    let left = Duration::try_from_secs_f64((ends.0 - time) / pace).ok().filter(|_| pace > 0.0);
    // only an estimate: the run may stop earlier, and contact slows it down
    let left =
        left.map_or("time left not known yet".to_owned(), |left| format!("at this pace {} left", duration(left)));
    let until = if ends.1 > 0.0 {
        format!(" (it ends at {:.0} rpm)", ends.1 * 30.0 / std::f64::consts::PI)
    } else {
        String::new()
    };
    [
        format!("{rpm}{until}, {} s per second, {left} after {}", format_digits(pace, "", 2), duration(elapsed)),
        format!("{rpm}, {left}"),
        of,
    ]
}

impl Follower for RunWatch<'_> {
    fn contact_force(&mut self, diaphragm: usize, time: f64, force: f64) {
        self.inner.iter_mut().for_each(|inner| inner.contact_force(diaphragm, time, force));
    }

    fn goes_on(&mut self, step: u64) -> bool {
        self.inner.as_mut().is_none_or(|inner| inner.goes_on(step))
    }

    fn wants(&mut self, step: u64, time: f64) -> bool {
        let ours = step.is_multiple_of(STEPS) && Instant::now() >= self.due;
        self.wanted = (self.inner.as_mut().is_some_and(|inner| inner.wants(step, time)), ours);
        self.wanted.0 || self.wanted.1
    }

    fn wants_end(&mut self) -> bool {
        // the end instant is for the other follower only
        self.wanted = (self.inner.as_mut().is_some_and(|inner| inner.wants_end()), false);
        self.wanted.0
    }

    fn wants_energies(&self) -> bool {
        self.inner.as_ref().is_some_and(|inner| inner.wants_energies())
    }

    fn begins_again(&self) -> bool {
        self.inner.as_ref().is_none_or(|inner| inner.begins_again())
    }

    fn see(&mut self, frame: &Frame<'_>) {
        if self.wanted.1 {
            self.show(frame.time, frame.speed);
        }
        if self.wanted.0 {
            self.inner.iter_mut().for_each(|inner| inner.see(frame));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use bladeoff_core::engine::simulate;
    use bladeoff_core::record::NoHistory;
    use bladeoff_core::structure::Structure;
    use bladeoff_model::machine::MachineDef;

    #[test]
    fn a_line_has_time_speed_pace_and_what_is_left() {
        let seconds = Duration::from_secs;
        let [long, short, shortest] = texts(1.5, 100.0, (6.0, 0.0), 0.25, seconds(6));
        assert_eq!(long, "1.5 s of 6 s, 955 rpm, 0.25 s per second, at this pace 18 s left after 6.0 s");
        assert_eq!(short, "1.5 s of 6 s, 955 rpm, at this pace 18 s left");
        assert_eq!(shortest, "1.5 s of 6 s");
        assert!(texts(1.5, 100.0, (6.0, 50.0), 0.25, seconds(6))[0].contains("(it ends at 477 rpm)"));
        assert!(texts(0.0, 100.0, (6.0, 0.0), 0.0, seconds(6))[1].ends_with("time left not known yet"));
    }

    /// A follower that takes every third step and the end, and counts.
    #[derive(Default)]
    struct Counting {
        asked: u64,
        seen: u64,
        last: f64,
        limit: Option<u64>,
    }

    impl Follower for Counting {
        fn wants(&mut self, step: u64, _: f64) -> bool {
            self.asked += 1;
            step.is_multiple_of(3)
        }
        fn goes_on(&mut self, step: u64) -> bool {
            self.limit.is_none_or(|limit| step < limit)
        }
        fn wants_end(&mut self) -> bool {
            true
        }
        fn see(&mut self, frame: &Frame<'_>) {
            self.seen += 1;
            self.last = frame.time;
        }
    }

    #[test]
    fn a_run_is_the_same_run_when_it_is_shown_and_the_other_follower_sees_what_it_wants() {
        let text = include_str!("../../../studies/machines/lab_rig.toml").replace("0.6 s", "0.01 s");
        let text = text.replacen("[run]", "[run]\nengine = \"reduced\"", 1);
        let machine = MachineDef::parse("lab_rig.toml", &text).and_then(|machine| machine.build()).expect("valid");
        let structure = Structure::build(&machine, None).expect("buildable");
        let alone = simulate(&machine, &structure, &mut NoHistory).expect("it starts");
        let (mut unwatched, mut watched) = (Counting::default(), Counting::default());
        simulate(&machine, &structure, &mut unwatched).expect("it starts");
        let mut watch = RunWatch::new(&machine, Some(&mut watched));
        watch.due = watch.started;
        let shown = simulate(&machine, &structure, &mut watch).expect("it starts");
        assert!(watch.looks.len() > 1 && watch.due > watch.started, "it was shown");
        assert_eq!(shown, alone);
        assert!(unwatched.seen > 10);
        assert_eq!((watched.asked, watched.seen, watched.last), (unwatched.asked, unwatched.seen, unwatched.last));
        assert!(watched.last > 0.01 - 3e-6, "the end too: {}", watched.last);
        let mut brief = Counting { limit: Some(100), ..Counting::default() };
        simulate(&machine, &structure, &mut RunWatch::new(&machine, Some(&mut brief))).expect("it starts");
        assert_eq!(brief.asked, 100, "it ends when the other has enough");
    }
}
