//! Largest von Mises stress of each shaft section, kept as the square of its equivalent moment, and its largest ratio to the yield
//! strength.

use super::peak::{At, Peak};
use crate::stress::ShaftStresses;
use bladeoff_model::machine::RotorKind;

/// Recorder of all sections of a shaft; empty for a point mass.
#[derive(Debug, Clone)]
pub(super) struct VonMises {
    /// Axial positions of the nodes \[m\].
    nodes: Vec<f64>,
    /// Per section: largest squared equivalent moment of bending and torsion at one instant [N2 m2], with its node.
    peaks: Vec<(Peak, usize)>,
    /// Per section: factor from the squared equivalent moment to the squared ratio of stress to yield strength \[1/(N2 m2)\]; 0 without a
    /// yield strength.
    to_ratio: Vec<f64>,
    /// Largest squared ratio of all sections \[-\]; `None` if no section has a yield strength.
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

    /// Records a squared equivalent moment of a section at a node [N2 m2].
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

    /// Largest squared equivalent moment of a section so far [N2 m2].
    pub fn known(&self, section: usize) -> Option<f64> {
        self.peaks[section].0.value
    }

    /// Peak of the squared equivalent moment of a section [N2 m2].
    pub fn of(&self, section: usize) -> Peak {
        self.peaks[section].0
    }

    /// Axial position of the peak of a section \[m\].
    pub fn position(&self, section: usize) -> f64 {
        self.nodes[self.peaks[section].1]
    }

    /// Largest ratio of stress to yield strength of all sections with a yield strength \[-\].
    pub fn yield_ratio(&self) -> Option<Peak> {
        self.ratio.map(|square| square.map(f64::sqrt))
    }

    /// Ratio of stress to yield strength of a section \[-\] at a squared equivalent moment [N2 m2]; 0 without a yield strength.
    pub fn ratio_of(&self, section: usize, square: f64) -> f64 {
        (self.to_ratio[section] * square).sqrt()
    }

    /// Marks the values reached so far as guarded.
    pub fn hold(&mut self) {
        self.peaks.iter_mut().for_each(|(peak, _)| peak.hold());
        self.ratio.iter_mut().for_each(Peak::hold);
    }
}
