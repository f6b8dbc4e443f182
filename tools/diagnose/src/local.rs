//! Effects of one place or one moment: where to look for them.

use crate::bench::{Bench, Node};
use crate::hypothesis::{Hypothesis, LOCAL};

/// Whether an effect has a place or a time that is searched.
pub(crate) fn is_local(hypothesis: &Hypothesis) -> bool {
    LOCAL.contains(&hypothesis.info.id)
}

/// Places and moments at which `node` leaves most unexplained.
pub(crate) fn candidates(_bench: &Bench, _node: &Node, _excluded: &[String]) -> Vec<Hypothesis> {
    Vec::new()
}
