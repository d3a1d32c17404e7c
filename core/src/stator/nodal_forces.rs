//! Contact forces on the degrees of freedom of a ring.

use super::surface::Surface;

/// Forces and moments on the ring's degrees of freedom \[N, N m\], each degree of freedom at most once.
#[derive(Debug, Clone, Default, PartialEq)]
pub(crate) struct NodalForces(Vec<(usize, f64)>);

impl NodalForces {
    /// No force.
    pub const fn none() -> Self {
        Self(Vec::new())
    }

    /// Removes all forces.
    pub fn clear(&mut self) {
        self.0.clear();
    }

    /// Whether there is no force.
    pub fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    /// Degrees of freedom with their forces.
    pub fn iter(&self) -> impl Iterator<Item = (usize, f64)> {
        self.0.iter().copied()
    }

    /// Adds a force at a place of the surface: radial and tangential part \[N\].
    pub fn add_at(&mut self, surface: &Surface, (element, xi): (usize, f64), [radial, tangential]: [f64; 2]) {
        for (dof, r, t) in surface.shapes(element, xi) {
            self.add(dof, radial * r + tangential * t);
        }
    }

    /// Adds other forces, multiplied by a factor.
    pub fn add_scaled(&mut self, factor: f64, other: &Self) {
        other.iter().for_each(|(dof, force)| self.add(dof, factor * force));
    }

    fn add(&mut self, dof: usize, force: f64) {
        match self.0.iter_mut().find(|(known, _)| *known == dof) {
            Some((_, sum)) => *sum += force,
            None => self.0.push((dof, force)),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::stator::steel_ring;

    #[test]
    fn forces_on_one_element_are_summed() {
        let surface = steel_ring(8, 0.4, 0.37, false);
        let mut forces = NodalForces::default();
        forces.add_at(&surface, (7, 0.25), [3.0, -2.0]);
        forces.add_at(&surface, (7, 0.5), [1.0, 4.0]);
        assert_eq!(forces.iter().count(), 8, "two nodes of four degrees of freedom");
        let sum = |offset: usize| forces.iter().filter(|(dof, _)| dof % 4 == offset).map(|(_, f)| f).sum::<f64>();
        assert!((sum(0) - 2.0).abs() < 1e-14 && (sum(2) - 4.0).abs() < 1e-14);
        let mut difference = forces.clone();
        difference.add_scaled(-1.0, &forces);
        assert!(difference.iter().all(|(_, force)| force == 0.0));
    }
}
