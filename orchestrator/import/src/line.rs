//! Shaft elements in the order of their nodes: the shaft, and the layers on it.

use super::elements::{Beam, Rotor};
use bladeoff_text::document::{Collector, cut};

/// Largest number of elements of a shaft.
const MOST_ELEMENTS: usize = 500;
/// Relative tolerance for equal lengths.
const SAME: f64 = 1e-9;

/// The shaft line.
#[derive(Debug, PartialEq)]
pub struct Line<'a> {
    /// One element between neighbouring nodes, from left to right.
    pub base: Vec<&'a Beam>,
    /// Further elements between the same nodes, in the order of the file.
    pub layers: Vec<&'a Beam>,
    /// Positions of the nodes \[m\].
    pub nodes: Vec<f64>,
}

impl<'a> Line<'a> {
    /// Sorts the elements of a rotor; `None`: problems were reported.
    pub fn of(rotor: &'a Rotor, problems: &mut Collector<'_>) -> Option<Self> {
        if rotor.gap {
            return None;
        }
        let mut sorted: Vec<&Beam> = rotor.beams.iter().collect();
        sorted.sort_by_key(|beam| beam.node);
        let mut line = Self { base: Vec::new(), layers: Vec::new(), nodes: vec![0.0] };
        for beams in sorted.chunk_by(|a, b| a.node == b.node) {
            let expected = line.base.len();
            if beams[0].node != expected {
                let message = format!("no shaft element begins at node {expected}");
                problems.add(beams[0].span.clone(), cut(&beams[0].element, 80), message).allowed =
                    Some("elements with n = 0, 1, 2, ... without a gap".to_owned());
                return None;
            }
            if expected == MOST_ELEMENTS {
                problems.add(beams[0].span.clone(), cut(&beams[0].element, 80), "too many shaft elements").allowed =
                    Some(format!("at most {MOST_ELEMENTS} along the shaft"));
                return None;
            }
            // the innermost element; of several, the first in the file
            let inner = |beam: &Beam| beam.ends[0][1] + beam.ends[1][1];
            let base =
                beams.iter().copied().reduce(|best, beam| if inner(beam) < inner(best) { beam } else { best })?;
            for beam in beams.iter().copied().filter(|beam| !std::ptr::eq(*beam, base)) {
                if (beam.length - base.length).abs() > SAME * base.length {
                    let message = format!("length {} m on an element of {} m", beam.length, base.length);
                    problems.add(beam.span.clone(), cut(&beam.element, 80), message).allowed =
                        Some("the length of the other element between these nodes".to_owned());
                }
                line.layers.push(beam);
            }
            line.nodes.push(line.nodes[expected] + base.length);
            line.base.push(base);
        }
        (!line.base.is_empty()).then_some(line)
    }

    /// Number of the last node.
    pub fn last(&self) -> usize {
        self.base.len()
    }
}

/// Groups neighbouring elements that form one cylinder; all others stay alone.
pub fn runs<'a>(beams: &[&'a Beam]) -> Vec<Vec<&'a Beam>> {
    let mut runs: Vec<Vec<&Beam>> = Vec::new();
    for &beam in beams {
        match runs.iter_mut().find(|run| run.last().is_some_and(|last| last.continues_as(beam))) {
            Some(run) => run.push(beam),
            None => runs.push(vec![beam]),
        }
    }
    runs
}
