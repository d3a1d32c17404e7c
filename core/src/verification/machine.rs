//! Machines of reference cases, and their runs.

use crate::engine::simulate;
use crate::record::{Follower, Frame};
use crate::structure::Structure;
use bladeoff_model::machine::{Engine, Machine, MachineDef};

/// Machine of a reference case, for the `reduced` engine if it names no engine; `None` only if the file format no longer accepts its text.
pub(super) fn machine(text: &str) -> Option<Machine> {
    let mut def = MachineDef::parse("reference case", text).ok()?;
    if def.engine()?.is_auto() {
        def.settle(Engine::Reduced);
    }
    def.build().ok()
}

/// Engine and step \[s\], as lines of `[run]`.
pub(super) fn stepping(engine: Engine, step: f64) -> String {
    let key = if engine == Engine::Exponential { "contact_step" } else { "step" };
    format!("engine = \"{}\"\n{key} = {step:?}\n", engine.word())
}

/// Runs a machine and calls a closure at each instant; `None` if the machine cannot be run.
pub(super) fn watch(text: &str, see: impl FnMut(&Frame<'_>)) -> Option<()> {
    struct Watch<F>(F);
    impl<F: FnMut(&Frame<'_>)> Follower for Watch<F> {
        fn wants(&mut self, _step: u64, _time: f64) -> bool {
            true
        }
        fn see(&mut self, frame: &Frame<'_>) {
            (self.0)(frame);
        }
    }
    let machine = machine(text)?;
    let structure = Structure::build(&machine, None).ok()?;
    simulate(&machine, &structure, &mut Watch(see)).ok().map(|_| ())
}

/// Vertex of the parabola through three equally spaced samples around a maximum: (offset in steps, value).
pub(super) fn vertex(before: f64, middle: f64, after: f64) -> (f64, f64) {
    let (curvature, slope) = (before - 2.0 * middle + after, 0.5 * (after - before));
    let offset = -slope / curvature;
    (offset, middle + 0.5 * slope * offset)
}
