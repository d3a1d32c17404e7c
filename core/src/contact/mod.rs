//! Contact between the rigid rotor section and the diaphragm: gap, detection, multipliers, friction (docs/theory/03-contact.md).
//!
//! All quantities are in the stator's frame: origin at the diaphragm's centre, rotated by its angle. `P` is a point of the ring's contact surface,
//! `x` the rotor centre, `d = P - x`, `n = d/|d|` (from the rotor to the ring), `t = e_z x n`.
//!
//! `law` has the contact law at one place; `gap` and `detection` find this place, `place_search` for a force that moves it. `complementarity` solves
//! several places at once. The response of the structures to a contact force is computed in the time step ([`crate::engine`]).

pub(crate) mod complementarity;
mod detection;
mod gap;
mod law;
mod place_search;

pub use detection::Detector;
pub use gap::{Gap, Place, exact_gap, polar_gap};
pub use law::{Compliance, ContactReaction, NotUnique, slide, stick_or_slide};
pub(crate) use place_search::PlaceSearch;
