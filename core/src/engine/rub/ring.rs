//! Flexible ring of a diaphragm during a run.

use crate::contact::{Detector, Gap, Place};
use crate::engine::shaft_line::Stepper;
use crate::stator::Surface;
use crate::structure::{Coordinates, RingPart};
use bladeoff_numerics::linalg::{axpy, distance, dot, norm};

/// State and operators of the flexible ring.
pub(super) struct Ring<'a> {
    /// Map between coordinates q and nodal degrees of freedom.
    coordinates: &'a Coordinates,
    /// State and operator of the step.
    pub stepper: Stepper,
    /// Search for contact places on the deformed surface.
    pub detector: Detector,
    /// Increment without contact, current increment, and increment of the previous round.
    pub free: Vec<f64>,
    pub d: Vec<f64>,
    last: Vec<f64>,
    /// Nodal degrees of freedom at n or n+1, from the last call that set them.
    pub field: Vec<f64>,
    scratch: Vec<f64>,
    /// Upper bound of |v| per unit of each coordinate.
    radial_bound: Vec<f64>,
    /// Unit forces along normal and tangent at the place of the force, and the row of the gap.
    pub normal: UnitForce,
    pub tangent: UnitForce,
    pub gap_row: Vec<f64>,
    /// Whether a contact has set the ring in motion. Before that, its increments are exactly zero and are not computed.
    pub moving: bool,
}

/// Generalised force of a unit force on the ring, and its response.
#[derive(Default)]
pub(super) struct UnitForce {
    /// Generalised force on the coordinates.
    pub force: Vec<f64>,
    /// Increments A^-1 times this force.
    pub response: Vec<f64>,
}

impl UnitForce {
    /// Zero unit force on `size` coordinates.
    pub fn none(size: usize) -> Self {
        Self { force: vec![0.0; size], response: vec![0.0; size] }
    }
}

impl<'a> Ring<'a> {
    pub fn new(part: &'a RingPart, surface: Surface, dt: f64) -> Option<Self> {
        let coordinates = &part.part.coordinates;
        let size = coordinates.size();
        let zeros = || vec![0.0; size];
        let arc = 2.0 * std::f64::consts::PI * part.matrices.mean_radius / part.matrices.nodes as f64;
        Some(Self {
            coordinates,
            stepper: Stepper::new(&part.part, &part.part.mass, dt)?,
            detector: Detector::new(surface),
            free: zeros(),
            d: zeros(),
            last: zeros(),
            field: vec![0.0; 4 * part.matrices.nodes],
            scratch: zeros(),
            radial_bound: radial_bound(coordinates, part.matrices.nodes, arc),
            normal: UnitForce::none(size),
            tangent: UnitForce::none(size),
            gap_row: zeros(),
            moving: false,
        })
    }

    /// Begins the step with the motion without contact.
    pub fn prepare(&mut self) {
        if self.moving {
            self.stepper.prepare(None);
            self.stepper.increment(None, &mut self.free);
        }
        self.release();
    }

    /// Resets the increment to that without contact.
    pub fn release(&mut self) {
        self.d.copy_from_slice(&self.free);
    }

    /// Begins a round with the increment without contact, to which responses to forces are added.
    pub fn restart(&mut self) {
        self.last.copy_from_slice(&self.d);
        self.release();
    }

    /// Centred displacement along a row over the step at n.
    pub fn centred_step(&self, row: &[f64]) -> f64 {
        0.5 * (dot(row, &self.d) + dot(row, &self.stepper.previous))
    }

    /// Whether the last round has left the increment unchanged, up to rounding of `floor` \[m\] on the surface.
    pub fn settled(&self, floor: f64) -> bool {
        let scale = self.radial_bound.iter().fold(0.0_f64, |max, bound| max.max(*bound));
        distance(&self.d, &self.last) * scale <= 1e-10 * norm(&self.d) * scale + floor
    }

    /// Accepts the increment.
    pub fn advance(&mut self) {
        if self.moving || self.d.iter().any(|&d| d != 0.0) {
            self.moving = true;
            self.stepper.advance(&self.d);
        }
    }

    /// Sets the nodal field at n+1 from the current increment and the displacement of the truncated modes.
    pub fn field_after(&mut self, left_out: Option<&[f64]>) {
        for i in 0..self.d.len() {
            self.scratch[i] = self.stepper.q[i] + self.d[i];
        }
        self.coordinates.expand_head(&self.scratch, &mut self.field);
        self.add(left_out);
    }

    /// Sets the nodal field at n, with the displacement of the truncated modes.
    pub fn field_at_n(&mut self, left_out: Option<&[f64]>) {
        self.coordinates.expand_head(&self.stepper.q, &mut self.field);
        self.add(left_out);
    }

    fn add(&mut self, left_out: Option<&[f64]>) {
        if let Some(left_out) = left_out {
            axpy(1.0, left_out, &mut self.field);
        }
    }

    /// Upper bound of |v| at n+1 \[m\], without the truncated modes, which are undeformed when the bound is used.
    pub fn radial_reach(&self) -> f64 {
        let mut reach = 0.0;
        for i in 0..self.d.len() {
            reach += self.radial_bound[i] * (self.stepper.q[i] + self.d[i]).abs();
        }
        reach
    }

    /// Sets the row of a unit force at a place, and its response A^-1.
    pub fn load(&self, place: Place, [radial, tangential]: [f64; 2], surface: &Surface, target: &mut UnitForce) {
        target.force.fill(0.0);
        for (dof, r, t) in surface.shapes(place.element, place.xi) {
            self.coordinates.add_row(dof, radial * r + tangential * t, &mut target.force);
        }
        self.stepper.compliance(&target.force, &mut target.response);
    }

    /// Sets the rows at the place of the force and at the place of the gap.
    pub fn load_rows(&mut self, acting: &Gap, gap: &Gap, surface: &Surface) {
        let [n_r, n_t] = acting.normal;
        let (mut normal, mut tangent) = (std::mem::take(&mut self.normal), std::mem::take(&mut self.tangent));
        self.load(acting.place, [n_r, n_t], surface, &mut normal);
        self.load(acting.place, [-n_t, n_r], surface, &mut tangent);
        (self.normal, self.tangent) = (normal, tangent);
        self.gap_row.fill(0.0);
        let [radial, tangential] = gap.ring_gradient;
        for (dof, r, t) in surface.shapes(gap.place.element, gap.place.xi) {
            self.coordinates.add_row(dof, radial * r + tangential * t, &mut self.gap_row);
        }
    }
}

/// Upper bound of |v| anywhere on the ring, per unit of each coordinate.
///
/// In an element of length L, the radial displacement of a coordinate is the cubic of its values v and slopes s at both ends:
/// ```text
/// v(xi) = h1 v1 + L g1 s1 + h2 v2 - L g2 s2,    h1 = (1 - xi)^2 (1 + 2 xi),  g1 = xi (1 - xi)^2,  h2 = xi^2 (3 - 2 xi),  g2 = xi^2 (1 - xi)
/// 3 g1 <= h1,  3 g2 <= h2,  h1 + h2 = 1   =>   |v(xi)| <= max over both ends of |v| + (L/3) |s|
/// ```
/// No factor of L below 1/3 is sufficient: `g1/h1 = xi/(1 + 2 xi)` tends to 1/3 towards the other end. (L/4 bounds the sum of the largest value and
/// the largest slope if they occur at different nodes; it is insufficient at the same node.) The distance of the surface from the rotor centre x is
/// at least `R_i - |v| - |x|` in both gap functions: `u_P` only moves a point farther from the ring's centre.
/// Verified by `the_bound_of_the_radial_displacement_holds_and_a_quarter_does_not`, `no_ring_is_nearer_than_its_bound`.
fn radial_bound(coordinates: &Coordinates, nodes: usize, arc: f64) -> Vec<f64> {
    let mut bound = vec![0.0; coordinates.size()];
    for node in 0..nodes {
        let (value, slope) = (coordinates.row(4 * node + 2), coordinates.row(4 * node + 3));
        for (k, most) in bound.iter_mut().enumerate() {
            *most = f64::max(*most, value[k].abs() + arc / 3.0 * slope[k].abs());
        }
    }
    bound
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::contact::{exact_gap, polar_gap};
    use crate::stator::steel_ring;
    use bladeoff_numerics::linalg::Matrix;
    use proptest::prelude::*;

    const NODES: usize = 6;
    const MEAN: f64 = 0.4;

    fn surface(inner_face: bool) -> Surface {
        steel_ring(NODES, MEAN, 0.37, inner_face)
    }

    /// Largest |v| of a nodal field, by sampling.
    fn largest(surface: &Surface, field: &[f64]) -> f64 {
        let places = (0..NODES).flat_map(|element| (0..=400).map(move |k| (element, f64::from(k) / 400.0)));
        places.fold(0.0, |most, (element, xi)| {
            most.max((surface.point(field, element, xi).radial - surface.radius).abs())
        })
    }

    #[test]
    fn the_bound_of_the_radial_displacement_holds_and_a_quarter_does_not() {
        let surface = surface(true);
        let arc = surface.element_angle() * MEAN;
        // one end has only a slope, the other only a displacement: L/4 counts both equally, the maximum between them is 28/27 of it
        let mut shape = Matrix::zeros(4 * NODES, 1);
        (shape[(3, 0)], shape[(6, 0)]) = (1.0, 0.25 * arc);
        let bound = radial_bound(&Coordinates::modal(&shape), NODES, arc)[0];
        let most = largest(&surface, bladeoff_numerics::linalg::column_of(&shape, 0));
        assert!(most <= bound, "{most} {bound}");
        assert!(most > 0.25 * arc * 1.037, "{most} {arc}");
        // the bound with L/3 is attained, so no smaller factor is valid
        shape[(6, 0)] = arc / 3.0;
        let most = largest(&surface, bladeoff_numerics::linalg::column_of(&shape, 0));
        assert!((most / bound - 1.0).abs() < 1e-12, "{most} {bound}");
    }

    proptest! {
        #[test]
        fn no_ring_is_nearer_than_its_bound(
            shapes in prop::collection::vec(-1.0..1.0f64, 4 * NODES * 3),
            steep in 0.1..30.0f64,
            q in prop::collection::vec(-1.0..1.0f64, 3),
            rotor in (-0.02..0.02f64, -0.02..0.02f64),
            inner_face in any::<bool>(),
        ) {
            let surface = surface(inner_face);
            // values within a hundredth of the radius, slopes from flat to steep
            let shapes = Matrix::from_fn(4 * NODES, 3, |i, j| {
                shapes[3 * i + j] * if i % 2 == 1 { 4e-3 * steep } else { 4e-3 }
            });
            let coordinates = Coordinates::modal(&shapes);
            let arc = surface.element_angle() * MEAN;
            let bound = radial_bound(&coordinates, NODES, arc);
            let reach: f64 = bound.iter().zip(&q).map(|(bound, q)| bound * q.abs()).sum();
            let mut field = vec![0.0; 4 * NODES];
            coordinates.expand(&q, &mut field);
            prop_assert!(largest(&surface, &field) <= reach * (1.0 + 1e-14));
            // no gap function is below the margin given by the bound
            let x = [rotor.0, rotor.1];
            let room = (surface.radius - 0.35) - x[0].hypot(x[1]) - reach;
            let place = Detector::new(surface).closest(&field, x);
            prop_assert!(exact_gap(&surface, Some(&field), 0.35, x, place).value >= room - 1e-14);
            prop_assert!(polar_gap(&surface, Some(&field), 0.35, x).value >= room - 1e-14);
        }
    }
}
