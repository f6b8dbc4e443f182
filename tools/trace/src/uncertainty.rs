//! By how much a duration can be wrong because the clocks of two hosts measured it.

use serde::{Deserialize, Serialize};
use slipstream_bus::time::s_from_ns;

/// By how much a duration can be wrong because it begins on the clock of one host and ends on that of
/// another. Ordered from the best to the worst.
///
/// In JSON a number of seconds, or null if it is not known; an exact duration has no field.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(into = "Option<f64>", from = "Option<f64>")]
pub enum Uncertainty {
    /// Both ends are on one clock.
    #[default]
    Exact,
    /// The true duration differs by at most this (ns).
    Within(i64),
    /// The recording does not tell the error of one of the clocks.
    Unknown,
}

impl Uncertainty {
    /// Whether both ends are on one clock.
    pub fn is_exact(&self) -> bool {
        *self == Self::Exact
    }

    /// The largest error (s); 0 if exact, `None` if it is not known.
    pub fn seconds(self) -> Option<f64> {
        match self {
            Self::Exact => Some(0.0),
            Self::Within(ns) => Some(s_from_ns(ns)),
            Self::Unknown => None,
        }
    }

    /// The uncertainty of a duration whose two ends have these errors.
    pub(crate) fn plus(self, other: Self) -> Self {
        match (self, other) {
            (Self::Within(one), Self::Within(other)) => Self::Within(one.saturating_add(other)),
            (one, other) => one.max(other),
        }
    }
}

impl From<Uncertainty> for Option<f64> {
    fn from(uncertainty: Uncertainty) -> Self {
        uncertainty.seconds()
    }
}

impl From<Option<f64>> for Uncertainty {
    fn from(seconds: Option<f64>) -> Self {
        seconds.map_or(Self::Unknown, |s| Self::Within((s * 1e9).round() as i64))
    }
}

#[cfg(test)]
mod tests {
    use super::Uncertainty::{self, Exact, Unknown, Within};

    #[test]
    fn errors_of_both_ends_add_up() {
        assert_eq!(Within(3).plus(Within(4)), Within(7));
        assert_eq!(Exact.plus(Within(4)), Within(4));
        assert_eq!(Exact.plus(Exact), Exact);
        assert_eq!(Within(i64::MAX).plus(Within(1)), Within(i64::MAX));
        assert_eq!(Unknown.plus(Within(1)), Unknown);
        assert!(Exact < Within(0) && Within(1) < Within(2) && Within(i64::MAX) < Unknown);
    }

    #[test]
    fn json_is_seconds_or_null() {
        for (uncertainty, text) in [(Within(200_001), "0.000200001"), (Unknown, "null")] {
            assert_eq!(serde_json::to_string(&uncertainty).unwrap(), text);
            assert_eq!(
                serde_json::from_str::<Uncertainty>(text).unwrap(),
                uncertainty
            );
        }
    }
}
