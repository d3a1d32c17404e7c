//! Tests of the scale of drawings, measured in the picture.

use super::{Figure, RingShape, machine, orbits, rings};
use crate::figures::contacts;
use crate::history::{About, History, Series};
use bladeoff_model::machine::{Machine, MachineDef, RotorKind};
use std::f64::consts::PI;

/// Circles may be off round by this much: tenths of a pixel on both sides.
const ROUND: f64 = 0.005;

fn study_machine(name: &str) -> Machine {
    let path = format!("{}/../../studies/machines/{name}.toml", env!("CARGO_MANIFEST_DIR"));
    let text = std::fs::read_to_string(&path).expect("a machine of the repository");
    MachineDef::parse(name, &text).expect("parses").build().expect("valid")
}

/// Points of every line and area of so many points.
fn shapes(figure: &Figure, points: usize) -> Vec<Vec<(f64, f64)>> {
    let lists = figure.svg().split("points=\"").skip(1).map(|rest| rest.split('"').next().expect("a list"));
    let read = |list: &str| -> Vec<(f64, f64)> {
        let pair = |pair: &str| {
            let (x, y) = pair.split_once(',').expect("x,y");
            (x.parse().expect("x"), y.parse().expect("y"))
        };
        list.split_whitespace().map(pair).collect()
    };
    lists.map(read).filter(|shape| shape.len() == points).collect()
}

/// Width over height.
fn proportion(shape: &[(f64, f64)]) -> f64 {
    let extent = |of: &dyn Fn(&(f64, f64)) -> f64| {
        let (low, high) = shape.iter().map(of).fold((f64::MAX, f64::MIN), |(l, h), x| (l.min(x), h.max(x)));
        high - low
    };
    extent(&|point| point.0) / extent(&|point| point.1)
}

fn are_round(what: &str, circles: &[Vec<(f64, f64)>], at_least: usize) {
    assert!(circles.len() >= at_least, "{what}: {} circles", circles.len());
    for circle in circles {
        let off = proportion(circle) - 1.0;
        assert!(off.abs() < ROUND, "{what}: off round by {off}");
    }
}

/// Sides of every rectangle of a colour.
fn rectangles(figure: &Figure, colour: &str) -> Vec<(f64, f64)> {
    let side = |tag: &str, name: &str| -> Option<f64> {
        tag.split_once(&format!(" {name}=\""))?.1.split('"').next()?.parse().ok()
    };
    let tags = figure.svg().split("<rect ").skip(1).map(|rest| rest.split('>').next().unwrap_or(""));
    tags.filter(|tag| tag.contains(colour))
        .filter_map(|tag| Some((side(tag, "width")?, side(tag, "height")?)))
        .collect()
}

#[test]
fn what_is_drawn_to_scale_is_round() {
    for name in ["lab_rig", "lp_turbine_paper"] {
        let subject = study_machine(name);
        let figure = machine(&subject).expect("a shaft");
        // ring outside and inside, rotor and its rim, the casing
        are_round(name, &shapes(&figure, 241), 4);
        // from the side: the shaft as long and thick as its elements
        let RotorKind::Shaft(shaft) = &subject.rotor.kind else { unreachable!("a shaft") };
        let drawn = rectangles(&figure, "#BEC8D2");
        assert_eq!(drawn.len(), shaft.elements.len());
        let length: f64 = drawn.iter().map(|(width, _)| width).sum();
        let thickest = drawn.iter().fold(0.0_f64, |most, (_, height)| most.max(*height));
        let true_length: f64 = shaft.elements.iter().map(|element| element.length).sum();
        let true_thickest = shaft.elements.iter().fold(0.0_f64, |most, element| most.max(element.diameter));
        let off = length / thickest * true_thickest / true_length - 1.0;
        // tenths of a pixel on a shaft of some dozens
        let units = 0.2 / thickest + 0.1 * drawn.len() as f64 / length;
        assert!(off.abs() < ROUND + units, "{name} from the side: off by {off}");
    }
}

/// A cone is drawn with the proportions of its ends, above and below the axis, and a layer outside the shaft.
#[test]
fn tapers_and_layers_are_drawn_to_scale() {
    let path = format!("{}/../../core/tests/data/ross_rotor.machine.toml", env!("CARGO_MANIFEST_DIR"));
    let text = std::fs::read_to_string(&path).expect("a machine of the repository");
    let subject = MachineDef::parse("machine", &text).expect("parses").build().expect("valid");
    let figure = machine(&subject).expect("a shaft");
    assert_eq!(rectangles(&figure, "#BEC8D2").len(), 3, "the cylinders");
    // outlines of three tapered elements and three layers, on both sides
    let outlines = shapes(&figure, 5);
    assert_eq!(outlines.len(), 12);
    // from 80 mm to 120 mm: heights of the walls of a solid cone
    let heights = |shape: &[(f64, f64)]| [(shape[1].1 - shape[0].1).abs(), (shape[2].1 - shape[3].1).abs()];
    let cones = outlines.iter().map(|shape| heights(shape)).filter(|[left, right]| (right / left - 1.5).abs() < 0.01);
    assert_eq!(cones.count(), 2);
}

#[test]
fn a_ring_is_round_at_rest_and_where_its_shape_is() {
    let around = |count: u32| -> Vec<(f64, f64)> {
        (0..=count)
            .map(|k| (2.0 * PI * f64::from(k) / f64::from(count)).sin_cos())
            .map(|(s, c)| (1.2 * c, 1.2 * s))
            .collect()
    };
    for count in [1, 3, 6] {
        let shape = RingShape { caption: "mode".to_owned(), line: around(360), marks: vec![[(1.0, 0.0), (1.2, 0.0)]] };
        let figure = rings("modes", "note", &vec![shape; count]);
        are_round("at rest", &shapes(&figure, 121), count);
        are_round("displaced", &shapes(&figure, 361), count);
    }
}

/// A rotor in the middle and a file without geometry: the clearance has the unit of its own size.
#[test]
fn the_clearance_of_a_single_instant_has_its_digits() {
    let series = |name: &str, value: f64| Series { name: name.to_owned(), unit: String::new(), values: vec![value] };
    let channels = [("contact.rotor_x_m", 0.0), ("contact.rotor_y_m", 0.0), ("contact.gap_m", 5e-4)];
    let channels = channels.map(|(name, value)| series(name, value)).to_vec();
    let history = History { time: vec![0.0], channels, ..History::default() };
    let figure = orbits(&history, "rest", &contacts(&history)[0], &[0.0]).expect("an orbit");
    assert!(figure.svg().contains("clearance 500.0 µm"), "{}", figure.svg());
}

#[test]
fn the_clearance_of_an_orbit_is_round() {
    let around =
        |of: fn(f64) -> f64| (0..=400).map(|k| 4e-4 * of(2.0 * PI * f64::from(k) / 200.0)).collect::<Vec<f64>>();
    let series = |name: &str, values: Vec<f64>| Series { name: name.to_owned(), unit: String::new(), values };
    let history = History {
        time: (0..=400).map(|k| f64::from(k) * 1e-4).collect(),
        channels: vec![
            series("contact.rotor_x_m", around(f64::cos)),
            series("contact.rotor_y_m", around(f64::sin)),
            series("rotor.angle_rad", (0..=400).map(|k| 2.0 * PI * f64::from(k) / 200.0).collect()),
        ],
        about: About::from([("contact.gap_m".to_owned(), "5e-4".to_owned())]),
        outcome: About::default(),
    };
    for instants in [&[0.04][..], &[0.02, 0.04], &[0.02, 0.03, 0.035, 0.04]] {
        let figure = orbits(&history, "round", &contacts(&history)[0], instants).expect("an orbit");
        are_round("gap", &shapes(&figure, 181), instants.len());
        are_round("orbit", &shapes(&figure, 201), 1);
    }
}
