//! Transports for tests: within one process, and one that loses, doubles, delays and damages blocks.

#![allow(dead_code, unused_imports, reason = "each test program uses its part")]

mod faulty;
mod memory;

pub use faulty::{FaultRates, FaultyHub};
pub use memory::{MemoryHub, MemoryNet, MemoryWorker};
