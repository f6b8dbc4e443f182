//! Resolution of a path to the file that defines its name.

use std::collections::BTreeMap;

use super::source::{Key, Module};

/// The file that defines what an absolute path names; `None` where another package does.
pub(super) fn resolve(
    modules: &BTreeMap<Key, Module>,
    path: &[String],
    depth: usize,
) -> Option<Key> {
    if depth > 16 {
        return None;
    }
    let mut key = Key::new();
    let mut rest = path;
    while let Some((first, after)) = rest.split_first() {
        let mut child = key.clone();
        child.push(first.clone());
        if !modules.contains_key(&child) {
            break;
        }
        key = child;
        rest = after;
    }
    let module = modules.get(&key)?;
    let Some(item) = rest.first() else {
        return Some(key);
    };
    if module.items.contains(item) {
        return Some(key);
    }
    if module.foreign.contains(item) {
        return None;
    }
    for behind in module.imports.get(item).into_iter().flatten() {
        let mut target = behind.clone();
        target.extend(rest[1..].iter().cloned());
        if let Some(found) = resolve(modules, &target, depth + 1) {
            return Some(found);
        }
    }
    for glob in module.imports.get("*").into_iter().flatten() {
        let found = resolve(modules, glob, depth + 1);
        if let Some(found) = found.filter(|key| modules[key].items.contains(item)) {
            return Some(found);
        }
    }
    Some(key)
}
