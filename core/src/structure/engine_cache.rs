//! Cache of an engine beside a structure or a part of one: made once for all runs that share it, of a type that only the engine knows.

use std::any::Any;
use std::sync::{Arc, OnceLock};

/// Empty until an engine asks for it; copies share it.
#[derive(Debug, Default, Clone)]
pub(crate) struct EngineCache(Arc<OnceLock<Box<dyn Any + Send + Sync>>>);

impl EngineCache {
    /// The cached value, which begins as its default.
    pub fn get<T: Any + Default + Send + Sync>(&self) -> &T {
        let value = self.0.get_or_init(|| Box::new(T::default()));
        value.downcast_ref().expect("one engine caches one type")
    }
}

/// Caches do not tell structures apart: their content follows from the structure.
impl PartialEq for EngineCache {
    fn eq(&self, _other: &Self) -> bool {
        true
    }
}
