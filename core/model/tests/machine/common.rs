//! Machines of the tests: shipped files, machines from text, values by path.

use bladeoff_model::machine::{Machine, MachineDef};

/// A machine file of the repository.
pub fn shipped(name: &str) -> String {
    let path = format!("{}/../../studies/machines/{name}.toml", env!("CARGO_MANIFEST_DIR"));
    std::fs::read_to_string(&path).unwrap_or_else(|error| panic!("{path}: {error}"))
}

pub fn parse(text: &str) -> MachineDef {
    MachineDef::parse("test.toml", text).unwrap_or_else(|problems| panic!("{problems}"))
}

pub fn build(text: &str) -> Machine {
    parse(text).build().unwrap()
}

pub fn set(def: &mut MachineDef, path: &str, text: &str) {
    let path = def.resolve(path).unwrap();
    let value = def.parse_value(&path, text).unwrap();
    def.set(&path, &value).unwrap();
}
