//! Cache of an engine in a structure or a part of it. It is filled once for all runs that share the structure; only the engine
//! knows the type of its content.

use std::any::Any;
use std::sync::{Arc, OnceLock};

/// Cache that is empty until an engine uses it; copies share the content.
#[derive(Debug, Default, Clone)]
pub(crate) struct EngineCache(Arc<OnceLock<Box<dyn Any + Send + Sync>>>);

impl EngineCache {
    /// The cached value; initially the default of its type.
    pub fn get<T: Any + Default + Send + Sync>(&self) -> &T {
        let value = self.0.get_or_init(|| Box::new(T::default()));
        value.downcast_ref().expect("one engine caches one type")
    }
}

/// All caches are equal, because their content follows from the structure.
impl PartialEq for EngineCache {
    fn eq(&self, _other: &Self) -> bool {
        true
    }
}
