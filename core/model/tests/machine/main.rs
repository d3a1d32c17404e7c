//! Machine files: what is read, rejected, recorded, and how a machine is identified.
#![expect(clippy::unwrap_used, reason = "helpers of tests stand outside their functions")]

mod common;
mod engine_choice;
mod files;
mod impossible;
mod problems;
mod torques;
