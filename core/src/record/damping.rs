//! Least damping ratio of the whirl modes over the speeds that a run has visited.

use super::row::Row;
use crate::modal::LeastDamping;

/// Reports the columns of the least damping. `of`: record of a run that has ended.
pub(super) fn report(of: Option<&LeastDamping>, row: &mut Row<'_>) {
    let least = of.and_then(LeastDamping::least);
    row.real(
        "least_damping_ratio",
        "",
        "smallest damping ratio of a whirl mode of the linear rotor without contact, over the speeds of the run. \
         Negative: unstable there; values below 1e-9 are rounding and count as 0; -1: a motion that grows without \
         oscillation; null: no mode whirls",
        least.map(|(ratio, _)| ratio),
    );
    row.real(
        "least_damping_at_rad_s",
        "rad/s",
        "speed of the run at which the damping ratio is least_damping_ratio",
        least.map(|(_, speed)| speed),
    );
}
