//! The keys of a study file in one table: the readers accept these keys, and the reference is generated from them.

/// One key of a study file.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct StudyKey {
    /// Table of the key as the file writes it: `[limits]`, `[[vary]]`; "" for the keys before the first table.
    pub table: &'static str,
    /// Name.
    pub name: &'static str,
    /// Type of the value.
    pub holds: &'static str,
    /// Default, or "required".
    pub default: &'static str,
    /// Meaning in one sentence.
    pub meaning: &'static str,
}

/// Names of the keys of a table, in the order of the format.
pub(crate) fn names(table: &str) -> Vec<&'static str> {
    STUDY_KEYS.iter().filter(|key| key.table == table).map(|key| key.name).collect()
}

const fn key(
    table: &'static str,
    name: &'static str,
    holds: &'static str,
    default: &'static str,
    meaning: &'static str,
) -> StudyKey {
    StudyKey { table, name, holds, default, meaning }
}

/// Tables of a study file in the order of the reference, each with its purpose. In two tables, the author chooses the keys.
pub const STUDY_TABLES: &[(&str, &str)] = &[
    ("", "Keys before the first table, and the tables themselves."),
    ("[set]", "Fixed values of the machine: each key is a path in quotes."),
    ("[function]", "Outputs of a study of formulas: each key is the name of an output and holds its formula."),
    ("[[vary]]", "One table for each parameter that varies. All axes are combined, the first is the slowest."),
    ("[points]", "Combinations from a CSV file."),
    ("[[uncertain]]", "One table for each uncertain parameter or variable."),
    ("[[correlation]]", "One table for each pair of uncertain inputs that are not independent."),
    ("[[derived]]", "One table for each parameter or variable that a formula gives."),
    ("[design]", "The points of the uncertain parameters."),
    ("[[question]]", "One table for each question to the finished table."),
    ("[[gate]]", "One table for each bound that a probability must meet."),
    ("[stop]", "Rules that end the study before its design does; any one key is enough."),
    ("[refine]", "Computes only the combinations of a map where the result changes."),
    ("[limits]", "Samples that may fail, and what one sample may use."),
];

const REQUIRED: &str = "required";
const NONE: &str = "none";

#[rustfmt::skip]
/// Every key, table by table. A new key is added here and in its reader.
pub const STUDY_KEYS: &[StudyKey] = &[
    key("", "schema", "1", REQUIRED, "version of this format"),
    key("", "name", "up to 64 letters, digits, `.`, `_`, `-`", "name of the file", "name of the study and of its default result directory `runs/NAME`"),
    key("", "model", "`\"function\"`", NONE, "formulas instead of a machine"),
    key("", "machine", "path relative to the study file", "required, except with `model`", "machine file"),
    key("", "function", "table", NONE, "see `[function]`"),
    key("", "seed", "whole number", "0", "seed of all random choices: the shuffle of `--limit`, the points of a `[design]`"),
    key("", "set", "table", NONE, "see `[set]`"),
    key("", "vary", "array of tables", NONE, "see `[[vary]]`"),
    key("", "points", "table", NONE, "see `[points]`"),
    key("", "uncertain", "array of tables", NONE, "see `[[uncertain]]`"),
    key("", "correlation", "array of tables", NONE, "see `[[correlation]]`"),
    key("", "derived", "array of tables", NONE, "see `[[derived]]`"),
    key("", "design", "table", NONE, "see `[design]`; needs `[[uncertain]]`"),
    key("", "limits", "table", NONE, "see `[limits]`"),
    key("", "twin_share", "share such as `\"10 %\"`", "`run.twin` of the machine", "share of the samples that run twice, the second time slightly faster"),
    key("", "question", "array of tables", NONE, "see `[[question]]`"),
    key("", "gate", "array of tables", NONE, "see `[[gate]]`"),
    key("", "stop", "table", NONE, "see `[stop]`"),
    key("", "refine", "table", NONE, "see `[refine]`"),

    key("[[vary]]", "path", "path of a parameter, or its unique ending", "required with a machine", "parameter that varies"),
    key("[[vary]]", "name", "letters, digits, `_`", "required with `model = \"function\"`", "variable that varies"),
    key("[[vary]]", "as", "letters, digits, `_`", NONE, "short name in formulas and of the column"),
    key("[[vary]]", "from", "quantity", "required without `values`", "first value of a range"),
    key("[[vary]]", "to", "quantity", "required without `values`", "last value of a range"),
    key("[[vary]]", "count", "whole number, at least 2", "required without `values`", "number of values of a range, both ends included"),
    key("[[vary]]", "spacing", "`\"linear\"` or `\"log\"`", "`\"linear\"`", "equal differences or equal ratios"),
    key("[[vary]]", "values", "list of quantities, or of words", "required without a range", "values of the axis"),
    key("[[vary]]", "zip", "text", NONE, "axes of the same name advance together"),

    key("[points]", "file", "path relative to the study file", REQUIRED, "CSV file with one combination per row"),
    key("[points]", "carry", "list of columns", "empty", "columns that are copied into the table of results"),
    key("[points]", "ignore", "list of columns", "empty", "columns that are skipped"),

    key("[[uncertain]]", "path", "path of a parameter, or its unique ending", "required without `name`", "uncertain parameter of the machine"),
    key("[[uncertain]]", "name", "letters, digits, `_`", "required without `path`", "uncertain variable for formulas"),
    key("[[uncertain]]", "as", "letters, digits, `_`", NONE, "short name in formulas and of the column"),
    key("[[uncertain]]", "distribution", "word of the table of distributions", REQUIRED, "distribution of the values"),
    key("[[uncertain]]", "mean", "quantity", "by distribution", "mean before truncation"),
    key("[[uncertain]]", "median", "quantity", "by distribution", "median before truncation, instead of `mean`"),
    key("[[uncertain]]", "sd", "quantity", "by distribution", "standard deviation before truncation"),
    key("[[uncertain]]", "cv", "number", "by distribution", "coefficient of variation, `sd` divided by the mean"),
    key("[[uncertain]]", "lower", "quantity", "by distribution", "lower end, or where the distribution is truncated"),
    key("[[uncertain]]", "upper", "quantity", "by distribution", "upper end, or where the distribution is truncated"),
    key("[[uncertain]]", "mode", "quantity", "by distribution", "most probable value of a triangular distribution"),
    key("[[uncertain]]", "a", "number above 0", "by distribution", "first shape of a beta distribution"),
    key("[[uncertain]]", "b", "number above 0", "by distribution", "second shape of a beta distribution"),
    key("[[uncertain]]", "shape", "number above 0", "by distribution", "shape of a gamma or Weibull distribution"),
    key("[[uncertain]]", "scale", "quantity", "by distribution", "scale of a gamma, Weibull or Gumbel distribution"),
    key("[[uncertain]]", "location", "quantity", "by distribution", "mode of a Gumbel distribution"),
    key("[[uncertain]]", "values", "list of quantities, or of words", "by distribution", "values of a discrete distribution"),
    key("[[uncertain]]", "weights", "list of numbers", "equal", "weights of these values; they need not sum to 1"),
    key("[[uncertain]]", "file", "path relative to the study file", "by distribution", "CSV file of an empirical distribution"),
    key("[[uncertain]]", "column", "text", "by distribution", "column of that file"),

    key("[[correlation]]", "between", "two names", REQUIRED, "inputs that are correlated"),
    key("[[correlation]]", "rank", "number between -1 and 1", "one of the three", "Spearman's rank correlation"),
    key("[[correlation]]", "linear", "number between -1 and 1", "one of the three", "Pearson's correlation of the values"),
    key("[[correlation]]", "normal", "number between -1 and 1", "one of the three", "correlation of the normal numbers behind the values"),

    key("[[derived]]", "path", "path of a parameter, or its unique ending", "required without `name`", "parameter of the machine that the formula gives"),
    key("[[derived]]", "name", "letters, digits, `_`", "required without `path`", "variable that the formula gives"),
    key("[[derived]]", "as", "letters, digits, `_`", NONE, "short name in formulas and of the column"),
    key("[[derived]]", "formula", "formula", REQUIRED, "value of the parameter or variable"),

    key("[design]", "kind", "`\"monte-carlo\"`, `\"latin-hypercube\"`, `\"sobol\"`, `\"halton\"`, `\"one-at-a-time\"`, `\"morris\"`, `\"saltelli\"`", REQUIRED, "how the points are chosen"),
    key("[design]", "samples", "whole number; a power of two for `sobol` and `latin-hypercube`", "required by most kinds", "points of a replicate, or base points of `saltelli`"),
    key("[design]", "replicates", "whole number, at most 1024", "1", "independent designs; 16 or more give an interval"),
    key("[design]", "scramble", "true or false", "true", "whether `sobol` and `halton` points are scrambled"),
    key("[design]", "base", "`\"median\"` or `\"nominal\"`", "`\"median\"`", "base point of `one-at-a-time`"),
    key("[design]", "quantiles", "list of numbers between 0 and 1", "[0.1, 0.9]", "steps of `one-at-a-time`"),
    key("[design]", "trajectories", "whole number", "required by `morris`", "trajectories, each of one point more than there are parameters"),
    key("[design]", "levels", "even number, 2 to 64", "4", "levels of each parameter of `morris`"),
    key("[design]", "second_order", "true or false", "false", "whether `saltelli` separates the interactions of pairs"),

    key("[[question]]", "name", "letters, digits, `_`, `-`", REQUIRED, "name of the question and of the file of its curve"),
    key("[[question]]", "probability", "condition", "one kind of question", "probability that the condition holds"),
    key("[[question]]", "quantile", "number between 0 and 1", "one kind of question", "level that this share of the values does not exceed"),
    key("[[question]]", "of", "column, or `\"P(CONDITION)\"` of a map", "required by `quantile` and `map`", "quantity of the question"),
    key("[[question]]", "mean", "column", "one kind of question", "mean of the column"),
    key("[[question]]", "exceedance", "column", "one kind of question", "probability that the column exceeds a level, for all levels"),
    key("[[question]]", "sensitivity", "column", "one kind of question", "uncertain inputs that drive the column"),
    key("[[question]]", "method", "`\"morris\"`, `\"sobol\"`, `\"given-data\"`", "required by `sensitivity`", "measure of sensitivity"),
    key("[[question]]", "fragility", "parameter", "one kind of question", "probability as a function of this parameter"),
    key("[[question]]", "map", "two parameters", "one kind of question", "a column or a probability over two parameters"),
    key("[[question]]", "difference", "two values", NONE, "value of the question at the first, minus that at the second"),
    key("[[question]]", "vary", "parameter", "required by `difference`", "parameter with these two values"),
    key("[[question]]", "confidence", "number between 0 and 1", "0.95", "confidence level of the interval"),

    key("[[gate]]", "require", "`\"P(CONDITION) < NUMBER\"`", REQUIRED, "bound on a probability"),
    key("[[gate]]", "confidence", "number between 0 and 1", "0.95", "confidence level of the one-sided limit"),

    key("[stop]", "half_width", "number in the SI unit of the answer", NONE, "largest half width of every interval"),
    key("[stop]", "relative", "share such as `\"5 %\"`", NONE, "the same as a share of the estimate"),
    key("[stop]", "samples", "whole number", NONE, "most points; most trajectories of `morris`; most base points of `saltelli`"),
    key("[stop]", "wall", "time such as `\"8 h\"`", NONE, "longest time of a run"),

    key("[refine]", "max_samples", "whole number", REQUIRED, "most samples of the table"),
    key("[refine]", "of", "name of a question", "the only map", "map that is refined"),
    key("[refine]", "first", "two whole numbers", "every fourth value", "values of each axis that are computed first"),

    key("[limits]", "max_failed", "number, or share such as `\"5 %\"`", "`\"0 %\"`; with questions or gates `\"100 %\"`", "most failed and quarantined samples"),
    key("[limits]", "max_invalid", "number, or share", "`\"100 %\"`", "most invalid samples"),
    key("[limits]", "max_beyond", "number, or share", "`\"100 %\"`", "most samples beyond the model"),
    key("[limits]", "time_limit", "time such as `\"10 min\"`", NONE, "longest wall time of a sample"),
    key("[limits]", "memory_limit", "size such as `\"2 GB\"`", NONE, "most memory of a worker beyond what it has at its start"),
    key("[limits]", "crash_limit", "whole number, 1 to 1000", "2", "crashes of its worker that quarantine a sample"),
    key("[limits]", "kill_limit", "whole number, 1 to 1000", "5", "kills of its worker by other programs that quarantine a sample"),
];

#[cfg(test)]
mod tests {
    use super::*;
    use crate::uncertain::Distribution;

    #[test]
    fn tables_and_keys_belong_together() {
        for (table, _) in STUDY_TABLES {
            assert!(["[set]", "[function]"].contains(table) || !names(table).is_empty(), "{table} has keys");
            let name = table.trim_matches(['[', ']']);
            assert!(name.is_empty() || names("").contains(&name), "{table} is a key of the file");
        }
        for key in STUDY_KEYS {
            assert!(STUDY_TABLES.iter().any(|(table, _)| *table == key.table), "{} has a heading", key.table);
            assert_eq!(names(key.table).iter().filter(|name| **name == key.name).count(), 1, "{}", key.name);
        }
    }

    #[test]
    fn distributions_have_no_other_keys() {
        let known = names("[[uncertain]]");
        let of_all = ["path", "name", "as", "distribution"];
        let of_distributions: Vec<&str> = Distribution::keys().collect();
        assert_eq!(known, [&of_all[..], &of_distributions].concat());
    }
}
