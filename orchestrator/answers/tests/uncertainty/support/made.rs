//! Synthetic studies for tests, with owned columns.
use bladeoff_answers::estimate::input::{
    Cells, Column, Design, DesignKind, Ended, Group, Label, Layout, Nature, Study,
};
use bladeoff_model::outcome::{Cause, CauseSet, Status};

/// An owned column: name; nature as a letter (given, grows (>), once, limit or free); cells; held values.
pub struct MadeColumn {
    pub name: &'static str,
    pub nature: char,
    pub cells: Vec<Option<f64>>,
    pub held: Vec<Option<f64>>,
    pub unjudged: bool,
}

pub struct Made {
    pub columns: Vec<MadeColumn>,
    pub status: Vec<Status>,
    pub causes: Vec<CauseSet>,
    pub ends: Vec<Ended>,
    pub groups: Vec<Group>,
    pub kind: DesignKind,
    pub scrambled: bool,
    pub replicates: usize,
    pub replicate: Vec<u32>,
    pub complete: bool,
}

impl Made {
    /// A study with ok rows and one group; the columns are free unless changed.
    pub fn new(columns: Vec<(&'static str, Vec<Option<f64>>)>) -> Self {
        let rows = columns[0].1.len();
        let made = |(name, cells): (&'static str, Vec<Option<f64>>)| MadeColumn {
            name,
            nature: 'f',
            cells,
            held: vec![None; rows],
            unjudged: false,
        };
        Self {
            columns: columns.into_iter().map(made).collect(),
            status: vec![Status::Ok; rows],
            causes: vec![CauseSet::default(); rows],
            ends: vec![Ended::Other; rows],
            groups: vec![Group::default()],
            kind: DesignKind::MonteCarlo,
            scrambled: true,
            replicates: 1,
            replicate: vec![0; rows],
            complete: true,
        }
    }

    /// Distributes the rows over these values of an axis, alternately.
    pub fn varied(mut self, path: &str, words: &[&str]) -> Self {
        let group = |word: &&str| Group(vec![(path.to_owned(), Label::Word((*word).to_owned()))]);
        self.groups = words.iter().map(group).collect();
        self.replicate.truncate(self.status.len() / words.len());
        self
    }

    /// Makes a row fail, with these causes, joined by commas.
    pub fn fail(&mut self, row: usize, cause: &str) {
        self.status[row] = Status::Failed;
        self.causes[row] = caused(cause);
    }

    /// Puts a row beyond the model; `ended`: its run ended at the limit.
    pub fn exceed(&mut self, row: usize, cause: &str, ended: bool) {
        self.status[row] = Status::Beyond;
        self.causes[row] = caused(cause);
        self.ends[row] = if ended { Ended::Limit } else { Ended::Other };
    }

    pub fn study(&self) -> Study<'_> {
        fn nature(made: &MadeColumn) -> Nature<'_> {
            match made.nature {
                'g' => Nature::Given,
                'l' => Nature::Limit(Some(&made.held)),
                'o' => Nature::Once(Some(&made.held)),
                '>' => Nature::Grows(Some(&made.held)),
                _ => Nature::Free,
            }
        }
        let columns = self.columns.iter().map(|made| {
            let cells = Cells::Numbers(&made.cells, nature(made));
            Column { name: made.name.to_owned(), unit: String::new(), cells, unjudged: made.unjudged }
        });
        Study {
            columns: columns.collect(),
            status: &self.status,
            causes: &self.causes,
            ends: &self.ends,
            groups: self.groups.clone(),
            design: Design {
                kind: self.kind,
                scrambled: self.scrambled,
                replicates: self.replicates,
                replicate: &self.replicate,
                complete: self.complete,
                layout: Layout::Points,
                share: 1.0,
                refined: false,
            },
        }
    }
}

/// A column of these cells.
pub fn column<'a>(name: &str, unit: &str, cells: Cells<'a>) -> Column<'a> {
    Column { name: name.to_owned(), unit: unit.to_owned(), cells, unjudged: false }
}

/// A set of causes from text.
pub fn caused(words: &str) -> CauseSet {
    let mut set = CauseSet::default();
    words.split(',').for_each(|word| set.insert(Cause::from_word(word).expect("a cause")));
    set
}
