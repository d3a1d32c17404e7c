//! Shaft lines, modes and their laws: closed forms, published cases, independent programs, invariance.

mod bearing_tables;
#[path = "../common/mod.rs"]
mod common;
mod disc_mass;
mod display_modes;
mod invariance;
mod jeffcott;
mod laws;
mod linear_rotors;
mod lost_masses;
mod modal_basis;
mod modes;
mod outside;
mod pedestals;
mod stability;
mod tapers;
mod torsion;
