//! Randomly drawn cases.

use super::case_spec::{CaseSpec, PAIRED, WITHHELD};
use crate::maker::draw_effect::{OUTSIDE_KINDS, VOCABULARY};
use crate::maker::random::RandomStream;

/// Draws the specification of one case.
pub(super) fn sealed(random: &mut RandomStream) -> CaseSpec {
    let one = |random: &mut RandomStream| *random.choose(&VOCABULARY);
    match random.unit() {
        ..0.2 => {
            let mut null = CaseSpec::new("null", &[]);
            null.disturbed = random.bernoulli(0.25);
            null
        }
        ..0.5 => CaseSpec::new("single", &[one(random)]),
        ..0.68 => {
            let deviations = Some(random.log_uniform(9.0, 200.0));
            CaseSpec {
                deviations,
                ..CaseSpec::new("small", &[one(random)])
            }
        }
        ..0.82 => {
            let first = *random.choose(&PAIRED);
            let others: Vec<&str> = PAIRED.into_iter().filter(|id| *id != first).collect();
            CaseSpec::new("pair", &[first, *random.choose(&others)])
        }
        ..0.85 => {
            let first = (random.unit() * PAIRED.len() as f64) as usize;
            let next = |step: usize| PAIRED[(first + step) % PAIRED.len()];
            CaseSpec::new("triple", &[next(0), next(4), next(9)])
        }
        ..0.95 => {
            let kind = (random.unit() * OUTSIDE_KINDS as f64) as usize;
            CaseSpec {
                outside: Some(kind),
                ..CaseSpec::new("outside", &[])
            }
        }
        _ => CaseSpec {
            withheld: true,
            ..CaseSpec::new("withheld", &[*random.choose(&WITHHELD)])
        },
    }
}
