//! Machine files: reading, rejection, records, identity.
#![expect(clippy::unwrap_used, reason = "helpers of tests stand outside their functions")]

mod common;
mod engine_choice;
mod files;
mod impossible;
mod problems;
mod torques;
