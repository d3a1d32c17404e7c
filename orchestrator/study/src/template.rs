//! The commented study file that `bladeoff new study` writes.

/// The machine that the template names.
pub const STUDY_MACHINE: &str = "machines/lab_rig.toml";

/// A study of the lab rig that runs as it is when it lies in `studies/`.
pub const STUDY_TEMPLATE: &str = r#"# Question: <what this study answers, in one sentence>
#
# Check it with `bladeoff check FILE`, run it with `bladeoff run FILE`. Format: docs/studies.md.
schema = 1
name = "my-study"                          # results go to runs/<name>; default: the name of this file
machine = "machines/lab_rig.toml"          # relative to this file
seed = 1                                   # of the shuffle from which `--limit N` takes its samples; default 0
# twin_share = "5 %"                       # so many samples run twice, the second time 1e-6 faster: how far does the load move?

# Fixed overrides: any path of `bladeoff paths MACHINE`, or its ending where only one path ends so.
# A number is SI, a string has its unit.
[set]
"run.end_time" = "0.5 s"

# One table for each parameter that varies; all combinations are computed. The first axis is the slowest in the table.
[[vary]]
path = "contact.gap"
from = "0.4 mm"
to = "0.8 mm"
count = 3
# spacing = "log"                          # default "linear"

[[vary]]
path = "contact.detection"
values = ["hyp1", "hyp2", "hyp2-frozen"]

# Several starts a cell. The angle at which the blade leaves decides where rotor and ring meet first, and with that the loads: by
# tens of per cent on this rig, in no order that a trend would survive. So no cell is one run: compare the median and the worst
# of its starts, as the summary of `run` does. The 8 blades stand every 45 degrees; here six starts between two of them. Where
# gravity, a single bearing or an offset is not the same all round, or another unbalance is there, take the whole turn.
[[vary]]
path = "blade_off.phase"
from = "0 deg"
to = "37.5 deg"
count = 6

# Tables with the same `zip` advance together instead of being combined; they have equally many values:
# [[vary]]
# path = "blade_off.mass"
# values = ["5 g", "10 g"]
# zip = "blade"
#
# [[vary]]
# path = "blade_off.radius"
# values = ["45 mm", "40 mm"]
# zip = "blade"

# Combinations from a CSV file (its header names the paths) instead of, or combined with, the axes above:
# [points]
# file = "points.csv"

# How many samples may fail or be invalid before `run` ends with exit code 4; a number or a share:
# [limits]
# max_failed = "0 %"
# max_invalid = "100 %"
"#;
