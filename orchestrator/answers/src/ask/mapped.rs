//! A map: what is asked for, and in words where it is worst and how much of it an event reaches.

use super::answer::Answer;
use super::question::{Check, Given, MOST_PANELS, QuestionDef};
use super::sentence::{counted, percent, prefix};
use crate::estimate::figures::{Figures, Method};
use crate::estimate::formula::closing;
use crate::estimate::input::Label;
use crate::map::{Cell, Map, Of, Shows, Wanted};
use bladeoff_model::document::units::format_digits;

/// "max_bearing_load_N over gap_m and friction, a panel for each detection".
pub(super) fn map_in_words(wanted: &Wanted) -> String {
    let of = match &wanted.of {
        Of::Value(column) => column.clone(),
        Of::Probability(formula) => format!("P({})", formula.text),
    };
    let mut text = format!("map of {of} over {} and {}", wanted.x, wanted.y);
    if !wanted.panels.is_empty() {
        text += &format!(", a panel for each {}", wanted.panels.join(", "));
    }
    if !wanted.starts.is_empty() {
        text += &format!(", starts: {}", wanted.starts.join(", "));
    }
    text
}

/// One answer for each panel, and for each difference.
pub(super) fn answers_of(name: &str, maps: Vec<Map>) -> Vec<Answer> {
    let answer = |map: Map| {
        let mut figures = Figures::over(map.n);
        figures.method = Method::Without;
        figures.approximate = map.is_smoothed();
        figures.notes.clone_from(&map.notes);
        let mut answer = Answer::of(name, "map", map.group.clone(), map.bad, map.confidence, figures);
        answer.sentence = prefix(&map.group) + &sentence(&map);
        answer.map = Some(Box::new(map));
        answer
    };
    maps.into_iter().map(answer).collect()
}

fn sentence(map: &Map) -> String {
    let what = match map.shows {
        Shows::Value | Shows::Probability => map.of.clone(),
        Shows::Median => format!("median of {}", map.of),
        Shows::SmoothedMean | Shows::SmoothedProbability => format!("{}, smoothed,", map.of),
    };
    let less = map.difference.as_ref().map_or(String::new(), |(column, [a, b])| format!(", {column} = {a} less {b},"));
    let mut text = format!("{what}{less} over {} and {}: ", map.x.column, map.y.column);
    let value = |cell: &Cell| cell.estimate_if_bad_harmful.or(cell.estimate);
    let known = || map.cells.iter().filter_map(|cell| Some((value(cell)?, cell)));
    let highest = known().max_by(|a, b| a.0.total_cmp(&b.0));
    let lowest = known().min_by(|a, b| a.0.total_cmp(&b.0));
    let (Some(highest), Some(lowest)) = (highest, lowest) else {
        return text + &format!("no cell has a number, {}", counted(map.n, "run")) + &bad(map);
    };
    let show = |value: f64| if map.is_share() { percent(value) } else { format_digits(value, &map.unit, 4) };
    let at = |cell: &Cell| {
        let along = |axis: &crate::map::Axis, value: f64| format_digits(value, &axis.unit, 4);
        format!("{} and {}", along(&map.x, cell.x), along(&map.y, cell.y))
    };
    if map.difference.is_some() {
        text += &format!("from {} at {} to {} at {}", show(lowest.0), at(lowest.1), show(highest.0), at(highest.1));
    } else {
        text += &format!("at most {}, at {}; at least {}", show(highest.0), at(highest.1), show(lowest.0));
    }
    let cells = map.cells.len();
    if map.is_share() && map.difference.is_none() {
        let more = known().filter(|(share, _)| *share >= 0.5).count();
        let some = known().filter(|(share, _)| *share > 0.0).count();
        text += &format!("; half or more in {}, above 0 in {}", part(more, cells), part(some, cells));
    }
    let regimes = map.regimes.iter().filter_map(|word| {
        let count = map.cells.iter().filter(|cell| cell.regime.as_ref() == Some(word)).count();
        (count > 0).then(|| format!("{word} in {}", part(count, cells)))
    });
    let regimes: Vec<String> = regimes.collect();
    if !regimes.is_empty() {
        text += &format!("; {}", regimes.join(", "));
    }
    let runs = if map.difference.is_some() { "pair" } else { "run" };
    text + &format!("; {}, {}", counted(cells as u64, "cell"), counted(map.n, runs)) + &bad(map)
}

fn part(count: usize, of: usize) -> String {
    percent(count as f64 / of.max(1) as f64) + " of the cells"
}

fn bad(map: &Map) -> String {
    if map.bad == 0 {
        return String::new();
    }
    let cells = map.cells.iter().filter(|cell| cell.bad > 0).count() as u64;
    format!(", {} in {}", counted(map.bad, "bad run"), counted(cells, "cell"))
}

impl Check<'_> {
    /// A map is asked for.
    pub(super) fn map(&mut self, def: &QuestionDef, axes: &[String; 2]) -> Option<Wanted> {
        if def.fragility.is_some() {
            self.wrong::<()>("fragility", "a map has no fragility: it is that of a `probability`");
        }
        let [x, y] = [self.map_axis(&axes[0]), self.map_axis(&axes[1])];
        let of = match &def.of {
            Some(text) => self.map_of(text),
            None => self.wrong("map", "`map = [X, Y]` needs `of = COLUMN`, or `of = \"P(CONDITION)\"`"),
        };
        let asked = match (&def.difference, &def.vary) {
            (Some(values), Some(path)) => Some(self.pair(values, path)?),
            _ => None,
        };
        let (x, y, of) = (x?, y?, of?);
        if x.column == y.column {
            return self.wrong("map", format!("both axes are `{}`", x.column));
        }
        let given = &self.names.given;
        let apart: Vec<&Given> =
            given.iter().filter(|one| one.axis.is_some() && one.axis != x.axis && one.axis != y.axis).collect();
        let (starts, panels): (Vec<&Given>, Vec<&Given>) = apart.into_iter().partition(|one| one.is_angle);
        let values = |column: &str| {
            let found = self.names.varied.iter().find(|(name, _)| name == column);
            found.map(|(_, values)| values.as_slice()).unwrap_or_default()
        };
        // parameters that lie on one axis have their values together
        let mut lengths: Vec<(Option<usize>, usize)> = Vec::new();
        for one in &panels {
            let count = values(&one.column).len().max(1);
            match lengths.iter_mut().find(|(axis, _)| *axis == one.axis) {
                Some((_, known)) => *known = count.max(*known),
                None => lengths.push((one.axis, count)),
            }
        }
        let count = lengths.iter().fold(1usize, |all, (_, count)| all.saturating_mul(*count));
        let names = |of: &[&Given]| of.iter().map(|one| one.column.clone()).collect::<Vec<_>>();
        if count > MOST_PANELS {
            let which = names(&panels).join(", ");
            return self
                .wrong("map", format!("each value of {which} has a panel: {count} are more than {MOST_PANELS}"));
        }
        let paired = match asked {
            Some((column, _)) if !panels.iter().any(|one| one.column == column) => {
                return self
                    .wrong("vary", format!("`{column}` is along the map or a start of its cells: it has no panels"));
            }
            Some((column, pair)) => Some((column, vec![pair])),
            None => panels.iter().find(|one| one.is_detection).map(|one| {
                let values = values(&one.column);
                let less = |value: &Label| [value.clone(), values[0].clone()];
                (one.column.clone(), values.iter().skip(1).map(less).collect())
            }),
        };
        Some(Wanted {
            is_grid: x.axis.is_some() && y.axis.is_some() && x.axis != y.axis,
            x: x.column,
            y: y.column,
            of,
            starts: names(&starts),
            panels: names(&panels),
            paired,
        })
    }

    /// A parameter of numbers along an axis of a map.
    fn map_axis(&mut self, name: &str) -> Option<Given> {
        let all: Vec<&str> = self.names.given.iter().map(|given| given.column.as_str()).collect();
        match self.one_of(name, &all)[..] {
            [column] if self.names.known.is_number(column) => {
                self.names.given.iter().find(|given| given.column == column).cloned()
            }
            [column] => self.wrong("map", format!("`{column}` has words; a map is over two parameters of numbers")),
            [] => {
                let near = self.near(name, &all);
                self.wrong("map", format!("`{name}` is no parameter or variable of this study that varies{near}"))
            }
            ref several => self.wrong("map", format!("`{name}` could be {}", several.join(" or "))),
        }
    }

    /// `COLUMN`, `P(CONDITION)` or a condition.
    fn map_of(&mut self, text: &str) -> Option<Of> {
        let start = text.len() - text.trim_start().len();
        let inner = text[start..].strip_prefix('P').map(str::trim_start).and_then(|rest| rest.strip_prefix('('));
        if let Some(inner) = inner
            && let Some(length) = closing(inner)
            && inner[length + 1..].trim().is_empty()
        {
            return self.condition_in("of", &inner[..length], text.len() - inner.len()).map(Of::Probability);
        }
        let is_condition = text.contains(['<', '>', '=', '!']) && self.names.known.meant(text.trim()).is_empty();
        if is_condition {
            return self.condition_in("of", text, 0).map(Of::Probability);
        }
        self.column("of", text.trim()).map(Of::Value)
    }
}
