//! Contact force around the ring over time.
//!
//! The force is the 1 ms mean at the closest place of the ring. Of each tile (a span of time, a span of the angle) the largest one is shown;
//! a tile without contact stays white.
//! Verified by `a_force_is_where_and_when_it_acts`.

use super::contacts::Contact;
use super::heat::{Map, map};
use super::style::Scale;
use super::{Figure, FigureError, SpectrumError};
use crate::history::History;
use std::f64::consts::PI;

/// Tiles over time and around the ring.
const COLUMNS: usize = 260;
const ROWS: usize = 72;

/// The largest force \[N\] of each tile by column and row, NaN without contact, and the times that the columns span.
struct Tiles {
    columns: Vec<Vec<f64>>,
    span: (f64, f64),
}

fn tiles(time: &[f64], angle: &[f64], force: &[f64]) -> Option<Tiles> {
    let acts = |at: &usize| force[*at] > 0.0;
    let first = (0..time.len()).find(acts)?;
    let last = (0..time.len()).rfind(acts)?;
    // some room, within the records, so that a single impact is seen
    let room = (0.02 * (time[last] - time[first])).max(1e-3);
    let (from, to) = ((time[first] - room).max(time[0]), (time[last] + room).min(time[time.len() - 1]));
    let to = if to > from { to } else { from + room };
    let mut columns = vec![vec![f64::NAN; ROWS]; COLUMNS];
    for at in (first..=last).filter(acts) {
        let column = (((time[at] - from) / (to - from) * COLUMNS as f64) as usize).min(COLUMNS - 1);
        let row = ((angle[at].rem_euclid(2.0 * PI) / (2.0 * PI) * ROWS as f64) as usize).min(ROWS - 1);
        let tile = &mut columns[column][row];
        *tile = tile.max(force[at]);
    }
    Some(Tiles { columns, span: (from, to) })
}

/// Draws the contact force of one diaphragm over the span of time with contact. `None` without its channels.
///
/// # Errors
/// No contact.
pub fn contact_map(history: &History, name: &str, contact: &Contact) -> Result<Option<Figure>, FigureError> {
    let channel = |field| contact.channel(history, field);
    let (Some(angle), Some(force)) = (channel("angle_rad"), channel("filtered_force_N")) else { return Ok(None) };
    let Some(mut tiles) = tiles(&history.time, &angle.values, &force.values) else {
        return Err(SpectrumError::NoContact { channel: force.name.clone() }.into());
    };
    let largest = tiles.columns.iter().flatten().copied().fold(0.0, f64::max);
    let scale = Scale::of("N", largest);
    tiles.columns.iter_mut().flatten().for_each(|force| *force *= scale.factor);
    let degrees = 360.0 / ROWS as f64;
    let milliseconds = 1e3 * (tiles.span.1 - tiles.span.0) / COLUMNS as f64;
    let title = format!("{name}: contact force around the ring{}", contact.of());
    let figure = map(&Map {
        title: &title,
        note: &format!(
            "largest of each {degrees:.0}° and {} ms; white: no contact in the records; 0° is the diaphragm's X axis, 90° its Y axis",
            crate::drawing::shown(milliseconds)
        ),
        x_label: "time [s]",
        y_label: "angle of the closest place [°]",
        z_label: &scale.label("contact force, 1 ms mean"),
        x_range: tiles.span,
        y_range: (0.0, 360.0),
        y_labels: 9,
        columns: &tiles.columns,
        z_range: (0.0, largest * scale.factor),
        lines: &[],
    });
    Ok(Some(figure))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_force_is_where_and_when_it_acts() {
        let time: Vec<f64> = (0..1000).map(|k| f64::from(k) * 1e-3).collect();
        let mut force = vec![0.0; 1000];
        let mut angle = vec![0.1; 1000];
        // two instants at 90 degrees, given a turn lower, and one at 0 degrees
        (force[400], force[401], force[700]) = (5.0, 8.0, 2.0);
        (angle[400], angle[401], angle[700]) = (-1.5 * PI, -1.5 * PI, 0.0);
        let found = tiles(&time, &angle, &force).expect("contact");
        assert!(found.span.0 < 0.4 && found.span.1 > 0.7 && found.span.1 - found.span.0 < 0.32, "{:?}", found.span);
        let acts: Vec<(usize, usize, f64)> = (0..COLUMNS)
            .flat_map(|column| (0..ROWS).map(move |row| (column, row)))
            .map(|(column, row)| (column, row, found.columns[column][row]))
            .filter(|tile| !tile.2.is_nan())
            .collect();
        let rows: Vec<(usize, f64)> = acts.iter().map(|tile| (tile.1, tile.2)).collect();
        assert_eq!(rows, [(18, 8.0), (0, 2.0)], "{acts:?}");
        assert!(tiles(&time, &angle, &vec![0.0; 1000]).is_none());
    }
}
