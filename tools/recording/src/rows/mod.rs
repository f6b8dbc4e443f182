//! Rows of streams in blocks of bounded size, so that a recording of any length is read, written and
//! checked in the same memory.
//!
//! [`Rows`] is a stream to read: columns in memory, or a [`Spool`], whose blocks lie in an unlinked
//! temporary file ([`Disk`]). Both give their rows as [`Table`](crate::table::Table)s of at most
//! a thousand rows. [`AllRows`] is a whole recording in this form,
//! [`SpooledRecording`] one whose rows are in spools.

mod all_rows;
mod block;
mod cursor;
mod disk;
mod rest;
mod select;
mod sort;
mod spool;
mod spooled;

pub(crate) use all_rows::{AllRows, LinkRows, RobotRows};
pub(crate) use cursor::{RowCursor, Rows};
pub use disk::Disk;
pub(crate) use rest::{rows_after, rows_until};
pub(crate) use select::{Selection, median};
pub(crate) use sort::sorted_by_time;
pub(crate) use spool::Spool;
pub(crate) use spooled::SpooledRecording;
