//! Contact of the rotor with rings: contact laws, detection, rubs, impacts, whips.

mod bounce;
#[path = "../common/mod.rs"]
mod common;
mod contact_forecast;
mod detection;
mod light_touch;
mod normal_work;
mod one_place;
mod one_point;
mod places;
mod ring;
mod rolling;
mod rub;
mod rub_regime;
mod short_impacts;
mod small_gap;
mod two_diaphragms;
mod whip;
