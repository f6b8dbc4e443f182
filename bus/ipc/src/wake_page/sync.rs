//! Atomics and futex of the page: those of the system, or with the feature `loom` their models.

#[cfg(not(feature = "loom"))]
pub(super) use std::sync::atomic::{AtomicI64, AtomicU32, AtomicU64, Ordering};

#[cfg(feature = "loom")]
pub(super) use loom::sync::atomic::{AtomicI64, AtomicU32, AtomicU64, Ordering};

#[cfg(not(feature = "loom"))]
pub(super) use super::futex::{Word, wait, wake_all};
#[cfg(feature = "loom")]
pub(super) use super::futex_model::{Word, wait, wake_all};
