//! Interned names: every message shares one copy of its sender's and receiver's name.

use std::sync::Arc;

/// Keeps one copy of every name.
#[derive(Debug, Default)]
pub(crate) struct NamePool(Vec<Arc<str>>);

impl NamePool {
    /// The shared copy of `name`.
    pub(crate) fn get(&mut self, name: &str) -> Arc<str> {
        if let Some(known) = self.0.iter().find(|known| ***known == *name) {
            return Arc::clone(known);
        }
        let name: Arc<str> = name.into();
        self.0.push(Arc::clone(&name));
        name
    }
}
