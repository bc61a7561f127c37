//! What is made of data while it is loaded, by code that this crate does not know.

use std::any::Any;
use std::panic::{RefUnwindSafe, UnwindSafe};
use std::sync::Arc;

/// A value of any type, shared by its copies.
#[derive(Clone, Debug)]
pub struct Derived(Arc<dyn Any + Send + Sync>);

// By what `new` asks for.
impl UnwindSafe for Derived {}
impl RefUnwindSafe for Derived {}

impl Derived {
    /// Holds `value`.
    pub fn new<T: Send + Sync + RefUnwindSafe + 'static>(value: Arc<T>) -> Derived {
        Derived(value)
    }

    /// The value, if it is of this type.
    pub fn get<T: Send + Sync + 'static>(&self) -> Option<Arc<T>> {
        Arc::clone(&self.0).downcast().ok()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_its_own_type_gets_it() {
        let value = Arc::new(7_u8);
        let derived = Derived::new(Arc::clone(&value));
        assert!(derived.get::<i8>().is_none());
        assert!(Arc::ptr_eq(&derived.clone().get::<u8>().unwrap(), &value));
    }
}
