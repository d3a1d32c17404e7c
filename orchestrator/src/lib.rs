//! Orchestrator: computes studies of blade-off transients on all cores and reports their results.
//!
//! From a study file to a result table: [`bladeoff_study`] reads and checks the file and numbers its samples. [`run`] has
//! worker processes compute them through [`dispatch`] and [`schedule`]. [`bladeoff_record`] records the results,
//! [`bladeoff_answers`] writes the table and its summary, [`terminal`] shows the progress. [`cli`] has the commands.

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
