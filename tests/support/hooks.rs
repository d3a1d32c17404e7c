//! Words of the fault hooks, which the released binary must not contain.

/// Name of the variable, words of its value, name of the type that reads it. Words that may occur in messages to users are left out.
pub const HOOKS: [&str; 8] = [
    "BLADEOFF_FAULT",
    "EnvironmentFaults",
    "bladeoff_dev",
    "kill-worker",
    "stop-worker",
    "hoard",
    "swapping",
    "retiring",
];

/// The words that a binary contains.
pub fn found_in(binary: &str) -> Vec<&'static str> {
    let bytes = std::fs::read(binary).expect("the binary");
    let is_there = |word: &&str| bytes.windows(word.len()).any(|window| window == word.as_bytes());
    HOOKS.into_iter().filter(is_there).collect()
}
