//! Whether causes that explain some of the numbers predict the others.

use super::explanation::HeldOut;
use super::fit::Problem;
use super::numbers::{Place, places, root_mean_square};
use super::words;

/// Each experiment and each robot left out in turn.
pub(super) fn held_out(problem: &Problem<'_>) -> Vec<HeldOut> {
    let experiments = (0..2).map(|own| {
        let is_out = move |place: &Place| place.experiment == own;
        left_out(problem, words::EXPERIMENTS[own].to_owned(), is_out)
    });
    let robots = (0..3).map(|own| {
        let is_out = move |place: &Place| place.robot == own;
        left_out(problem, format!("r{}", own + 1), is_out)
    });
    experiments
        .collect::<Vec<_>>()
        .into_iter()
        .chain(robots)
        .collect()
}

fn left_out(problem: &Problem<'_>, name: String, is_out: impl Fn(&Place) -> bool) -> HeldOut {
    let own = Problem {
        known: places().map(|place| !is_out(&place)),
        ..*problem
    };
    let chosen = own.chosen();
    let predicted = own.numbers(&chosen);
    let sentence = |&(place, size): &(usize, f64)| words::of(own.responses[place].candidate, size);
    HeldOut {
        left_out: name,
        causes: chosen.iter().map(sentence).collect(),
        before_m: root_mean_square(problem.nominal, problem.printed, &is_out),
        after_m: root_mean_square(&predicted, problem.printed, &is_out),
    }
}
