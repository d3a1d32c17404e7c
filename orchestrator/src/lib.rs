//! What a lost blade does to a shaft line: studies of blade-off transients.
//!
//! From a study file to a result table: [`study`] reads and checks it, [`design`] numbers its combinations, [`run`]
//! has them computed by worker processes through [`dispatch`] and [`schedule`], [`ledger`] records what is done,
//! [`results`] writes the table, [`report`] says what came out, [`chaos`] tries whether all that survives the night. [`cli`] is the way in.

pub mod call;
pub mod chaos;
pub mod cli;
pub mod design;
pub mod dispatch;
pub mod engine;
pub mod figures;
pub mod guarded;
pub mod history;
pub mod ledger;
pub mod report;
pub mod results;
pub mod run;
pub mod schedule;
pub mod study;
pub mod threads;
pub mod version;

pub use bladeoff_protocol::files;
