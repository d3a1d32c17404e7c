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

    /// Clears all forces.
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

    /// Differences from other forces on the same DOFs in the same order, as for a contact that stays on its element; `None` for other DOFs.
    pub fn changes(&self, from: &Self) -> Option<impl Iterator<Item = (usize, f64)>> {
        let pairs = || self.0.iter().zip(&from.0);
        let are_same = self.0.len() == from.0.len() && pairs().all(|((dof, _), (other, _))| dof == other);
        are_same.then(|| pairs().map(|((dof, force), (_, before))| (*dof, force - before)))
    }

    /// Adds a force at a place of the surface: radial and tangential part \[N\].
    pub fn add_at(&mut self, surface: &Surface, (element, xi): (usize, f64), [radial, tangential]: [f64; 2]) {
        let forces = surface.shapes(element, xi).map(|(dof, r, t)| (dof, radial * r + tangential * t));
        // the two nodes of an element are different ones
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
    fn changes_are_those_on_the_same_element() {
        let surface = steel_ring(8, 0.4, 0.37, false);
        let [mut one, mut same, mut other] = [(); 3].map(|()| NodalForces::none());
        one.add_at(&surface, (2, 0.25), [3.0, -2.0]);
        same.add_at(&surface, (2, 0.75), [1.0, 5.0]);
        other.add_at(&surface, (3, 0.5), [1.0, 4.0]);
        let mut expected = one.clone();
        expected.add_scaled(-1.0, &same);
        let changes: Vec<(usize, f64)> = one.changes(&same).expect("one element").collect();
        assert_eq!(changes, expected.all());
        assert!(one.changes(&other).is_none() && one.changes(&NodalForces::none()).is_none());
    }
}
