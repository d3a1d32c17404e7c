//! The commented study files that `bladeoff new study` writes.

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
# twin_share = "5 %"                       # so many samples run twice, the second time 1e-6 faster: how much does the load change?

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

# Several starts a cell. The angle at which the blade leaves determines where rotor and ring meet first, and with that the loads: by
# tens of per cent on this rig, in no order that a trend would survive. Nobody knows it, so it is uncertain, and no cell is one run:
# compare the median and the worst of its starts, as the summary of `run` does. Every cell has the same starts, so what differs
# between two cells is not the luck of their starts.
[design]
kind = "monte-carlo"                       # "latin-hypercube", "sobol", "halton", "one-at-a-time"
samples = 6

[[uncertain]]
path = "blade_off.phase"
as = "release_angle"                       # a short name for its column
distribution = "periodic"                  # uniform, both ends are the same; others: docs/studies.md
lower = "0 deg"
upper = "360 deg"

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

# Combinations from a CSV file (its header names the paths) combined with the axes above, instead of [design] and [[uncertain]]:
# [points]
# file = "points.csv"

# How many samples may fail, be invalid or exceed a limit of the model before `run` ends with exit code 4; a number or a share:
# [limits]
# max_failed = "0 %"
# max_invalid = "100 %"
# max_beyond = "100 %"
"#;

/// A risk study of the lab rig that runs as it is when it lies in `studies/`.
pub const RISK_TEMPLATE: &str = r#"# Question: how probable is it that <what must not happen>, and with which interval?
#
#   bladeoff check FILE            what was understood of each uncertain parameter, how long it takes
#   bladeoff run FILE              computes the samples, then answers
#   bladeoff answer DIR            the answers again, also while it runs
#   bladeoff gate DIR              0 passed, 4 failed, 5 open: for scripts
#
# Format: docs/studies.md. A risk question from here to a decision: docs/uncertainty.md.
schema = 1
name = "my-risk"                           # results go to runs/<name>; default: the name of this file
machine = "machines/lab_rig.toml"          # relative to this file
seed = 1                                   # of everything that is drawn

[set]
"run.end_time" = "0.1 s"

# How the points are placed. Independent ones have exact limits, and any beginning of them is a study of its own: take these where
# something is decided. "sobol" and "latin-hypercube" need fewer points for a mean (`replicates` = 16 or more give an interval).
[design]
kind = "monte-carlo"
samples = 256                              # more can be added later: existing points and finished samples are kept

# One table for each uncertain parameter: `path` and a `distribution` with its keys:
#   normal mean sd | lognormal median cv | uniform lower upper | log-uniform lower upper | triangular lower mode upper
#   beta a b lower upper | gamma shape scale | weibull shape scale | gumbel location scale | exponential mean
#   discrete values weights | empirical file column | periodic lower upper
# `lower`, `upper` cut any continuous one; moments are those before. `check` says what is left.
[[uncertain]]
path = "blade_off.mass"
as = "lost_mass"                           # a short name for its column, and in formulas
distribution = "lognormal"
median = "10 g"
cv = 0.2
lower = "4 g"
upper = "20 g"

# The angle of the blade at its release is unknown.
[[uncertain]]
path = "blade_off.phase"
as = "release_angle"
distribution = "periodic"
lower = "0 deg"
upper = "360 deg"

[[uncertain]]
path = "contact.friction"
as = "friction"
distribution = "triangular"
lower = 0.05
mode = 0.15
upper = 0.3

# A variable that no machine has, and a parameter by a formula of variables:
[[uncertain]]
name = "cold_gap"
distribution = "normal"
mean = "0.55 mm"
sd = "0.03 mm"
lower = "0.45 mm"
upper = "0.65 mm"

[[uncertain]]
name = "growth"
distribution = "uniform"
lower = "0.05 mm"
upper = "0.15 mm"

[[derived]]
path = "contact.gap"
as = "gap"
formula = "cold_gap - growth"

# Two that go together: `rank` (Spearman), `linear` (Pearson), or `normal` (of the normal numbers behind the values).
[[correlation]]
between = ["cold_gap", "growth"]
rank = 0.3

# [[vary]] crosses the points with values: every value sees the same points.
# [[vary]]
# path = "contact.detection"
# values = ["hyp1", "hyp2"]

# What is asked. Runs that fail, are invalid or exceed a limit of the model are not left out: each figure is given with them harmless
# and harmful.
[[question]]
name = "overload"
probability = "max_bearing_load_N > 80 N"  # columns of the table; units as everywhere, or bare SI

[[question]]
name = "load-95"
quantile = 0.95
of = "max_bearing_load_N"

[[question]]
name = "overload-by-mass"
fragility = "lost_mass"
probability = "max_bearing_load_N > 80 N"

# What `bladeoff gate` decides:
[[gate]]
require = "P(max_bearing_load_N > 200 N) < 0.05"
confidence = 0.95
"#;
