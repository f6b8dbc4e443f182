//! Fast paths through the most common steps of a robot without extra effects: both wheels roll, or
//! both slide. They compute what the general step computes in fewer terms, and decline where it
//! might find an event.

pub(super) mod draft;
mod path;
mod rolling;
mod sliding;

pub(super) use path::FastPath;
