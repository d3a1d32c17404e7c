//! Unbalances: masses added to or lost from the rotor, and the time of the change.

/// Whether the unbalance is a mass that was added or one that was lost.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum UnbalanceKind {
    /// Mass `m` added at the eccentricity (the paper's choice, default).
    Added,
    /// Mass `m` lost at the eccentricity: all terms with -m.
    Lost,
}

/// Time from which an unbalance is present.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Presence {
    /// Appears at t = 0 (the blade-off, default).
    AtRelease,
    /// Present before t = 0: the run starts from the synchronous steady state that the unbalance causes.
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
    /// Node with which the unbalance rotates: that of its disc, otherwise its own node.
    pub torsional_node: usize,
    /// Mass \[kg\] >= 0.
    pub mass: f64,
    /// Eccentricity \[m\] >= 0.
    pub radius: f64,
    /// Phase in the rotor \[rad\].
    pub phase: f64,
    /// Added or lost.
    pub kind: UnbalanceKind,
    /// Time from which the unbalance is present.
    pub presence: Presence,
    /// Event at which the unbalance appears; `None`: at t = 0, or before.
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

    /// Whether the unbalance is absent at the start of a run with this initial speed \[rad/s\] and appears later.
    #[must_use]
    pub fn is_awaited(&self, initial_speed: f64) -> bool {
        match self.release {
            None => false,
            Some(Release::Time(time)) => time > 0.0,
            Some(Release::Speed(speed)) => speed != initial_speed,
        }
    }
}
