//! Mean spin of the shaft line: angle, braking and drive.
//!
//! `W = s . d/dt` is the inertia-weighted mean of all nodes' angular velocities; s is its row on the torsional coordinates.

use super::brake::Brake;
use super::prescribed::Prescribed;
use super::stepper::Stepper;
use crate::structure::Structure;
use bladeoff_model::machine::Machine;
use bladeoff_numerics::linalg::{axpy, dot};

/// Mean spin during a run.
#[derive(Debug, Clone)]
pub(crate) struct Spin {
    /// Mean spin angle at n \[rad\].
    pub angle: f64,
    /// Time step \[s\].
    dt: f64,
    /// Row s: mean spin increment per torsional coordinate.
    pub row: Vec<f64>,
    /// Coordinates of a uniform rotation by 1 rad.
    pub rigid: Vec<f64>,
    /// Braking torque.
    pub brake: Brake,
    /// Drive of a prescribed speed; `None` for a free spin.
    pub prescribed: Option<Prescribed>,
}

impl Spin {
    /// Mean spin at the start of a run, with the stepper of the torsion.
    pub fn new(machine: &Machine, structure: &Structure, torsion: &Stepper) -> Self {
        let (rotor, map, dt) = (&structure.rotor, &structure.torsion.coordinates, torsion.dt);
        let mut row = vec![0.0; map.size()];
        map.project(&rotor.spin_weights, &mut row);
        let rigid = structure.torsion.coordinates_of(&rotor.torsional_mass, &vec![1.0; rotor.nodes]);
        let mut direction = vec![0.0; map.size()];
        torsion.compliance(&row, &mut direction);
        let law = machine.rotor.speed_law.clone();
        let brake = Brake::new(machine.braking.clone(), law.is_some(), &row, direction.clone(), dt);
        let prescribed = law.map(|law| Prescribed::new(law, &row, direction));
        Self { angle: machine.rotor.initial.angle, dt, row, rigid, brake, prescribed }
    }

    /// Adds the braking torque to the torsional forces, from the centred spin of the last round.
    pub fn brake(&mut self, spin: f64, torque: &mut [f64]) {
        let braking = self.brake.torque(spin);
        for (sum, s) in torque.iter_mut().zip(&self.row) {
            *sum += braking * s;
        }
    }

    /// Corrects the response to the torques of a round if the brake stops or holds the rotor, or a drive prescribes its speed; `before` are the
    /// increments of the previous step.
    pub fn hold(&mut self, time: f64, before: &[f64], response: &mut [f64]) {
        self.brake.settle(&self.row, dot(&self.row, before), response);
        if let Some(prescribed) = &mut self.prescribed {
            prescribed.impose(&self.row, time, self.dt, response);
        }
    }

    /// Corrects the initial angular accelerations if the brake holds the rotor at rest, or for the slope of a prescribed speed; `direction` is the
    /// angular acceleration per unit torque.
    pub fn hold_start(&self, spin: f64, direction: &[f64], start: &mut [f64]) {
        if spin == 0.0 {
            self.brake.hold_start(&self.row, direction, start);
        }
        if let Some(prescribed) = &self.prescribed {
            let missing = (prescribed.initial_slope() - dot(&self.row, start)) / dot(&self.row, direction);
            axpy(missing, direction, start);
        }
    }

    /// Increment of the mean spin angle \[rad\].
    pub fn turn(&self, torsion: &[f64]) -> f64 {
        dot(&self.row, torsion)
    }

    /// Mean spin at n, centred \[rad/s\].
    pub fn centred(&self, torsion: &[f64], before: &[f64]) -> f64 {
        (dot(&self.row, torsion) + dot(&self.row, before)) * 0.5 / self.dt
    }

    /// Mean spin over the step from n to n+1, equal to that at n + 1/2 \[rad/s\].
    pub fn over_step(&self, torsion: &[f64]) -> f64 {
        self.brake.spin(dot(&self.row, torsion)) / self.dt
    }

    /// Mean spin at n+1 \[rad/s\]: the prescribed one, or an extrapolation of the last two steps, which is of second order and exact for a constant
    /// acceleration. `time` is the time at n.
    pub fn reached(&self, time: f64, torsion: &[f64], before: &[f64]) -> f64 {
        if let Some(prescribed) = &self.prescribed {
            return prescribed.speed(time + self.dt);
        }
        let over_step = self.over_step(torsion);
        // a rotor at rest remains at rest
        if over_step == 0.0 {
            return 0.0;
        }
        over_step + 0.5 * (over_step - dot(&self.row, before) / self.dt)
    }

    /// Work of the braking torque over the step at n \[J\], <= 0, with the centred spin.
    pub fn braking_work(&self, spin: f64) -> f64 {
        self.brake.acted(spin) * spin * self.dt
    }

    /// Work of the drive of a prescribed speed over the step at n \[J\], with the centred spin.
    pub fn drive_work(&self, spin: f64) -> Option<f64> {
        self.prescribed.as_ref().map(|prescribed| prescribed.torque * spin * self.dt)
    }

    /// Removes the mean spin from a torsional response to a torque if the speed is prescribed; returns the drive torque
    /// required for it, per unit torque.
    pub fn hold_response(&self, response: &mut [f64]) -> f64 {
        self.prescribed.as_ref().map_or(0.0, |prescribed| prescribed.hold(&self.row, response))
    }

    /// Increment of the mean spin angle by the drive of a prescribed speed in a step \[rad\]. The drive torque converges with the forces, whereas the
    /// spin increment itself is prescribed and always converged.
    pub fn driven(&self) -> f64 {
        self.prescribed.as_ref().map_or(0.0, Prescribed::driven)
    }

    /// Adds the drive's reaction to a contact torque \[N m\].
    pub fn add_drive_torque(&mut self, torque: f64) {
        if let Some(prescribed) = &mut self.prescribed {
            prescribed.torque -= torque;
        }
    }
}
