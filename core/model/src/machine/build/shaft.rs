//! `[[rotor.shaft]]`: nodes and elements from sections.

use super::path::{below, joined};
use super::places::{self, Line, MOST_ELEMENTS};
use super::reader::Reader;
use crate::machine::model::ShaftElement;
use bladeoff_text::document::units::format_digits;

/// All sections; `None`: even the nodes are unknown.
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
        let cross_section = Form::read(reader, &format!("rotor.shaft[{section}]"));
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
                let whole = lengths.up_to(lengths.count());
                let place = |i: usize| if i == 0 { 0.0 } else { lengths.up_to(i) / whole };
                elements
                    .extend((0..lengths.count()).map(|i| form.part([place(i), place(i + 1)], lengths.of(i), section)));
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

    /// Length of the first `count` elements; for all elements exactly the section's length.
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

/// Shear deformation of a section.
#[derive(Clone, Copy)]
enum Shear {
    Cowper,
    Coefficient(f64),
    Rigid,
}

/// Cross-sections of a table: diameters at both ends, linear between them, and material.
pub(super) struct Form {
    /// Outer and inner diameter at the start and at the end \[m\].
    ends: [[f64; 2]; 2],
    young_modulus: f64,
    poisson_ratio: f64,
    density: f64,
    yield_strength: Option<f64>,
    shear: Shear,
}

impl Form {
    /// Reads the table of a section or a layer.
    pub(super) fn read(reader: &mut Reader<'_>, table: &str) -> Option<Self> {
        let path = |key: &str| below(table, key);
        let start = [reader.number(&path("diameter")), reader.number(&path("inner_diameter"))];
        let keys = ["end_diameter", "end_inner_diameter"];
        let end = [0, 1].map(|i| {
            let key = path(keys[i]);
            if reader.is_given(&key) { reader.number(&key) } else { start[i] }
        });
        for (ends, names) in [(start, ["diameter", "inner_diameter"]), (end, keys)] {
            if let [Some(outer), Some(inner)] = ends
                && inner >= outer
            {
                // reported at the key that causes the mistake: an end may have the bore or the diameter of the start
                let at = if reader.is_given(&path(names[1])) { names[1] } else { names[0] };
                let allowed = if at == names[1] {
                    format!("below {} = {}", names[0], format_digits(outer, "m", 10))
                } else {
                    format!("above {} = {}", names[1], format_digits(inner, "m", 10))
                };
                reader.fail(&path(at), "the bore is not smaller than the shaft", allowed);
                return None;
            }
        }
        let own_or_common = |reader: &Reader<'_>, key: &str| {
            let own = joined(&[table, ".material.", key]);
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
        let ends = [[start[0]?, start[1]?], [end[0]?, end[1]?]];
        let shear = match reader.word(&shear) {
            Some("cowper") => Shear::Cowper,
            Some(_) => Shear::Rigid,
            None => Shear::Coefficient(reader.number(&shear)?),
        };
        let (young_modulus, poisson_ratio, density) = (young_modulus?, poisson_ratio?, density?);
        Some(Self { ends, young_modulus, poisson_ratio, density, yield_strength, shear })
    }

    /// An element between two fractions of the length, with a given length \[m\], of a section. Its shear coefficient is that of its middle.
    pub(super) fn part(&self, [from, to]: [f64; 2], length: f64, section: usize) -> ShaftElement {
        let at = |xi: f64| [0, 1].map(|i| self.ends[0][i] + xi * (self.ends[1][i] - self.ends[0][i]));
        let ([diameter, inner_diameter], [end_diameter, end_inner_diameter]) = (at(from), at(to));
        let ratio = (inner_diameter + end_inner_diameter) / (diameter + end_diameter);
        let shear_coefficient = match self.shear {
            Shear::Cowper => Some(cowper(ratio, self.poisson_ratio)),
            Shear::Coefficient(k) => Some(k),
            Shear::Rigid => None,
        };
        ShaftElement {
            length,
            diameter,
            inner_diameter,
            end_diameter,
            end_inner_diameter,
            young_modulus: self.young_modulus,
            poisson_ratio: self.poisson_ratio,
            density: self.density,
            shear_coefficient,
            yield_strength: self.yield_strength,
            section,
        }
    }
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
