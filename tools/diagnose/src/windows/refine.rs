//! The numbers of a law fitted where it leads: those that answers around another motion ask for are
//! right to first order alone.

use rayon::prelude::*;

use crate::windows::around::moved;
use crate::windows::bench::{Bench, Node};
use crate::windows::force::{self, Missing};
use crate::windows::law::Law;
use crate::windows::search::deviance;

/// How often answers are taken anew at most.
const ROUNDS: usize = 6;
/// Δ(−2 ln L) of a round that leads no further.
const FURTHER: f64 = 10.0;
/// Shares of a step that are tried until it leads nearer to what was measured.
const SHARES: [f64; 4] = [1.0, 0.5, 0.25, 0.1];

/// A law that leads nearer to what was measured than a node does without it.
pub(crate) struct Refined {
    pub(crate) missing: Missing,
    /// −2 ln L under it.
    pub(crate) deviance: f64,
}

/// The law with the numbers that lead nearest to what was measured in the windows of `bench`, begun
/// from the best of these. `None` where none leads nearer than it is without. The effects of the node
/// stay as they are.
pub(crate) fn refined(bench: &Bench, node: &Node, begun: &[Missing]) -> Option<Refined> {
    let lead = |missing: &Missing, from: &Node| {
        let law = Law::new(bench, missing.clone());
        moved(&bench.under(Some(law)), from)
    };
    let nearer = |from: &Missing, step: &[f64], there: &Node| {
        SHARES.iter().find_map(|share| {
            let next = from.further(step, *share);
            let moved = lead(&next, there)?;
            (deviance(&moved) < deviance(there)).then_some((next, moved))
        })
    };
    let without = deviance(&moved(bench, node)?);
    let begun = begun.par_iter().filter_map(|begun| {
        let nothing = begun.nothing();
        SHARES.iter().find_map(|share| {
            let next = nothing.further(&begun.weights, *share);
            let moved = lead(&next, &begun_under(bench, node, &next)?)?;
            (deviance(&moved) < without).then_some((next, moved))
        })
    });
    let begun: Vec<_> = begun.collect();
    let nearest = begun
        .into_iter()
        .min_by(|a, b| deviance(&a.1).total_cmp(&deviance(&b.1)));
    let (mut best, mut there) = nearest?;
    for _ in 0..ROUNDS {
        let under = bench.under(Some(Law::new(bench, best.clone())));
        let Some(answers) = force::answers(&under, &there, 1.0) else {
            break;
        };
        let step = force::step(&under, &there, &answers, &best);
        let before = deviance(&there);
        let Some(next) = nearer(&best, &step, &there) else {
            break;
        };
        (best, there) = next;
        if deviance(&there) > before - FURTHER {
            break;
        }
    }
    Some(Refined {
        deviance: deviance(&there),
        missing: best,
    })
}

/// The node with windows that begin where a law leads over ever longer heads: a start that was fitted
/// without it may be far off.
fn begun_under(bench: &Bench, node: &Node, missing: &Missing) -> Option<Node> {
    let under = bench.under(Some(Law::new(bench, missing.clone())));
    let mut begun = node.clone();
    begun.fit.starts = under.begun(&node.hypotheses)?;
    Some(begun)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::windows::law::tests::slope;

    /// The weight on a slope, begun from half of it. What it is as a function of the heading shows where
    /// the robot headed alone, and two windows hold what they tell little of: a tenth, from a half.
    #[test]
    fn numbers_are_found_where_they_lead() {
        let (bench, node, truth) = slope();
        let half = truth.nothing().further(&truth.weights, 0.5);
        let found = refined(&bench, &node, &[half]).unwrap();
        assert!(found.deviance < deviance(&node));
        let answers = force::answers(&bench, &node, 1.0).unwrap();
        for sampled in force::samples(&answers).iter().flatten() {
            let pull = |missing: &Missing| {
                let Missing { driver, part, .. } = missing;
                driver.force(&missing.weights, sampled, *part)
            };
            let (found, truth) = (pull(&found.missing), pull(&truth));
            assert!(
                (found - truth).abs() < 0.1 * truth.abs().max(0.1),
                "{found} for {truth}"
            );
        }
    }

    #[test]
    fn what_leads_away_is_no_law() {
        let (bench, node, missing) = slope();
        let uphill = missing.nothing().further(&missing.weights, -1.0);
        assert!(refined(&bench, &node, &[uphill]).is_none());
    }
}
