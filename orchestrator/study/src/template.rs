//! The commented study files that `bladeoff new study` writes.

/// The machine that the template names.
pub const STUDY_MACHINE: &str = "machines/lab_rig.toml";

/// A study of the lab rig that runs without changes in `studies/`.
pub const STUDY_TEMPLATE: &str = r#"# Question: <what this study answers, in one sentence>
#
# Check it with `bladeoff check FILE`, run it with `bladeoff run FILE`. Format: docs/studies.md.
schema = 1
name = "my-study"                          # results go to runs/<name>; default: the name of this file
machine = "machines/lab_rig.toml"          # relative to this file
seed = 1                                   # of the shuffle from which `--limit N` takes its samples; default 0
# twin_share = "5 %"                       # this share of the samples runs twice, the second time 1e-6 faster, to measure sensitive runs

# Fixed overrides: any path of `bladeoff paths MACHINE`, or an ending that only one path has.
# A number is in SI units; a string contains its unit.
[set]
"run.end_time" = "0.5 s"

# One table for each parameter that varies; all combinations are computed. The first axis changes slowest in the result table.
[[vary]]
path = "contact.gap"
from = "0.4 mm"
to = "0.8 mm"
count = 3
# spacing = "log"                          # default "linear"

[[vary]]
path = "contact.detection"
values = ["hyp1", "hyp2", "hyp2-frozen"]

# Several starts for each combination. The release angle changes the place of the first contact, and with it the loads of this rig by
# tens of per cent, without a trend. It is unknown, so compare the median and the worst of the starts, as the summary of `run` does.
# Every combination has the same starts, so a difference between two of them is not an effect of the starts.
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

/// A risk study of the lab rig that runs without changes in `studies/`.
pub const RISK_TEMPLATE: &str = r#"# Question: how probable is it that <what must not happen>, and with which interval?
#
#   bladeoff check FILE            distribution of each uncertain parameter, expected run time
#   bladeoff run FILE              computes the samples, then answers
#   bladeoff answer DIR            the answers again, also while it runs
#   bladeoff gate DIR              exit code for scripts: 0 passed, 4 failed, 5 open
#
# Format: docs/studies.md. A risk question from here to a decision: docs/uncertainty.md.
schema = 1
name = "my-risk"                           # results go to runs/<name>; default: the name of this file
machine = "machines/lab_rig.toml"          # relative to this file
seed = 1                                   # of all random numbers

[set]
"run.end_time" = "0.1 s"

# The design places the points. Independent points have exact limits, and the first N of them are a valid study: use them for
# decisions. "sobol" and "latin-hypercube" need fewer points for a mean (`replicates` = 16 or more give an interval).
[design]
kind = "monte-carlo"
samples = 256                              # more can be added later: existing points and finished samples are kept

# One table for each uncertain parameter: `path` and a `distribution` with its keys:
#   normal mean sd | lognormal median cv | uniform lower upper | log-uniform lower upper | triangular lower mode upper
#   beta a b lower upper | gamma shape scale | weibull shape scale | gumbel location scale | exponential mean
#   discrete values weights | empirical file column | periodic lower upper
# `lower`, `upper` truncate any continuous one; its moments are those before. `check` prints the share that remains.
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

# Two correlated variables: `rank` (Spearman), `linear` (Pearson), or `normal` (of the underlying normal variables).
[[correlation]]
between = ["cold_gap", "growth"]
rank = 0.3

# [[vary]] combines the points with values: every value gets the same points.
# [[vary]]
# path = "contact.detection"
# values = ["hyp1", "hyp2"]

# Questions. Runs that fail, are invalid or exceed a limit of the model are not left out: the interval of each answer holds for either
# outcome of these runs.
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

# Condition that `bladeoff gate` judges:
[[gate]]
require = "P(max_bearing_load_N > 200 N) < 0.05"
confidence = 0.95
"#;
