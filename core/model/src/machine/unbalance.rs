//! Unbalances: masses added to the rotor or lost, and when.

/// Whether the unbalance is a mass that was added or one that was lost.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum UnbalanceKind {
    /// Mass `m` added at the eccentricity (the paper's choice, default).
    Added,
    /// Mass `m` lost there: all rows with -m.
    Lost,
}

/// When an unbalance is there.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Presence {
    /// Appears at t = 0 (the blade-off, default).
    AtRelease,
    /// Was there before: the run starts from the synchronous steady state it causes.
    Before,
}

/// Event at which an unbalance appears, later than t = 0.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Release {
    /// A time \[s\] >= 0.
    Time(f64),
    /// The first time at which the mean spin is at this speed \[rad/s\] > 0, rising or falling.
    Speed(f64),
}

/// Unbalance at a node.
#[derive(Debug, Clone, PartialEq)]
pub struct Unbalance {
    /// Name of its table.
    pub name: String,
    /// Node of the unbalance.
    pub node: usize,
    /// Node with which it turns: that of its disc, or its own.
    pub torsional_node: usize,
    /// Mass \[kg\] >= 0.
    pub mass: f64,
    /// Eccentricity \[m\] >= 0.
    pub radius: f64,
    /// Phase in the rotor \[rad\].
    pub phase: f64,
    /// Added or lost.
    pub kind: UnbalanceKind,
    /// Since when.
    pub presence: Presence,
    /// Event at which it appears; `None`: at t = 0, or before.
    pub release: Option<Release>,
}

impl Unbalance {
    /// Mass \[kg\], negative for a lost one.
    #[must_use]
    pub fn signed_mass(&self) -> f64 {
        match self.kind {
            UnbalanceKind::Added => self.mass,
            UnbalanceKind::Lost => -self.mass,
        }
    }

    /// Whether it appears during a run that starts at a speed \[rad/s\]: at its start it is absent.
    #[must_use]
    pub fn is_awaited(&self, initial_speed: f64) -> bool {
        match self.release {
            None => false,
            Some(Release::Time(time)) => time > 0.0,
            Some(Release::Speed(speed)) => speed != initial_speed,
        }
    }
}
