//! What a lost blade does to a shaft line: studies of blade-off transients.
//!
//! From a study file to a result table: [`bladeoff_study`] reads and checks it and numbers its combinations, [`run`]
//! has them computed by worker processes through [`dispatch`] and [`schedule`], [`ledger`] records what is done,
//! [`bladeoff_answers`] writes the table and its summary, [`report`] shows the progress. [`cli`] is the way in.

pub mod answering;
pub mod cli;
pub mod dispatch;
pub mod engine;
pub mod history;
pub mod ledger;
pub mod pictures;
pub mod plausible;
pub mod report;
pub mod reporting;
pub mod run;
pub mod schedule;
pub mod settled;
pub mod starts;
pub mod submit;
pub mod version;
