//! What a lost blade does to a shaft line: studies of blade-off transients.
//!
//! From a study file to a result table: [`bladeoff_study`] reads and checks it and numbers its combinations, [`run`]
//! has them computed by worker processes through [`dispatch`] and [`schedule`], [`bladeoff_record`] records what is done,
//! [`bladeoff_answers`] writes the table and its summary, [`terminal`] shows the progress. [`cli`] is the way in.

pub mod cli;
pub mod dispatch;
pub mod engine;
pub mod engine_choice;
pub mod history;
pub mod html_report;
pub mod pictures;
pub mod plausible;
pub mod questions;
pub mod run;
pub mod schedule;
pub mod start_check;
pub mod submit;
pub mod terminal;
pub mod version;
