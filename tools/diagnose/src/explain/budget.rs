//! Where the error went: the mean square error of predictions, shared out over the claims by the
//! average over all orders in which they can be taken out (Shapley 1953).

use super::claim::Claim;
use crate::answer::{Budget, BudgetPart};

/// Most players: every subset of them is predicted once.
const MOST: usize = 10;

/// Errors below are none (m, rad).
const NOTHING: f64 = 1e-6;

/// One player: claims of one effect, and the parameters of the machine that they explain.
#[derive(Debug, Clone)]
pub(crate) struct Player {
    pub(crate) name: &'static str,
    pub(crate) toggles: Vec<usize>,
}

/// The players of these claims, those that bring most first.
pub(crate) fn players(claims: &[Claim]) -> Vec<Player> {
    let mut players: Vec<Player> = Vec::new();
    for claim in claims {
        match players.iter_mut().find(|own| own.name == claim.effect) {
            Some(own) => own.toggles.extend(&claim.toggles),
            None => players.push(Player {
                name: claim.effect,
                toggles: claim.toggles.clone(),
            }),
        }
    }
    players.truncate(MOST);
    players
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

/// The budget of a robot's prediction error, given the mean square error of every subset of `players`
/// (as bits) and that of the sensor; none of an error that is none.
pub(crate) fn budget(
    robot: &str,
    unit: &'static str,
    players: &[&str],
    worth: &[f64],
    noise: f64,
) -> Option<Budget> {
    let (first, last) = (*worth.first()?, *worth.last()?);
    let before = first.sqrt();
    if before < NOTHING {
        return None;
    }
    let noise = noise.min(last);
    let part = |name: &str, share: f64| BudgetPart {
        name: name.to_owned(),
        share: share / before,
    };
    let named = players.iter().zip(shares(players.len(), worth));
    let mut parts: Vec<BudgetPart> = named.map(|(name, share)| part(name, share)).collect();
    parts.sort_by(|a, b| b.share.total_cmp(&a.share));
    parts.push(part("unexplained", last - noise));
    parts.push(part("sensor noise", noise));
    Some(Budget {
        robot: robot.to_owned(),
        unit,
        before,
        after: last.sqrt(),
        parts,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

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
}
