//! Columns of the result table, declared by the recorders that fill them.

/// Most columns of an outcome, limited by the messages between processes. The widest machine that the input allows has fewer.
pub const MAX_COLUMNS: usize = 2048;

/// Storage type of a column.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ColumnKind {
    /// f64.
    Real,
    /// A count: u64 in the table, exact in f64 below 2^53.
    Count,
    /// One of these words: text in the table, its index in an [`super::Outcome`].
    Choice(&'static [&'static str]),
}

/// Subject of a column. Displays of a run show the columns of a group together.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Group {
    /// Course and end of the run.
    Course,
    /// Bearing loads.
    BearingLoads,
    /// Contact, rub and whirl.
    Contact,
    /// Work and energy.
    Energy,
    /// Internal moments and stresses.
    Stresses,
    /// Steps, iterations, errors and twin runs.
    Numerics,
    /// Outputs of a study without a machine.
    Functions,
}

impl Group {
    /// All groups in display order.
    pub const ALL: [Group; 7] = [
        Group::Course,
        Group::BearingLoads,
        Group::Contact,
        Group::Energy,
        Group::Stresses,
        Group::Numerics,
        Group::Functions,
    ];

    /// Heading of the group.
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

/// Part of a quantity in a column.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Part {
    /// The whole quantity.
    Whole,
    /// The value of a peak; the next column has its time, the one after that the speed.
    Peak,
    /// Time of the peak.
    PeakTime,
    /// Mean spin at the peak.
    PeakSpeed,
    /// In a row that is not `ok`, the value of another column while all guards held ([`Column::guarded`]); null in a row that is `ok`.
    Guarded,
}

/// Course of a column's quantity during a run.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Growth {
    /// Rises and falls, or known at the end only.
    Free,
    /// Time of a first event; constant once the event has happened.
    Once,
    /// Never decreases during a run.
    Grows,
}

/// Meaning of an empty cell of a row that is `ok`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Empty {
    /// The event or motion that the column measures did not occur.
    Absent,
    /// The run has no such quantity: an empty cell has no meaning.
    Unjudged,
}

/// Prefix of columns with values reached while all guards held; the name of the other column follows. No other column has this prefix.
const GUARDED: &str = "guarded_";

/// One numeric column.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Column {
    /// Name; ends with the SI unit if there is a unit.
    pub name: String,
    /// SI unit, "" for a pure number.
    pub unit: &'static str,
    /// Storage type.
    pub kind: ColumnKind,
    /// Meaning in one sentence.
    pub meaning: String,
    /// Subject.
    pub group: Group,
    /// Part of the quantity.
    pub part: Part,
    /// Course of the quantity during a run.
    pub growth: Growth,
    /// Whether another column has the value reached while all guards and limits held.
    pub is_guarded: bool,
    /// Meaning of an empty cell of a row that is `ok`.
    pub empty: Empty,
    /// Part or key that the machine needs for this column; without that part the column is empty in every row.
    pub lacks: Option<String>,
}

impl Column {
    /// Whether the quantity never decreases during a run, such as a largest value, an impulse or a count. The value of a run that ended
    /// early is then a lower bound of that of the whole run.
    #[must_use]
    pub fn grows(&self) -> bool {
        self.growth == Growth::Grows
    }

    /// Name of the column with the value reached while all guards and limits held; `None` if no such column exists. That column is null in
    /// rows that are `ok`, whose own value is valid.
    #[must_use]
    pub fn guarded(&self) -> Option<String> {
        self.is_guarded.then(|| format!("{GUARDED}{}", self.name))
    }
}
