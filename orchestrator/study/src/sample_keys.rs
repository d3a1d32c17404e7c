//! Keys of samples, under which results are recorded.
//!
//! A key combines the identity of the sample's machine (`MachineDef::identity`, every parameter after overrides except `run.step_limit`, which
//! is a budget), the numerics version and the frozen basis. The same sample has the same key in a study with more points, another `--scale`,
//! `--limit` or order of axes, and whether a parameter is varied or given in the machine file.

use super::Samples;
use super::definition::{Study, Subject};
use super::function::FunctionModel;
use super::parameter::{Origin, Parameter};
use bladeoff_model::machine::{ParamValue, STEP_LIMIT};
use bladeoff_system::threads::in_parallel;
use rayon::prelude::*;

/// Number of samples whose keys are computed at a time for a digest.
const AT_ONCE: usize = 1 << 20;
/// Most stored keys: 64 MiB.
const MOST_KEPT: usize = 1 << 22;

/// Identity of a sample's inputs: machine, numerics version and basis. Equal keys have equal outcomes.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct SampleKey(pub u128);

/// Versions that identify the results of a build.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Versions {
    /// Version of the numerics, for all engines.
    pub numerics: u32,
    /// Revision of the results of the exponential engine, for the machines that this engine computes.
    pub exponential: u8,
}

/// Keys of all samples of a study: a sum of one term per axis and one per drawn or derived value.
#[derive(Debug, Clone)]
pub struct SampleKeys<'a> {
    samples: &'a Samples,
    exponential_revision: u8,
    base: u128,
    /// Term of each position of each axis.
    axes: Vec<Vec<u128>>,
    limit: StepLimit,
    /// Term of a sample without a twin in a study with `twin_share`.
    alone: u128,
    /// Keys of the first samples, stored by [`SampleKeys::digest`].
    kept: Vec<SampleKey>,
}

/// Source of a sample's `run.step_limit`.
#[derive(Debug, Clone, Copy)]
enum StepLimit {
    /// One value for all samples.
    Fixed(Option<u64>),
    /// A parameter with this index.
    Varied(usize),
}

impl<'a> SampleKeys<'a> {
    /// Prepares the terms of the keys for results of these versions with the frozen `basis`.
    #[must_use]
    pub fn new(samples: &'a Samples, versions: Versions, basis: &[u8]) -> Self {
        let study = samples.study();
        let revision = versions.exponential;
        let along = |axis: usize| {
            let of_axis = move |parameter: &&Parameter| matches!(parameter.origin, Origin::Varied(of, _) if of == axis);
            samples.parameters().iter().filter(of_axis)
        };
        let axes = study.axes.iter().enumerate().map(|(number, axis)| {
            let term = |position: u64| {
                let pairs = along(number).zip(&axis.varied);
                pairs.fold(0u128, |sum, (parameter, varied)| {
                    sum.wrapping_add(term(study, parameter, &varied.values.at(position), revision))
                })
            };
            (0..axis.length).map(term).collect()
        });
        let limit = samples.parameters().iter().position(|parameter| parameter.info.path == STEP_LIMIT);
        let fixed = study.machine().and_then(|machine| machine.def.step_limit());
        let alone = study.twin.as_ref().zip(study.machine()).map_or(0, |(twin, machine)| {
            machine.def.identity_change(&twin.info, &ParamValue::Number(0.0), revision).expect("0 is no twin")
        });
        let identity = match &study.subject {
            Subject::Machine(machine) => machine.def.identity(revision),
            Subject::Function(function) => function.identity(),
        };
        Self {
            samples,
            exponential_revision: revision,
            alone,
            base: identity.wrapping_add(solver(versions.numerics, basis)),
            axes: axes.collect(),
            limit: limit.map_or(StepLimit::Fixed(fixed), StepLimit::Varied),
            kept: Vec::new(),
        }
    }

    /// `run.step_limit` of a sample.
    #[must_use]
    pub fn step_limit(&self, sample: u64) -> Option<u64> {
        match self.limit {
            StepLimit::Fixed(limit) => limit,
            StepLimit::Varied(place) => match self.samples.values(sample)[place] {
                ParamValue::Number(steps) => Some(steps as u64),
                ParamValue::Choice(_) => None,
            },
        }
    }

    /// The key of a sample.
    #[must_use]
    pub fn key(&self, sample: u64) -> SampleKey {
        let kept = usize::try_from(sample).ok().and_then(|sample| self.kept.get(sample));
        kept.copied().unwrap_or_else(|| self.computed(sample))
    }

    fn computed(&self, sample: u64) -> SampleKey {
        let positions = self.samples.positions(sample);
        let terms = self
            .axes
            .iter()
            .zip(positions)
            .map(|(axis, position)| axis[usize::try_from(position).expect("a position indexes memory")]);
        let mut key = terms.fold(self.base, u128::wrapping_add);
        let parameters = self.samples.parameters();
        if parameters.iter().any(Parameter::is_own) {
            let pairs = parameters.iter().zip(self.samples.values(sample)).filter(|(parameter, _)| parameter.is_own());
            let study = self.samples.study();
            key = pairs.fold(key, |key, (parameter, value)| {
                key.wrapping_add(term(study, parameter, &value, self.exponential_revision))
            });
        }
        let has_twin = self.samples.twin(sample).is_none_or(|shift| shift != 0.0);
        SampleKey(if has_twin { key } else { key.wrapping_add(self.alone) })
    }

    /// Key of the same sample with the opposite choice of `twin_share`: with a twin if it has none, and without if it has one.
    #[must_use]
    pub fn otherwise(&self, sample: u64) -> Option<SampleKey> {
        let SampleKey(key) = self.key(sample);
        let shift = self.samples.twin(sample)?;
        Some(SampleKey(if shift != 0.0 { key.wrapping_add(self.alone) } else { key.wrapping_sub(self.alone) }))
    }

    /// Hash of all keys and step limits in order: equal for studies with the same samples in the same order. The keys of the first 4 million
    /// samples are stored.
    #[must_use]
    pub fn digest(&mut self) -> String {
        let mut hasher = blake3::Hasher::new();
        let count = self.samples.count();
        let mut kept = Vec::new();
        let of = |sample| (self.key(sample), self.step_limit(sample));
        for from in (0..count).step_by(AT_ONCE) {
            let some = from..count.min(from + AT_ONCE as u64);
            // keys require drawn values: computed on all cores, or on this thread if no threads can be started
            let found: Vec<(SampleKey, Option<u64>)> = in_parallel(|| some.clone().into_par_iter().map(of).collect())
                .unwrap_or_else(|_| some.clone().map(of).collect());
            for (key, limit) in found {
                if kept.len() < MOST_KEPT {
                    kept.push(key);
                }
                hasher.update(&key.0.to_le_bytes());
                if let Some(limit) = limit {
                    hasher.update(b"step limit").update(&limit.to_le_bytes());
                }
            }
        }
        self.kept = kept;
        hasher.finalize().to_hex().to_string()
    }
}

/// Term of a value; 0 for a parameter that the solver does not take.
fn term(study: &Study, parameter: &Parameter, value: &ParamValue, exponential_revision: u8) -> u128 {
    match &study.subject {
        // formulas may refer to the variable by its short name
        Subject::Function(_) => match &parameter.short {
            Some(short) => FunctionModel::identity_of(&format!("{} as {short}", parameter.info.path), value),
            None => FunctionModel::identity_of(&parameter.info.path, value),
        },
        Subject::Machine(_) if parameter.is_variable => 0,
        // values that the machine rejects are rejected before any sample runs
        Subject::Machine(machine) => {
            machine.def.identity_change(&parameter.info, value, exponential_revision).unwrap_or(0)
        }
    }
}

/// Part of a key that does not depend on the machine.
fn solver(numerics: u32, basis: &[u8]) -> u128 {
    let mut hasher = blake3::Hasher::new();
    hasher.update(b"numerics").update(&numerics.to_le_bytes()).update(blake3::hash(basis).as_bytes());
    u128::from_le_bytes(*hasher.finalize().as_bytes().first_chunk().expect("a hash has 32 bytes"))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::load;
    use std::collections::BTreeSet;
    use std::fs;
    use std::path::Path;

    const VERSIONS: Versions = Versions { numerics: 4, exponential: 1 };

    fn samples(folder: &Path, vary: &str) -> Samples {
        let rig = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../studies/machines/lab_rig.toml");
        fs::copy(rig, folder.join("rig.toml")).expect("copied");
        let text = format!("schema = 1\nmachine = \"rig.toml\"\n{vary}");
        fs::write(folder.join("s.toml"), text).expect("written");
        Samples::new(load(&folder.join("s.toml"), |_| Vec::new()).expect("a study"), None, None).expect("samples")
    }

    #[test]
    fn a_key_is_the_identity_of_the_machine_whatever_varies() {
        let folder = tempfile::tempdir().expect("temporary directory");
        // otherwise the other detection would change the engine of all samples
        let none = "[set]\n\"run.engine\" = \"reduced\"\n";
        let gap = format!("{none}[[vary]]\npath = \"contact.gap\"\nvalues = [\"0.5 mm\", \"0.6 mm\", \"0.5 mm\"]\n");
        let two = format!("{gap}[[vary]]\npath = \"contact.detection\"\nvalues = [\"hyp2\", \"hyp1\"]\n");
        let basis = b"a basis";
        let mut sets = Vec::new();
        for vary in [none, &gap, &two] {
            let samples = samples(folder.path(), vary);
            let keys = SampleKeys::new(&samples, VERSIONS, basis);
            for sample in 0..samples.count() {
                let identity = samples.machine(sample).identity(VERSIONS.exponential).wrapping_add(solver(4, basis));
                assert_eq!(keys.key(sample), SampleKey(identity), "{}", samples.describe(sample));
            }
            assert_ne!(keys.key(0), SampleKeys::new(&samples, VERSIONS, b"another").key(0));
            assert_ne!(keys.key(0), SampleKeys::new(&samples, Versions { numerics: 5, ..VERSIONS }, basis).key(0));
            sets.push((0..samples.count()).map(|sample| keys.key(sample)).collect::<BTreeSet<_>>());
        }
        assert_eq!(sets.iter().map(BTreeSet::len).collect::<Vec<_>>(), [1, 2, 4], "equal inputs, equal keys");
        assert!(sets[0].is_subset(&sets[1]) && sets[1].is_subset(&sets[2]), "an added axis keeps what was there");
    }

    #[test]
    fn a_step_limit_is_in_no_key_but_in_the_digest() {
        let folder = tempfile::tempdir().expect("temporary directory");
        let basis = b"a basis";
        let set = "[set]\n\"run.step_limit\" = 300\n";
        let varied = "[[vary]]\npath = \"run.step_limit\"\nvalues = [100, 300]\n";
        let (without, fixed, varied) =
            (samples(folder.path(), ""), samples(folder.path(), set), samples(folder.path(), varied));
        let mut keys = [&without, &fixed, &varied].map(|samples| SampleKeys::new(samples, VERSIONS, basis));
        assert_eq!(keys.each_ref().map(|keys| keys.step_limit(0)), [None, Some(300), Some(100)]);
        assert_eq!(keys[2].step_limit(1), Some(300));
        assert!(keys.iter().all(|other| other.key(0) == keys[0].key(0)) && keys[2].key(1) == keys[0].key(0));
        let digests: BTreeSet<String> = keys.iter_mut().map(SampleKeys::digest).collect();
        assert_eq!(digests.len(), 3);
    }
}
