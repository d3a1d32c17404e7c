//! Eigenmodes: the reduced basis of the production engine, whirl frequencies, critical speeds, ring frequencies.

mod basis;
mod codec;
mod contact_forecast;
mod equilibrium;
mod follow;
mod key;
mod margin;
mod matrices;
mod quadratic;
mod reduction;
mod refine;
mod releases;
mod report;
mod sense;
mod shape;
mod spectra;
mod stability;
mod table_modes;
mod unbalance;
mod weight;
mod whirl;

pub(crate) use basis::largest_share;
pub use basis::{Basis, BasisError, DEFAULT_RING_MODES, DEFAULT_ROTOR_MODES, ModeSet};
pub use contact_forecast::{ContactForecast, contact_forecasts};
pub use equilibrium::{Equilibrium, equilibrium};
pub(crate) use key::{is_key_of, modal_key};
pub use quadratic::{Eigensolver, QuadraticModes, quadratic_modes, quadratic_modes_by, quadratic_values};
pub use releases::{expected_releases, highest_speed};
pub use report::{ModesReport, RingMode, followed_modes, report, report_by, torsional_frequencies};
pub use sense::{NOTABLE, STRAIGHT, Whirl};
pub use spectra::ModesError;
pub use stability::{Damping, DampingGrid, LeastDamping, ROUNDING, UnstableRange, least_damping, unstable_ranges};
pub(crate) use table_modes::table_mode_count;
pub use unbalance::{UnbalanceResponse, unbalance_response};
pub use weight::{UnderWeight, under_weight};
pub use whirl::{CriticalSpeed, OVERDAMPED, OverdampedMode, SpeedModes, WhirlMode, Work, whirl_modes};
