//! Map questions: axes, panels, and starts of a cell.

use super::question::{Check, Given, QuestionDef};
use crate::estimate::formula::closing;
use crate::estimate::input::Label;
use crate::map::{Of, Wanted};

/// Largest number of panels of a map.
const MOST_PANELS: usize = 24;

impl Check<'_> {
    /// Definition of a map from a question with `map`.
    pub(super) fn map(&mut self, def: &QuestionDef, axes: &[String; 2]) -> Option<Wanted> {
        if def.fragility.is_some() {
            self.wrong::<()>("fragility", "a map has no fragility; only a `probability` has");
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
        // parameters on one axis vary together
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
                return self.wrong(
                    "vary",
                    format!("`{column}` is an axis of the map or varies within its cells: it has no panels"),
                );
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
            varied: (x.axis.is_some(), y.axis.is_some()),
            x: x.column,
            y: y.column,
            of,
            starts: names(&starts),
            panels: names(&panels),
            paired,
        })
    }

    /// Checks the numeric parameter of a map axis.
    fn map_axis(&mut self, name: &str) -> Option<Given> {
        let all: Vec<&str> = self.names.given.iter().map(|given| given.column.as_str()).collect();
        match self.one_of(name, &all)[..] {
            [column] if self.names.known.is_number(column) => {
                self.names.given.iter().find(|given| given.column == column).cloned()
            }
            [column] => self.wrong(
                "map",
                format!("`{column}` is a column of words; the axes of a map are parameters with numbers"),
            ),
            [] => {
                let near = self.near(name, &all);
                let message = format!("`{name}` is not a varied parameter or variable of this study{near}");
                let numbers = all.iter().copied().filter(|column| self.names.known.is_number(column)).collect();
                self.none_of("map", message, (name, "two parameters of numbers", numbers))
            }
            ref several => self.wrong("map", format!("`{name}` could be {}", several.join(" or "))),
        }
    }

    /// Quantity of a map: `COLUMN`, `P(CONDITION)` or a condition.
    fn map_of(&mut self, text: &str) -> Option<Of> {
        let start = text.len() - text.trim_start().len();
        let inner = text[start..].strip_prefix('P').map(str::trim_start).and_then(|rest| rest.strip_prefix('('));
        // a variable may have the name P, followed by a parenthesis
        let is_name = !self.names.known.meant("P").is_empty();
        if let Some(inner) = inner {
            return match closing(inner) {
                Some(length) if inner[length + 1..].trim().is_empty() => {
                    self.condition_in("of", &inner[..length], text.len() - inner.len()).map(Of::Probability)
                }
                _ if is_name => self.condition_in("of", text, 0).map(Of::Probability),
                Some(length) => {
                    let rest = inner[length + 1..].trim();
                    self.wrong("of", format!("`{rest}` follows P(CONDITION), and nothing may"))
                }
                None => self.wrong("of", "its bracket is not closed: P(CONDITION)"),
            };
        }
        let is_condition = text.contains(['<', '>', '=', '!']) && self.names.known.meant(text.trim()).is_empty();
        if is_condition {
            return self.condition_in("of", text, 0).map(Of::Probability);
        }
        self.column("of", text.trim()).map(Of::Value)
    }
}
