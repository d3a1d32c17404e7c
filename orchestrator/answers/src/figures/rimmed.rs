//! Text with a rim, so that it is read on any ground.

use super::FigureError;
use super::style::{FINE, SMALL};
use plotters::element::Text;
use plotters::prelude::{IntoFont, RGBColor};
use plotters::style::text_anchor::Pos;

/// Draws a text by `put`, moved by pixels to the right and down; colours of the rim and of the text.
pub(super) fn rimmed(
    text: &str,
    (right, down): (i32, i32),
    anchor: Pos,
    [rim, ink]: [RGBColor; 2],
    mut put: impl FnMut(Text<'static, (i32, i32), String>) -> Result<(), FigureError>,
) -> Result<(), FigureError> {
    let around = [(-1, 0), (1, 0), (0, -1), (0, 1), (-1, -1), (-1, 1), (1, -1), (1, 1)];
    for (colour, (x, y)) in around.map(|off| (rim, off)).into_iter().chain([(ink, (0, 0))]) {
        let style = SMALL.into_font().color(&colour).pos(anchor);
        put(Text::new(text.to_owned(), ((right + x) * FINE as i32, (down + y) * FINE as i32), style))?;
    }
    Ok(())
}
