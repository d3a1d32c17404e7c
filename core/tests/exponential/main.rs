//! The exponential engine against closed forms, independent programs and the reduced engine; its instruction counts.

mod at_rest;
mod bearing_tables;
#[path = "../common/mod.rs"]
mod common;
mod exponential;
mod exponential_edges;
mod exponential_fine_steps;
mod exponential_outside;
mod exponential_random;
mod exponential_rub;
mod exponential_run;
mod free_run;
#[cfg(target_arch = "x86_64")]
mod instructions;
mod parabola_peak;
mod prescribed_speed;
mod radial_spring;
#[path = "../common/random.rs"]
mod random;
mod rigid_ring;
mod several_diaphragms;
