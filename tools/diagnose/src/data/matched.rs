//! Rows of two recordings of one course that were measured at the same moment: by their number where as many
//! were recorded, else by their stamps.

use slipstream_recording::recording::{Robot, Stream};

use super::origin_of;
use crate::data::wheel_path::median_interval;

/// Rows that are left of the longer recording, as a share: with fewer the recordings are not compared row
/// by row.
const LEAST_SHARE: f64 = 0.9;
/// Stamps within this share of an interval are one.
const NEAR: f64 = 0.25;

/// Stamps (s) of a stream in two recordings, counted from their origins, row beside row.
pub(crate) struct Stamps {
    pairs: Vec<[f64; 2]>,
}

impl Stamps {
    /// Of a stream of two robots; `None` where one of them has none.
    pub(crate) fn new<V>(
        robots: [&Robot; 2],
        stream: impl Fn(&Robot) -> Option<&Stream<V>>,
    ) -> Option<Self> {
        let [first, second] = robots.map(|robot| {
            let origin_s = origin_of(robot);
            let own = stream(robot)?;
            Some(own.t_s.iter().map(|t| t - origin_s).collect::<Vec<f64>>())
        });
        let (first, second) = (first?, second?);
        let pairs = if first.len() == second.len() {
            first.iter().zip(&second).map(|(a, b)| [*a, *b]).collect()
        } else {
            nearest(&first, &second)
        };
        Some(Self { pairs })
    }

    /// How much later (s) and faster the second recording was stamped (least squares).
    fn shift(&self) -> [f64; 2] {
        let count = self.pairs.len().max(1) as f64;
        let mean = |of: &dyn Fn(&[f64; 2]) -> f64| self.pairs.iter().map(of).sum::<f64>() / count;
        let (t, later) = (mean(&|p| p[0]), mean(&|p| p[1] - p[0]));
        let square = mean(&|p| (p[0] - t).powi(2));
        let both = mean(&|p| (p[0] - t) * (p[1] - p[0] - later));
        let rate = if square > 0.0 { both / square } else { 0.0 };
        [later - rate * t, rate]
    }

    /// Numbers of the rows that both lists of stamps have, out of those of the two recordings.
    fn rows(&self, first: &[f64], second: &[f64]) -> Option<Vec<[usize; 2]>> {
        let find = |all: &[f64], t_s: f64| {
            let at = all.partition_point(|own| *own < t_s);
            (all.get(at) == Some(&t_s)).then_some(at)
        };
        let pairs = self.pairs.iter();
        let rows: Vec<[usize; 2]> = pairs
            .filter_map(|[a, b]| Some([find(first, *a)?, find(second, *b)?]))
            .collect();
        let longer = first.len().max(second.len()) as f64;
        (rows.len() as f64 >= LEAST_SHARE * longer).then_some(rows)
    }

    /// Keeps of two lists the rows that both have; `false`, and nothing is changed, where these are too few.
    pub(crate) fn keep<R: Copy>(
        &self,
        [first, second]: [&mut Vec<R>; 2],
        time_s: impl Fn(&R) -> f64,
    ) -> bool {
        let times = |all: &[R]| all.iter().map(&time_s).collect::<Vec<f64>>();
        let Some(rows) = self.rows(&times(first), &times(second)) else {
            return false;
        };
        *first = rows.iter().map(|[a, _]| first[*a]).collect();
        *second = rows.iter().map(|[_, b]| second[*b]).collect();
        true
    }
}

/// How much later (s) and faster a stream was stamped against another one than before.
pub(crate) fn shift_against(own: Option<&Stamps>, other: Option<&Stamps>) -> [f64; 2] {
    let [own, other] = [own, other].map(|stamps| stamps.map_or([0.0; 2], Stamps::shift));
    [own[0] - other[0], own[1] - other[1]]
}

/// Stamps of both lists that are one.
fn nearest(first: &[f64], second: &[f64]) -> Vec<[f64; 2]> {
    let near_s = NEAR * median_interval(first);
    let mut at = 0;
    let mut pairs = Vec::new();
    for a in first {
        while at < second.len() && second[at] < a - near_s {
            at += 1;
        }
        if let Some(b) = second.get(at).filter(|b| **b <= a + near_s) {
            pairs.push([*a, *b]);
            at += 1;
        }
    }
    pairs
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_are_matched_by_number_or_by_stamp() {
        let first: Vec<f64> = (0..20).map(|k| f64::from(k) * 0.1).collect();
        let mut second = first.clone();
        second.remove(7);
        let stamps = Stamps {
            pairs: nearest(&first, &second),
        };
        let (mut a, mut b) = (first.clone(), second.clone());
        assert!(stamps.keep([&mut a, &mut b], |t| *t));
        assert_eq!(a, second);
        assert_eq!(b, second);
        second.truncate(10);
        let stamps = Stamps {
            pairs: nearest(&first, &second),
        };
        let (mut a, mut b) = (first.clone(), second);
        assert!(!stamps.keep([&mut a, &mut b], |t| *t));
        assert_eq!(a, first);
    }
}
