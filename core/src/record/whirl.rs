//! Whirl of the rotor during rub, and the rub regime of the run.
//!
//! ```text
//! gamma' = (x y' - y x')/(x^2 + y^2)      turning rate of the rotor centre about the diaphragm's centre       (1)
//! window  = one revolution of the shaft or of the rotor centre about the diaphragm, whichever ends first
//! share   = (time in impacts)/(length of the window); an impact ends when the gap has stayed open for 1 ms
//! ```
//! Regime of a run, the worst of all windows:
//! - `free`: no contact;
//! - `light`: intermittent contact: the share stays below 0.5 in every complete window;
//! - `heavy`: a window with a share of at least 0.5;
//! - `backward-whirl`: in successive heavy windows, the rotor centre moves against the spin by a full revolution.
//!
//! Direction of whirl in rub: `forward` (with the spin) or `backward` if (1) has that sign for at least 90 % of the time in contact,
//! otherwise `mixed`.
//!
//! Source: common usage (Muszynska 2005, ch. 6: partial and full annular rub, dry whip); the numbers 0.5 and 0.9 are ours. The last,
//! incomplete window counts if the rotor stopped (it never completes a revolution), and if a failure or a limit ended the run in contact.
//! A run cut by `end_time` or `end_speed` excludes it. Limits: such a window may be short, but not shorter than the filter of 1 ms
//! unless the rotor stopped. Verified by the tests below and `tests/runs/stresses.rs`.

use super::filter::FILTER;
use super::peak::At;
use super::row::Row;
use bladeoff_model::outcome::EndCause;

/// Contact share of a window from which rub is heavy.
const HEAVY_SHARE: f64 = 0.5;
/// Share of the contact time from which the direction of whirl is forward or backward.
const DIRECTION_SHARE: f64 = 0.9;
const TURN: f64 = 2.0 * std::f64::consts::PI;

/// Words of the column `rub_regime`.
const REGIMES: &[&str] = &["free", "light", "heavy", "backward-whirl"];
/// Words of the column `whirl_in_rub`.
const WHIRLS: &[&str] = &["forward", "backward", "mixed"];

/// Motion of the rotor centre in the diaphragm's frame, at one instant.
#[derive(Debug, Clone, Copy)]
pub(super) struct Motion {
    /// Mean spin angle \[rad\].
    pub angle: f64,
    /// Position of the rotor centre \[m\].
    pub place: [f64; 2],
    /// Velocity of the rotor centre \[m/s\].
    pub velocity: [f64; 2],
    /// Whether the step has contact.
    pub touches: bool,
}

/// Recorder of the whirl in one ring, in steps of constant length `dt` \[s\].
#[derive(Debug, Clone, Copy)]
pub(super) struct WhirlRecorder {
    /// Time step \[s\].
    dt: f64,
    /// Window in progress; `None` before the first contact.
    window: Option<Window>,
    /// Time of the last contact step \[s\].
    last_contact: Option<f64>,
    /// Whether a window was heavy.
    heavy: bool,
    /// Whether the rotor centre moved against the spin by a full revolution in heavy windows.
    backward: bool,
    /// Angle of whirl against the spin in successive heavy windows \[rad\], positive.
    against: f64,
    /// Time in contact with whirl in the direction of the spin \[s\].
    with_spin_time: f64,
    /// Time in contact with whirl against the spin \[s\].
    against_spin_time: f64,
}

#[derive(Debug, Clone, Copy)]
struct Window {
    /// Start time \[s\].
    start: f64,
    /// Mean spin angle at the start \[rad\].
    angle: f64,
    /// Whirl angle since the start \[rad\], positive in the direction of the spin.
    turned: f64,
    /// Time in impacts since the start \[s\].
    contact: f64,
}

impl WhirlRecorder {
    pub fn new(dt: f64) -> Self {
        Self {
            dt,
            window: None,
            last_contact: None,
            heavy: false,
            backward: false,
            against: 0.0,
            with_spin_time: 0.0,
            against_spin_time: 0.0,
        }
    }

    /// Records step n. Before the first contact it returns at once.
    #[inline]
    pub fn see(&mut self, now: &Motion, at: At) {
        if self.window.is_some() || now.touches {
            self.follow(now, at, self.dt);
        }
    }

    /// Records several steps from n on, without contact.
    pub fn pass(&mut self, steps: usize, now: &Motion, at: At) {
        if self.window.is_some() {
            self.follow(now, at, self.dt * steps as f64);
        }
    }

    fn follow(&mut self, now: &Motion, at: At, dt: f64) {
        let [x, y] = now.place;
        let [vx, vy] = now.velocity;
        let square = x * x + y * y;
        // a rotor centre that passes through the diaphragm's centre turns by half a revolution at most
        let turned = if square > 0.0 { ((x * vy - y * vx) / square * dt).clamp(-0.5 * TURN, 0.5 * TURN) } else { 0.0 };
        let with_spin = if at.speed < 0.0 { -turned } else { turned };
        let mut window = self.window.unwrap_or(Window { start: at.time, angle: now.angle, turned: 0.0, contact: 0.0 });
        window.turned += with_spin;
        if now.touches {
            let open = self.last_contact.map_or(f64::INFINITY, |last| at.time - last);
            window.contact += if open <= FILTER { open } else { dt };
            self.last_contact = Some(at.time);
            if with_spin > 0.0 {
                self.with_spin_time += dt;
            } else if with_spin < 0.0 {
                self.against_spin_time += dt;
            }
        }
        if (now.angle - window.angle).abs() >= TURN || window.turned.abs() >= TURN {
            self.close(&window, at.time);
            window = Window { start: at.time, angle: now.angle, turned: 0.0, contact: 0.0 };
        }
        self.window = Some(window);
    }

    /// Records the end of the run, and judges the last, incomplete window if it counts.
    pub fn finish(&mut self, cause: EndCause, time: f64) {
        let Some(window) = self.window else { return };
        let touches = self.last_contact.is_some_and(|last| time - last <= FILTER.max(1.5 * self.dt));
        let counts = match cause {
            EndCause::Stopped => true,
            EndCause::Failure | EndCause::Limit => touches && time - window.start >= FILTER,
            _ => false,
        };
        // a window that has just begun contains no contact to judge
        if counts && window.contact > 0.0 {
            self.close(&window, time);
        }
    }

    fn close(&mut self, window: &Window, time: f64) {
        let heavy = window.contact >= HEAVY_SHARE * (time - window.start);
        self.heavy |= heavy;
        self.against = if heavy && window.turned < 0.0 { self.against - window.turned } else { 0.0 };
        self.backward |= self.against >= TURN;
    }

    /// Merges the whirl in another ring: the worse regime, the sums of the times.
    pub fn include(&mut self, other: &Self) {
        self.last_contact = self.last_contact.into_iter().chain(other.last_contact).reduce(f64::max);
        self.heavy |= other.heavy;
        self.backward |= other.backward;
        self.with_spin_time += other.with_spin_time;
        self.against_spin_time += other.against_spin_time;
    }

    /// Index of the direction in [`WHIRLS`]; `None` without contact.
    fn whirl(&self) -> Option<usize> {
        self.last_contact?;
        let (with, against) = (self.with_spin_time, self.against_spin_time);
        let all = with + against;
        Some(if with >= DIRECTION_SHARE * all && all > 0.0 {
            0
        } else if against >= DIRECTION_SHARE * all && all > 0.0 {
            1
        } else {
            2
        })
    }

    /// Index of the regime in [`REGIMES`].
    fn regime(&self) -> usize {
        match (self.last_contact, self.backward, self.heavy) {
            (None, ..) => 0,
            (Some(_), true, _) => 3,
            (Some(_), false, true) => 2,
            (Some(_), false, false) => 1,
        }
    }

    pub fn report(of: Option<&Self>, row: &mut Row<'_>) {
        row.choice(
            "rub_regime",
            REGIMES,
            "worst rub of the run: free, light (intermittent), heavy (in impacts for at least half of a turn), backward-whirl \
             (heavy, and the rotor centre turned against the spin by a whole turn)",
            of.map(Self::regime),
        );
        row.choice(
            "whirl_in_rub",
            WHIRLS,
            "sense in which the rotor centre turns about the diaphragm's centre, relative to the spin: forward or backward for at \
             least 90 % of the time in contact, otherwise mixed; null without contact",
            of.and_then(Self::whirl),
        );
        row.growing(
            "backward_whirl_time_s",
            "s",
            "time in contact with the rotor centre turning against the spin",
            of.map(|whirl| whirl.against_spin_time),
        );
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A circular orbit at `whirl` rad/s with a spin of 100 rad/s for 1 s; `touches`: contact as a function of time.
    fn orbit(whirl: f64, touches: impl Fn(f64) -> bool) -> (&'static str, Option<&'static str>) {
        let (dt, spin) = (1e-4, 100.0);
        let mut recorder = WhirlRecorder::new(1e-4);
        for step in 0..10_000 {
            let time = f64::from(step) * dt;
            let (sin, cos) = (whirl * time).sin_cos();
            let now = Motion {
                angle: spin * time,
                place: [cos, sin],
                velocity: [-whirl * sin, whirl * cos],
                touches: touches(time),
            };
            recorder.see(&now, At { time, speed: spin });
        }
        (REGIMES[recorder.regime()], recorder.whirl().map(|place| WHIRLS[place]))
    }

    #[test]
    fn each_regime_is_told_by_its_orbit() {
        assert_eq!(orbit(100.0, |_| false), ("free", None));
        // one impact of 5 ms per revolution of 63 ms
        assert_eq!(orbit(100.0, |t| t % 0.0628 < 5e-3), ("light", Some("forward")));
        assert_eq!(orbit(100.0, |t| t > 0.5), ("heavy", Some("forward")));
        assert_eq!(orbit(-300.0, |t| t > 0.5), ("backward-whirl", Some("backward")));
        // pressed against one place while the shaft turns
        assert_eq!(orbit(0.0, |_| true), ("heavy", Some("mixed")));
    }

    #[test]
    fn a_short_swing_against_the_spin_is_no_backward_whirl() {
        // oscillation with an amplitude of 0.3 rad
        let mut recorder = WhirlRecorder::new(1e-4);
        let dt = 1e-4;
        for step in 0..10_000 {
            let time = f64::from(step) * dt;
            let angle = 0.3 * (50.0 * time).sin();
            let rate = 15.0 * (50.0 * time).cos();
            let place = [angle.cos(), angle.sin()];
            let velocity = [-rate * angle.sin(), rate * angle.cos()];
            let now = Motion { angle: 100.0 * time, place, velocity, touches: true };
            recorder.see(&now, At { time, speed: 100.0 });
        }
        assert_eq!(REGIMES[recorder.regime()], "heavy");
        assert_eq!(recorder.whirl().map(|place| WHIRLS[place]), Some("mixed"));
    }

    #[test]
    fn a_rotor_that_stops_within_a_turn_rubs_heavily() {
        let ended = |cause: EndCause, touches: fn(f64) -> bool| {
            let mut recorder = WhirlRecorder::new(1e-4);
            for step in 0..500 {
                let time = f64::from(step) * 1e-4;
                // half a revolution until the rotor stops
                let angle = 100.0 * time * (1.0 - 10.0 * time);
                let now = Motion { angle, place: [1.0, 0.0], velocity: [0.0; 2], touches: touches(time) };
                recorder.see(&now, At { time, speed: 100.0 * (1.0 - 20.0 * time) });
            }
            recorder.finish(cause, 0.05);
            REGIMES[recorder.regime()]
        };
        assert_eq!(ended(EndCause::Stopped, |t| t > 0.01), "heavy");
        assert_eq!(ended(EndCause::Failure, |t| t > 0.01), "heavy");
        assert_eq!(ended(EndCause::Limit, |t| t > 0.01), "heavy");
        assert_eq!(ended(EndCause::EndTime, |t| t > 0.01), "light");
        assert_eq!(ended(EndCause::EndSpeed, |t| t > 0.01), "light");
        // one bounce at the start, then free until the rotor stops
        assert_eq!(ended(EndCause::Stopped, |t| t < 0.01), "light");
        assert_eq!(ended(EndCause::Failure, |t| t < 0.03), "light");
        assert_eq!(ended(EndCause::Stopped, |_| false), "free");
    }

    #[test]
    fn chatter_within_an_impact_counts_as_contact() {
        // contact in every second step only, as chattering multipliers produce it
        let (regime, _) = orbit(100.0, |t| ((t * 1e4).round() as u64).is_multiple_of(2));
        assert_eq!(regime, "heavy");
    }
}
