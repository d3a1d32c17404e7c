//! `[[rotor.shaft]]`: sections to nodes and elements.

use super::path::{below, joined};
use super::places::{self, Line, MOST_ELEMENTS};
use super::reader::Reader;
use crate::machine::model::ShaftElement;
use bladeoff_text::document::units::format_digits;

/// All sections; `None`: not even the nodes are known.
pub(super) fn line(reader: &mut Reader<'_>) -> Option<Line> {
    let sections = reader.layout.group("rotor.shaft").len();
    if sections == 0 {
        if !reader.is_bad_group("rotor.shaft") {
            reader.fail("rotor.shaft", "no shaft section", "[[rotor.shaft]] for each section, from left to right");
        }
        return None;
    }
    let mut nodes = Some(vec![0.0]);
    let mut elements = Some(Vec::new());
    for section in 0..sections {
        let lengths = lengths(reader, section);
        let cross_section = cross_section(reader, section);
        let (Some(list), Some(lengths)) = (&mut nodes, lengths) else {
            nodes = None;
            continue;
        };
        if list.len() + lengths.count() > MOST_ELEMENTS + 1 {
            let path = format!("rotor.shaft[{section}].elements");
            reader.fail(&path, "too many elements", format!("at most {MOST_ELEMENTS} in all sections together"));
            nodes = None;
            continue;
        }
        let start = list.last().copied().unwrap_or(0.0);
        list.extend((1..=lengths.count()).map(|i| start + lengths.up_to(i)));
        match (&mut elements, cross_section) {
            (Some(elements), Some(form)) => {
                elements.extend((0..lengths.count()).map(|i| ShaftElement { length: lengths.of(i), ..form }));
            }
            _ => elements = None,
        }
    }
    let nodes = nodes?;
    if nodes.windows(2).any(|pair| pair[1] <= pair[0]) || !nodes.iter().all(|z| z.is_finite()) {
        reader.fail("rotor.shaft", "element lengths too different to place the nodes", "lengths of similar size");
        return None;
    }
    let mut line = Line { nodes, elements };
    places::split(reader, &mut line);
    Some(line)
}

/// Element lengths of one section.
enum Lengths {
    Equal {
        length: f64,
        count: usize,
    },
    /// Each length, and the sum up to the end of each.
    Listed(Vec<f64>, Vec<f64>),
}

impl Lengths {
    fn count(&self) -> usize {
        match self {
            Lengths::Equal { count, .. } => *count,
            Lengths::Listed(list, _) => list.len(),
        }
    }

    fn of(&self, element: usize) -> f64 {
        match self {
            Lengths::Equal { length, count } => length / *count as f64,
            Lengths::Listed(list, _) => list[element],
        }
    }

    /// Length of the first `count` elements; of the whole section exactly its length.
    fn up_to(&self, count: usize) -> f64 {
        match self {
            Lengths::Equal { length, count: all } => length * (count as f64) / (*all as f64),
            Lengths::Listed(_, sums) => sums[count - 1],
        }
    }
}

fn lengths(reader: &mut Reader<'_>, section: usize) -> Option<Lengths> {
    let table = format!("rotor.shaft[{section}]");
    let path = |key: &str| below(&table, key);
    let (length, elements, list) = (path("length"), path("elements"), path("element_lengths"));
    let given = (reader.is_given(&length), reader.is_given(&elements), reader.is_given(&list));
    match given {
        (true, true, false) => {
            Some(Lengths::Equal { length: reader.number(&length)?, count: reader.count(&elements)? })
        }
        (false, false, true) => {
            let listed = reader.list(&list)?;
            let sums = listed.iter().scan(0.0, |sum, length| {
                *sum += length;
                Some(*sum)
            });
            let sums = sums.collect();
            Some(Lengths::Listed(listed, sums))
        }
        (_, _, true) => {
            reader.fail(&list, "given beside length or elements", "either length and elements, or element_lengths");
            None
        }
        (has_length, has_elements, false) => {
            if !has_length {
                reader.missing_here(&length, "rotor.shaft[i].length");
            }
            if !has_elements {
                reader.missing_here(&elements, "rotor.shaft[i].elements");
            }
            None
        }
    }
}

/// An element of the section without its length.
fn cross_section(reader: &mut Reader<'_>, section: usize) -> Option<ShaftElement> {
    let table = format!("rotor.shaft[{section}]");
    let path = |key: &str| below(&table, key);
    let diameter = reader.number(&path("diameter"));
    let inner_diameter = reader.number(&path("inner_diameter"));
    if let (Some(outer), Some(inner)) = (diameter, inner_diameter)
        && inner >= outer
    {
        let allowed = format!("below diameter = {}", format_digits(outer, "m", 10));
        reader.fail(&path("inner_diameter"), "the bore is not smaller than the shaft", allowed);
        return None;
    }
    let own_or_common = |reader: &Reader<'_>, key: &str| {
        let own = joined(&[&table, ".material.", key]);
        if reader.is_given(&own) { reader.number(&own) } else { reader.number(&below("rotor.material", key)) }
    };
    let young_modulus = own_or_common(reader, "young_modulus");
    let poisson_ratio = own_or_common(reader, "poisson_ratio");
    let density = own_or_common(reader, "density");
    let yield_strength = own_or_common(reader, "yield_strength");
    let (short, long) = (path("shear_coefficient"), path("material.shear_coefficient"));
    if reader.is_given(&short) && reader.is_given(&long) {
        reader.fail(&short, "given twice for this section", format!("either this or {}", &*long));
        return None;
    }
    let common = below("rotor.material", "shear_coefficient");
    let shear = [short, long].into_iter().find(|path| reader.is_given(path)).unwrap_or(common);
    let (diameter, inner_diameter, poisson_ratio) = (diameter?, inner_diameter?, poisson_ratio?);
    let shear_coefficient = match reader.word(&shear) {
        Some("cowper") => Some(cowper(inner_diameter / diameter, poisson_ratio)),
        Some(_) => None,
        None => Some(reader.number(&shear)?),
    };
    Some(ShaftElement {
        length: 0.0,
        diameter,
        inner_diameter,
        young_modulus: young_modulus?,
        poisson_ratio,
        density: density?,
        shear_coefficient,
        yield_strength,
        section,
    })
}

/// Shear coefficient of a hollow circular section.
///
/// ```text
/// k = 6 (1+ν) (1+m²)² / ((7+6ν) (1+m²)² + (20+12ν) m²),  m = inner/outer diameter
/// ```
/// Source: Cowper, The shear coefficient in Timoshenko's beam theory, J. Appl. Mech. 33 (1966), 335-340.
/// Verified by `cowper_gives_the_published_values`.
fn cowper(m: f64, poisson: f64) -> f64 {
    let square = m * m;
    let sum = (1.0 + square) * (1.0 + square);
    6.0 * (1.0 + poisson) * sum / ((7.0 + 6.0 * poisson) * sum + (20.0 + 12.0 * poisson) * square)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cowper_gives_the_published_values() {
        // Solid circle: 6 (1+nu) / (7+6 nu); thin tube: 2 (1+nu) / (4+3 nu) (Cowper 1966, table 1).
        assert!((cowper(0.0, 0.3) - 0.886_363_636_363_636_4).abs() < 1e-15);
        assert!((cowper(1.0, 0.3) - 2.6 / 4.9).abs() < 1e-15);
    }
}
