//! Where the error went: the fall of the mean square error, shared out over the findings by the average over
//! all orders in which they can be taken out (Shapley 1953).

use crate::answer::{Budget, BudgetPart};

/// Errors below are none (m, rad).
const NOTHING: f64 = 1e-6;

/// Mean square errors of one quantity of one robot.
pub(super) struct Squares<'a> {
    pub(super) robot: &'a str,
    /// `m` or `rad`.
    pub(super) unit: &'static str,
    /// On time that no fit has seen, without and with the findings.
    pub(super) held_out: [f64; 2],
    /// Of the sensor, and what noise altogether predicts.
    pub(super) sensor: f64,
    pub(super) expected: f64,
}

/// Share of each player in `worth(none) − worth(all)`, given what every subset (as bits) is worth.
fn shares(players: usize, worth: &[f64]) -> Vec<f64> {
    let mut factorials = vec![1.0];
    for k in 1..=players {
        factorials.push(factorials[k - 1] * k as f64);
    }
    (0..players)
        .map(|player| {
            let bit = 1_usize << player;
            let subsets = (0..1_usize << players).filter(|subset| subset & bit == 0);
            subsets
                .map(|subset| {
                    let size = subset.count_ones() as usize;
                    let weight =
                        factorials[size] * factorials[players - size - 1] / factorials[players];
                    weight * (worth[subset] - worth[subset | bit])
                })
                .sum()
        })
        .collect()
}

/// Number of the player that takes least away of what every subset is worth: that makes predictions worst.
pub(super) fn culprit(players: usize, worth: &[f64]) -> Option<usize> {
    let all = shares(players, worth).into_iter().enumerate();
    all.min_by(|a, b| a.1.total_cmp(&b.1))
        .map(|(player, _)| player)
}

/// Names with their shares, none negative: a player that makes predictions worse is joined with the one
/// beside which it is of most use.
fn joined(names: &[&str], worth: &[f64]) -> Vec<(String, f64)> {
    let own = shares(names.len(), worth);
    let mut groups: Vec<(Vec<&str>, f64)> = names
        .iter()
        .zip(own)
        .map(|(name, share)| (vec![*name], share))
        .collect();
    while groups.len() > 1 {
        groups.sort_by(|a, b| b.1.total_cmp(&a.1));
        let Some((last, share)) = groups.pop_if(|(_, share)| *share < 0.0) else {
            break;
        };
        // the smallest group that makes up for it, else the largest
        let place = groups.iter().rposition(|(_, own)| own + share >= 0.0);
        let group = &mut groups[place.unwrap_or(0)];
        group.0.extend(last);
        group.1 += share;
    }
    let named = groups.into_iter();
    named
        .map(|(names, share)| (names.join(" + "), share.max(0.0)))
        .collect()
}

/// The budget of a robot's prediction error, given the mean square error of every subset of the findings
/// called `names` (as bits); `None` if the error is zero.
///
/// Parts are at least 0 and add up to `before`; what is unexplained and the sensor's noise add up to `after`.
pub(super) fn budget(squares: &Squares<'_>, names: &[&str], worth: &[f64]) -> Option<Budget> {
    let [before, after] = squares.held_out.map(f64::sqrt);
    if !(before >= NOTHING && after.is_finite()) {
        return None;
    }
    let left = after.min(before);
    let mut named = joined(names, worth);
    let total: f64 = named.iter().map(|(_, share)| share).sum();
    if total <= 0.0 && !names.is_empty() {
        // which of them it was cannot be said
        named = vec![(names.join(" + "), 1.0)];
    }
    let total: f64 = named.iter().map(|(_, share)| share).sum();
    let scale = (before - left) / total;
    let mut parts: Vec<BudgetPart> = named
        .into_iter()
        .map(|(name, share)| BudgetPart {
            name,
            share: scale * share,
        })
        .collect();
    // without findings nothing is taken away
    let left = if parts.is_empty() { before } else { left };
    let sensor = left * (squares.sensor / squares.held_out[1]).min(1.0);
    for (name, share) in [("unexplained", left - sensor), ("sensor noise", sensor)] {
        parts.push(BudgetPart {
            name: name.to_owned(),
            share,
        });
    }
    Some(Budget {
        robot: squares.robot.to_owned(),
        unit: squares.unit,
        before,
        after,
        expected: squares.expected.sqrt(),
        parts,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn squares(held_out: [f64; 2]) -> Squares<'static> {
        Squares {
            robot: "r1",
            unit: "m",
            held_out,
            sensor: 0.25,
            expected: 0.25,
        }
    }

    #[test]
    fn shares_add_up_and_equals_share_equally() {
        // two players that each take 4 away alone, and 6 together; one that does nothing
        let worth: Vec<f64> = (0..8_usize)
            .map(|subset| 10.0 - [0.0, 4.0, 4.0, 6.0][subset & 3])
            .collect();
        let shares = shares(3, &worth);
        for (share, wanted) in shares.iter().zip([3.0, 3.0, 0.0]) {
            assert!((share - wanted).abs() < 1e-12, "{shares:?}");
        }
    }

    #[test]
    fn parts_add_up_whatever_the_worth() {
        // every subset of three players is worth something else, some more than nothing
        let cases: [[f64; 8]; 3] = [
            [9.0, 12.0, 4.0, 5.0, 9.5, 3.0, 2.0, 1.0],
            [9.0, 1.0, 20.0, 4.0, 9.0, 1.0, 30.0, 4.0],
            [9.0, 10.0, 11.0, 12.0, 13.0, 14.0, 15.0, 16.0],
        ];
        for worth in cases {
            let own = budget(&squares([9.0, 1.0]), &["a", "b", "c"], &worth).unwrap();
            let sum = |left: bool| -> f64 {
                let is_left = |name: &str| ["unexplained", "sensor noise"].contains(&name);
                let parts = own.parts.iter().filter(|part| is_left(&part.name) == left);
                parts.map(|part| part.share).sum()
            };
            assert!(own.parts.iter().all(|part| part.share >= 0.0), "{own:?}");
            assert!((sum(true) + sum(false) - 3.0).abs() < 1e-12, "{own:?}");
            if sum(false) > 0.0 {
                assert!((sum(true) - 1.0).abs() < 1e-12, "{own:?}");
            }
        }
    }

    #[test]
    fn a_finding_that_needs_another_is_named_with_it() {
        // b alone makes it worse, beside a it helps
        let worth = [9.0, 4.0, 16.0, 1.0];
        let own = budget(&squares([9.0, 1.0]), &["a", "b"], &worth).unwrap();
        assert_eq!(own.parts[0].name, "a + b");
        assert!((own.parts[0].share - 2.0).abs() < 1e-12);
    }

    #[test]
    fn noise_is_no_more_than_what_is_left() {
        let own = budget(&squares([9.0, 0.16]), &["a"], &[9.0, 0.16]).unwrap();
        let part = |name: &str| own.parts.iter().find(|part| part.name == name).unwrap();
        assert!((part("sensor noise").share - 0.4).abs() < 1e-12);
        assert_eq!(part("unexplained").share, 0.0);
    }
}
