//! Contact forces on the degrees of freedom (DOFs) of a ring.

use super::surface::Surface;

/// Forces and moments on the ring's DOFs \[N, N m\], each DOF at most once.
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

    /// All DOFs with their forces.
    pub fn all(&self) -> &[(usize, f64)] {
        &self.0
    }

    /// Passes the differences from other forces, one for each DOF of either.
    #[inline]
    pub fn differences(&self, from: &Self, mut pass: impl FnMut(usize, f64)) {
        // a force that stays on its element has the same degrees of freedom in the same order
        if self.0.len() == from.0.len() && self.0.iter().zip(&from.0).all(|((dof, _), (other, _))| dof == other) {
            self.0.iter().zip(&from.0).for_each(|((dof, force), (_, other))| pass(*dof, force - other));
            return;
        }
        let on = |forces: &Self, dof: usize| forces.0.iter().find(|(known, _)| *known == dof).map(|(_, force)| *force);
        self.0.iter().for_each(|&(dof, force)| pass(dof, force - on(from, dof).unwrap_or(0.0)));
        from.0.iter().filter(|(dof, _)| on(self, *dof).is_none()).for_each(|&(dof, force)| pass(dof, -force));
    }

    /// Adds a force at a place of the surface: radial and tangential part \[N\].
    pub fn add_at(&mut self, surface: &Surface, (element, xi): (usize, f64), [radial, tangential]: [f64; 2]) {
        let forces = surface.shapes(element, xi).map(|(dof, r, t)| (dof, radial * r + tangential * t));
        // the two nodes of an element differ
        if self.0.is_empty() && surface.nodes > 1 {
            self.0.extend_from_slice(&forces);
        } else {
            forces.into_iter().for_each(|(dof, force)| self.add(dof, force));
        }
    }

    /// Adds other forces, multiplied by a factor.
    pub fn add_scaled(&mut self, factor: f64, other: &Self) {
        other.0.iter().for_each(|&(dof, force)| self.add(dof, factor * force));
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
        assert_eq!(forces.all().len(), 8, "two nodes of four degrees of freedom");
        let sum = |offset: usize| forces.all().iter().filter(|(dof, _)| dof % 4 == offset).map(|(_, f)| f).sum::<f64>();
        assert!((sum(0) - 2.0).abs() < 1e-14 && (sum(2) - 4.0).abs() < 1e-14);
    }

    #[test]
    fn differences_have_every_degree_of_freedom_once() {
        let surface = steel_ring(8, 0.4, 0.37, false);
        let [mut one, mut same, mut other] = [(); 3].map(|()| NodalForces::none());
        one.add_at(&surface, (2, 0.25), [3.0, -2.0]);
        same.add_at(&surface, (2, 0.75), [1.0, 5.0]);
        other.add_at(&surface, (3, 0.5), [1.0, 4.0]);
        for (from, count) in [(&one, 8), (&same, 8), (&other, 12), (&NodalForces::none(), 8)] {
            let mut expected = one.clone();
            expected.add_scaled(-1.0, from);
            let mut found = Vec::new();
            one.differences(from, |dof, force| found.push((dof, force)));
            assert_eq!(found.len(), count);
            assert_eq!(found, expected.all());
        }
    }
}
