//! What an engine keeps with a structure or a part of one, made once for all runs that share it: of a type that the engine knows alone.

use std::any::Any;
use std::sync::{Arc, OnceLock};

/// Empty until an engine asks for it; copies share it.
#[derive(Debug, Default, Clone)]
pub(crate) struct Kept(Arc<OnceLock<Box<dyn Any + Send + Sync>>>);

impl Kept {
    /// What is kept, begun by its default.
    pub fn of<T: Any + Default + Send + Sync>(&self) -> &T {
        let kept = self.0.get_or_init(|| Box::new(T::default()));
        kept.downcast_ref().expect("one engine keeps one type")
    }
}

/// It follows from the structure.
impl PartialEq for Kept {
    fn eq(&self, _other: &Self) -> bool {
        true
    }
}
