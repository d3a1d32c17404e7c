//! Bearings with their supports, and masses, each at its node.

use super::Note;
use super::elements::{Bearing, Disc, PointMass, Rotor};
use super::line::Line;
use bladeoff_text::document::{Collector, cut};
use std::ops::Range;

/// A bearing or seal on the shaft.
#[derive(Debug, PartialEq)]
pub struct Support<'a> {
    pub bearing: &'a Bearing,
    pub pedestal: Option<Pedestal>,
}

/// Support of a bearing; each quantity along X and Y.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Pedestal {
    /// Mass \[kg\].
    pub mass: [f64; 2],
    /// Stiffness \[N/m\].
    pub stiffness: [f64; 2],
    /// Damping \[N s/m\].
    pub damping: [f64; 2],
    /// Elements of the file that the pedestal consists of.
    pub elements: Vec<String>,
}

/// All elements except those of the shaft.
#[derive(Debug, PartialEq)]
pub struct Supports<'a> {
    pub on_shaft: Vec<Support<'a>>,
    pub discs: Vec<&'a Disc>,
    pub masses: Vec<&'a PointMass>,
}

impl<'a> Supports<'a> {
    /// Assigns all elements to nodes; a node that neither the shaft nor a support has is reported.
    pub fn of(rotor: &'a Rotor, line: &Line<'_>, problems: &mut Collector<'_>, notes: &mut Vec<Note>) -> Self {
        let last = line.last();
        let mut linked: Vec<usize> = rotor.bearings.iter().filter_map(|bearing| bearing.link).collect();
        linked.sort_unstable();
        let mut check = |node: usize, span: &Range<usize>, element: &str| {
            let exists = node <= last || linked.binary_search(&node).is_ok();
            if !exists {
                problems.add(span.clone(), cut(element, 80), format!("node {node} does not exist")).allowed =
                    Some(format!("a node of the shaft, 0 to {last}, or one that n_link of a bearing names"));
            }
            exists
        };
        let mut on_shaft = Vec::new();
        for bearing in &rotor.bearings {
            if check(bearing.node, &bearing.span, &bearing.element) && bearing.node <= last {
                let pedestal = match bearing.link {
                    None => None,
                    Some(node) if node <= last => {
                        let message =
                            format!("a bearing between nodes {} and {node} of the shaft is left out", bearing.node);
                        notes.push(Note::new(&bearing.element, message));
                        continue;
                    }
                    Some(node) => pedestal(rotor, node, &bearing.element, notes),
                };
                on_shaft.push(Support { bearing, pedestal });
            }
        }
        let mut discs = Vec::new();
        for disc in &rotor.discs {
            match check(disc.node, &disc.span, &disc.element) {
                true if disc.node <= last => discs.push(disc),
                true => {
                    notes.push(Note::new(&disc.element, "a disc on a support is left out: a pedestal has point masses"))
                }
                false => {}
            }
        }
        let mut masses = Vec::new();
        for mass in &rotor.masses {
            if check(mass.node, &mass.span, &mass.element) && mass.node <= last {
                if mass.mass[0] != mass.mass[1] {
                    let message = "different masses along X and Y cannot turn with the shaft: their mean is taken";
                    notes.push(Note::new(&mass.element, message));
                }
                masses.push(mass);
            }
        }
        // supports that carry no bearing of the shaft
        let stands = |node: usize| rotor.bearings.iter().any(|one| one.node <= last && one.link == Some(node));
        for mass in rotor.masses.iter().filter(|mass| mass.node > last && !stands(mass.node)) {
            notes.push(Note::new(&mass.element, "a mass on a support without a bearing of the shaft is left out"));
        }
        for spring in rotor.bearings.iter().filter(|spring| spring.node > last && !stands(spring.node)) {
            notes.push(Note::new(
                &spring.element,
                "a support below another support, or below no bearing of the shaft, is left out",
            ));
        }
        if on_shaft.is_empty() && !rotor.lost_bearing {
            problems.add(0..0, "", "no bearing on the shaft").allowed = Some("at least one BearingElement".to_owned());
        }
        Self { on_shaft, discs, masses }
    }
}

/// Pedestal from the elements at a support node; `None`: the node is not held, which is noted.
fn pedestal(rotor: &Rotor, node: usize, of: &str, notes: &mut Vec<Note>) -> Option<Pedestal> {
    let mut found = Pedestal::default();
    for spring in rotor.bearings.iter().filter(|spring| spring.node == node) {
        let mut note = |message: &str| {
            let note = Note::new(&spring.element, message);
            if !notes.contains(&note) {
                notes.push(note);
            }
        };
        if spring.link.is_some() {
            note("a support on another support: a pedestal is on the ground, so the second support is left out");
        }
        let cross = [&spring.stiffness[1], &spring.stiffness[2], &spring.damping[1], &spring.damping[2]];
        if cross.into_iter().flatten().any(|value| *value != 0.0) {
            note("cross coefficients of a support are left out: a pedestal has X and Y apart");
        }
        let varies = |list: &Vec<f64>| list.iter().any(|value| *value != list[0]);
        if spring.stiffness.iter().chain(&spring.damping).any(varies) {
            note("coefficients of a support do not depend on the speed: those at its lowest speed are taken");
        }
        for (axis, xx) in [(0, 0), (1, 3)] {
            found.stiffness[axis] += spring.stiffness[xx][0];
            found.damping[axis] += spring.damping[xx][0];
        }
        found.elements.push(spring.element.clone());
    }
    for mass in rotor.masses.iter().filter(|mass| mass.node == node) {
        (0..2).for_each(|axis| found.mass[axis] += mass.mass[axis]);
        found.elements.push(mass.element.clone());
    }
    if found.stiffness.iter().any(|stiffness| *stiffness <= 0.0) || found.damping.iter().any(|damping| *damping < 0.0) {
        let message = format!(
            "support node {node} is not held by a positive stiffness along X and Y: the bearing is on rigid ground"
        );
        notes.push(Note::new(of, message));
        return None;
    }
    // several bearings on one support share it equally
    let sharing = rotor.bearings.iter().filter(|bearing| bearing.link == Some(node)).count();
    if sharing > 1 {
        let message = format!(
            "{sharing} bearings share support node {node}: each has a pedestal with an equal part of it, uncoupled from the others"
        );
        notes.push(Note::new(of, message));
        for values in [&mut found.mass, &mut found.stiffness, &mut found.damping] {
            *values = values.map(|value| value / sharing as f64);
        }
    }
    Some(found)
}
