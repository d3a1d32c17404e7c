//! Contact between the rigid rotor section and the diaphragm: gap, detection, multipliers, friction (docs/theory/03-contact.md).
//!
//! Everything here lives in the stator's frame: origin at the diaphragm's centre, turned by its angle. `P` is a point of the
//! ring's contact surface, `x` the rotor centre, `d = P - x`, `n = d/|d|` (from the rotor to the ring), `t = e_z x n`.
//!
//! A law at one place (`law`), where that place is (`gap`, `detection`; `place_search` for a force that moves it), and several places
//! at once (`complementarity`). What the structures make of a force is the step's matter ([`crate::engine`]).

pub(crate) mod complementarity;
mod detection;
mod gap;
mod law;
mod place_search;

pub use detection::Detector;
pub use gap::{Gap, Place, exact_gap, polar_gap};
pub use law::{Compliance, ContactReaction, NotUnique, slide, stick_or_slide};
pub(crate) use place_search::PlaceSearch;
