//! The program as its users run it: studies, machines, answers, files, messages; and the documents. None of these tests needs a fault hook.

mod answering;
mod architecture;
mod assumptions;
mod auto;
mod beyond;
#[path = "../support/cap.rs"]
mod cap;
mod command_line;
mod compare;
mod coverage;
mod design_export;
mod dimensions;
mod escapes;
mod figures;
mod file_faults;
mod foreign_files;
mod fuzz;
mod history;
mod input;
mod json_outputs;
mod limits;
mod little_said;
mod maps;
mod outputs;
mod printed;
mod probabilities;
mod readme;
mod reference;
mod released;
mod replay;
mod report;
mod reuse;
mod setup;
mod shipped;
mod stop_coverage;
mod submit;
#[path = "../support/mod.rs"]
mod support;
mod telling;
mod tutorial;
mod unanswered;
mod understood;
mod versions;
mod watch;
mod widths;
mod words;
