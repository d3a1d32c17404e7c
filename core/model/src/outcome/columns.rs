//! Columns of the result table. The recorders that fill them declare them.

/// Columns of an outcome at most: what a message between processes carries. The widest machine that the input allows has fewer.
pub const MAX_COLUMNS: usize = 2048;

/// How a column is stored.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ColumnKind {
    /// f64.
    Real,
    /// A count: u64 in the table, exact in f64 below 2^53.
    Count,
    /// One of these words: text in the table, its index in an [`super::Outcome`].
    Choice(&'static [&'static str]),
}

/// What a column tells of: who shows a run shows the columns of a group together.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Group {
    /// How the run went and ended.
    Course,
    /// Loads of the bearings.
    BearingLoads,
    /// Contact, rub, whirl.
    Contact,
    /// Works and energies.
    Energy,
    /// Internal moments and stresses.
    Stresses,
    /// Steps, iterations, errors, twin runs.
    Numerics,
    /// Outputs of a study without a machine.
    Functions,
}

impl Group {
    /// Every group, in the order in which they are shown.
    pub const ALL: [Group; 7] = [
        Group::Course,
        Group::BearingLoads,
        Group::Contact,
        Group::Energy,
        Group::Stresses,
        Group::Numerics,
        Group::Functions,
    ];

    /// In words.
    #[must_use]
    pub fn heading(self) -> &'static str {
        match self {
            Group::Course => "Course",
            Group::BearingLoads => "Bearing loads",
            Group::Contact => "Contact and rub",
            Group::Energy => "Energy",
            Group::Stresses => "Moments and stresses",
            Group::Numerics => "Numerics",
            Group::Functions => "Functions",
        }
    }
}

/// What a column is of its quantity.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Part {
    /// All of it.
    Whole,
    /// The value of a peak; the next column has its time, the one after that the speed.
    Peak,
    /// When the peak was reached.
    PeakTime,
    /// At which mean spin.
    PeakSpeed,
    /// Of a row that is not `ok`, what another column had reached while all guards held ([`Column::guarded`]); null in one that is.
    Guarded,
}

/// How a column's quantity goes during a run.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Growth {
    /// Up and down, or known at the end only.
    Free,
    /// The time of a first event: once it is there it stays, however the run goes on.
    Once,
    /// It only grows: what it has reached stays reached, however the run goes on.
    Grows,
}

/// Meaning of an empty cell of a row that is `ok`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Empty {
    /// The event or the motion that the column measures did not occur.
    Absent,
    /// The run has no such quantity: an empty cell decides nothing.
    Unjudged,
}

/// How the name of a column of what was reached while all guards held begins; the other column's name follows. No other column begins so.
const GUARDED: &str = "guarded_";

/// One numeric column.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Column {
    /// Name; ends in the SI unit where it has one.
    pub name: String,
    /// SI unit, "" for a pure number.
    pub unit: &'static str,
    /// Storage.
    pub kind: ColumnKind,
    /// What it means, one sentence.
    pub meaning: String,
    /// What it tells of.
    pub group: Group,
    /// What it is of that quantity.
    pub part: Part,
    /// How its quantity goes during a run.
    pub growth: Growth,
    /// Whether a further column has what this one had reached while all guards and limits held.
    pub is_guarded: bool,
    /// Meaning of an empty cell of a row that is `ok`.
    pub empty: Empty,
    /// Part or key that the machine needs for this column; without it the column is empty in every row.
    pub lacks: Option<String>,
}

impl Column {
    /// Whether its quantity only grows during a run, as a largest value, an impulse or a count does: the value of a run that ended early
    /// is a lower bound of what the whole run would have reached.
    #[must_use]
    pub fn grows(&self) -> bool {
        self.growth == Growth::Grows
    }

    /// Name of the further column with what this one had reached while all guards and limits held; `None` without such a column. A row
    /// that is `ok` has null there, since its own value is valid.
    #[must_use]
    pub fn guarded(&self) -> Option<String> {
        self.is_guarded.then(|| format!("{GUARDED}{}", self.name))
    }
}
