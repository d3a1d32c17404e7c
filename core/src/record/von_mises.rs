//! Largest von Mises stress of each shaft section, as the square of its equivalent moment, and its largest ratio to the yield strength.

use super::peak::{At, Peak};
use crate::stress::ShaftStresses;
use bladeoff_model::machine::RotorKind;

/// Watches all sections of a shaft; none of a point mass.
#[derive(Debug, Clone)]
pub(super) struct VonMises {
    /// Places of the nodes along the shaft \[m\].
    nodes: Vec<f64>,
    /// Per section: square of the equivalent moment of bending and torsion at one instant [N2 m2], with its node.
    peaks: Vec<(Peak, usize)>,
    /// Per section: square of the ratio of stress and yield strength per square of the equivalent moment; 0 without a yield strength.
    to_ratio: Vec<f64>,
    /// Largest square of that ratio, of all sections; `None` where no section has a yield strength.
    ratio: Option<Peak>,
}

impl VonMises {
    pub fn new(rotor: &RotorKind, stresses: Option<&ShaftStresses>) -> Self {
        let (RotorKind::Shaft(shaft), Some(stresses)) = (rotor, stresses) else {
            return Self { nodes: Vec::new(), peaks: Vec::new(), to_ratio: Vec::new(), ratio: None };
        };
        let mut to_ratio = vec![0.0; stresses.sections()];
        for (element, &section) in shaft.elements.iter().zip(stresses.section_of()) {
            let yields_at = element.yield_strength.map(|strength| stresses.moduli(section).bending * strength);
            to_ratio[section] = yields_at.map_or(0.0, |moment| 1.0 / (moment * moment));
        }
        Self {
            nodes: shaft.nodes.clone(),
            peaks: vec![(Peak::default(), 0); stresses.sections()],
            ratio: to_ratio.iter().any(|factor| *factor > 0.0).then(Peak::default),
            to_ratio,
        }
    }

    /// Takes the square of an equivalent moment of a section, at a node.
    #[inline]
    pub fn see(&mut self, section: usize, square: f64, node: usize, at: At) {
        let (peak, place) = &mut self.peaks[section];
        if peak.value.is_none_or(|largest| square > largest) {
            peak.see(square, at);
            *place = node;
            if let Some(ratio) = self.ratio.as_mut().filter(|_| self.to_ratio[section] > 0.0) {
                ratio.see(self.to_ratio[section] * square, at);
            }
        }
    }

    /// The largest square of a section so far.
    pub fn known(&self, section: usize) -> Option<f64> {
        self.peaks[section].0.value
    }

    /// Peak of the square of a section.
    pub fn of(&self, section: usize) -> Peak {
        self.peaks[section].0
    }

    /// Place along the shaft of the peak of a section \[m\].
    pub fn position(&self, section: usize) -> f64 {
        self.nodes[self.peaks[section].1]
    }

    /// Largest ratio of stress and yield strength of all sections that have one.
    pub fn yield_ratio(&self) -> Option<Peak> {
        self.ratio.map(|square| square.map(f64::sqrt))
    }

    /// Ratio of a section by the square of an equivalent moment; 0 without a yield strength.
    pub fn ratio_of(&self, section: usize, square: f64) -> f64 {
        (self.to_ratio[section] * square).sqrt()
    }

    /// All guards hold.
    pub fn hold(&mut self) {
        self.peaks.iter_mut().for_each(|(peak, _)| peak.hold());
        self.ratio.iter_mut().for_each(Peak::hold);
    }
}
