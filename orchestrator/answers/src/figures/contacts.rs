//! Contacts of a history: groups of channels of rotor and ring at one diaphragm, and when they touch.

use crate::history::{History, Series};

/// The channels of one diaphragm.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Contact {
    /// `contact`, or `contact.NAME` where there are several diaphragms.
    group: String,
    /// `ring`, or `ring.NAME`.
    ring: String,
    /// Its name; "" of a single one.
    pub name: String,
}

/// The contacts that a history has channels of.
#[must_use]
pub fn contacts(history: &History) -> Vec<Contact> {
    let groups = history.channels.iter().filter_map(|channel| channel.name.rsplit_once('.')).map(|(group, _)| group);
    let mut found: Vec<Contact> = Vec::new();
    for group in groups.filter(|group| *group == "contact" || group.starts_with("contact.")) {
        let name = group.strip_prefix("contact.").unwrap_or_default().to_owned();
        if found.iter().all(|known| known.group != group) {
            let ring = if name.is_empty() { "ring".to_owned() } else { format!("ring.{name}") };
            found.push(Contact { group: group.to_owned(), ring, name });
        }
    }
    found
}

impl Contact {
    /// A channel by its field, such as `gap_m`.
    #[must_use]
    pub fn channel<'a>(&self, history: &'a History, field: &str) -> Option<&'a Series> {
        history.channel(&format!("{}.{field}", self.group))
    }

    /// The gap at rest \[m\], in a file with geometry.
    #[must_use]
    pub fn gap(&self, history: &History) -> Option<f64> {
        history.number(&format!("{}.gap_m", self.group)).filter(|gap| gap.is_finite())
    }

    /// Radial displacements of the nodes of the ring, in order; empty where they were not recorded.
    #[must_use]
    pub fn radial<'a>(&self, history: &'a History) -> Vec<&'a Series> {
        (0..).map_while(|node| history.channel(&format!("{}.radial{node:03}_m", self.ring))).collect()
    }

    /// The first instant with a contact force \[s\], as far as the records tell.
    #[must_use]
    pub fn first_contact(&self, history: &History) -> Option<f64> {
        let force = self.channel(history, "peak_force_N").or_else(|| self.channel(history, "filtered_force_N"))?;
        let at = force.values.iter().position(|force| *force > 0.0)?;
        Some(history.time[at])
    }

    /// " of NAME" where there are several.
    #[must_use]
    pub fn of(&self) -> String {
        if self.name.is_empty() { String::new() } else { format!(" of {}", self.name) }
    }
}

/// Instants \[s\] at which the speed first reaches each critical speed that unbalance excites, with that speed \[rad/s\], in the order of time. The
/// file names the critical speeds.
#[must_use]
pub fn critical_passages(history: &History) -> Vec<(f64, f64)> {
    let (Some(known), Some(speed)) = (history.about.get(CRITICAL_SPEEDS), history.channel("rotor.speed_rad_s")) else {
        return Vec::new();
    };
    let reached = |critical: f64| {
        let passes = |pair: &[f64]| (pair[0] - critical) * (pair[1] - critical) <= 0.0;
        let at = speed.values.windows(2).position(passes)?;
        Some((history.time[at + 1], critical))
    };
    let mut passages: Vec<(f64, f64)> =
        known.split_whitespace().filter_map(|text| text.parse().ok()).filter_map(reached).collect();
    passages.sort_by(|a, b| a.0.total_cmp(&b.0));
    passages
}

/// The key of a history's critical speeds: those that unbalance excites, ascending, in rad/s, with spaces between.
pub const CRITICAL_SPEEDS: &str = "critical_speeds_rad_s";

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn contacts_have_the_names_of_their_diaphragms() {
        let series =
            |name: &str, values: &[f64]| Series { name: name.into(), unit: "m".into(), values: values.to_vec() };
        let names = ["rotor.speed_rad_s", "contact.mid.gap_m", "contact.mid.peak_force_N", "contact.end.gap_m"];
        let channels = names.iter().map(|name| series(name, &[9.0, 5.0, 0.0])).collect();
        let about = [(CRITICAL_SPEEDS.to_owned(), "3.0 7.0 20.0".to_owned())].into_iter().collect();
        let history = History { time: vec![0.0, 1.0, 2.0], channels, about, ..History::default() };
        let found = contacts(&history);
        assert_eq!(found.iter().map(|contact| contact.name.as_str()).collect::<Vec<_>>(), ["mid", "end"]);
        assert_eq!((found[0].first_contact(&history), found[1].first_contact(&history)), (Some(0.0), None));
        assert_eq!(critical_passages(&history), [(1.0, 7.0), (2.0, 3.0)]);
    }
}
