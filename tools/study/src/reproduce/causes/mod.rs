//! The paper, explained: which causes, in robots, floor, tape and profile, make the simulation agree with the final
//! positions that the paper prints.
//!
//! The 24 numbers are treated as data. Candidates are fitted jointly over both experiments, charged for every size, tested by
//! leaving out an experiment or a robot, and simulated together at the end.

mod candidate;
mod explanation;
mod fit;
mod held_out;
mod numbers;
mod refined;
mod simulated;
mod words;

use self::candidate::{Candidate, Scope};
pub use self::explanation::{Cause, Explanation, FinalPosition, HeldOut};
use self::fit::{Chosen, Problem, TAPE_M};
use self::held_out::held_out;
use self::numbers::{COUNT, Numbers, places, printed, root_mean_square};
use self::refined::Refined;
use self::simulated::{Response, Simulation};
use crate::StudyError;

/// How much more than the best a rival may leave: the 95 % point of χ² with one degree of freedom.
const RIVAL_SLACK: f64 = 3.84;

/// Explains the printed final positions.
///
/// # Errors
/// When a run fails.
pub(super) fn explain() -> Result<Explanation, StudyError> {
    explained(&Simulation::new()?, printed())
}

fn explained(simulation: &Simulation, printed: Numbers) -> Result<Explanation, StudyError> {
    let nominal = simulation.numbers(&[])?;
    let responses = Response::all(simulation)?;
    let problem = Problem {
        responses: &responses,
        nominal: &nominal,
        printed: &printed,
        known: [true; COUNT],
    };
    let chosen = told_apart(&responses, problem.chosen());
    let refined = Refined::new(simulation, &problem, chosen)?;
    let numbers = final_positions(&nominal, &refined.numbers, &printed);
    let causes = causes(&problem, &refined);
    Ok(Explanation {
        sentence: words::sentence(&causes, &numbers),
        remains: words::remains(&numbers),
        tape_m: TAPE_M,
        before_m: root_mean_square(&nominal, &printed, |_| true),
        after_m: root_mean_square(&refined.numbers, &printed, |_| true),
        held_out: held_out(&problem),
        causes,
        numbers,
    })
}

/// A cause that acts in both experiments and another of its kind that acts in one, as one in each experiment: the same, and
/// easier to read.
fn told_apart(responses: &[Response], mut chosen: Chosen) -> Chosen {
    let find = |kind, scope| {
        let is_it = |own: &Response| own.candidate == Candidate { kind, scope };
        responses.iter().position(is_it)
    };
    for place in 0..chosen.len() {
        let (response, size) = (&responses[chosen[place].0], chosen[place].1);
        let Candidate { kind, scope } = response.candidate;
        let of_one = chosen.iter().position(|&(own, _)| {
            let own = responses[own].candidate;
            own.kind == kind && matches!(own.scope, Scope::Experiment(_))
        });
        let Some(one) = of_one.filter(|_| scope == Scope::All) else {
            continue;
        };
        let Scope::Experiment(number) = responses[chosen[one].0].candidate.scope else {
            continue;
        };
        if let Some(other) = find(kind, Scope::Experiment(1 - number)) {
            chosen[one].1 += size;
            chosen[place].0 = other;
        }
    }
    chosen
}

fn final_positions(before: &Numbers, after: &Numbers, printed: &Numbers) -> Vec<FinalPosition> {
    let all = places().into_iter().enumerate();
    all.map(|(i, own)| FinalPosition {
        experiment: words::EXPERIMENTS[own.experiment].to_owned(),
        robot: format!("r{}", own.robot + 1),
        by: if own.is_taped { "tape" } else { "encoder" }.to_owned(),
        axis: if own.axis == 0 { "x" } else { "y" }.to_owned(),
        printed_m: printed[i],
        before_m: before[i],
        after_m: after[i],
    })
    .collect()
}

fn causes(problem: &Problem<'_>, refined: &Refined) -> Vec<Cause> {
    let chosen: Chosen = refined.chosen.clone();
    let cause = |(index, &(place, size)): (usize, &(usize, f64))| {
        let response = &problem.responses[place];
        let candidate = response.candidate;
        let left = problem.misfit(&problem.without(&chosen, index));
        let rivals = problem.rivals(&chosen, index, RIVAL_SLACK);
        let half = refined.half_widths[index];
        Cause {
            cause: candidate.kind.id().to_owned(),
            robot: words::robot(candidate.scope),
            experiment: words::experiment(candidate.scope),
            sentence: words::of(candidate, size),
            estimate: size,
            ci95: [size - half, size + half],
            unit: candidate.kind.unit().to_owned(),
            without_it_m: TAPE_M * (left / COUNT as f64).sqrt(),
            rivals: rivals
                .into_iter()
                .map(|(place, size)| words::of(problem.responses[place].candidate, size))
                .collect(),
            changes_m: response.at(size).to_vec(),
        }
    };
    let mut causes: Vec<Cause> = chosen.iter().enumerate().map(cause).collect();
    causes.sort_by(|a, b| b.without_it_m.total_cmp(&a.without_it_m));
    causes
}

#[cfg(test)]
mod tests {
    use super::candidate::Kind;
    use super::*;

    /// What is simulated with known causes, read with the tape, shows these causes with their sizes, and no other.
    #[test]
    fn causes_that_are_known_are_found() {
        let simulation = Simulation::new().unwrap();
        let known = [
            (Kind::FrameYaw, Scope::All, 0.02),
            (Kind::DecelerationStart, Scope::Experiment(0), -0.3),
            (Kind::WheelRadius, Scope::Robot(2), 0.02),
        ];
        let causes = known.map(|(kind, scope, size)| (Candidate { kind, scope }, size));
        let read = |m: f64| (m / TAPE_M).round() * TAPE_M;
        let numbers = simulation.numbers(&causes).unwrap().map(read);
        let found = explained(&simulation, numbers).unwrap();
        assert_eq!(found.causes.len(), known.len(), "{:#?}", found.causes);
        for (kind, scope, size) in known {
            let is_it = |own: &&Cause| own.cause == kind.id() && own.robot == words::robot(scope);
            let own = found.causes.iter().find(is_it).unwrap();
            let [low, high] = own.ci95;
            assert!(low <= size && size <= high, "{own:?}");
            assert!((own.estimate - size).abs() < 0.1 * size.abs(), "{own:?}");
        }
        assert!(found.numbers.iter().all(|own| own.is_within(own.after_m)));
        assert_eq!(found.remains, "");
    }

    /// What is simulated as assumed needs no cause.
    #[test]
    fn nothing_is_found_where_nothing_differs() {
        let simulation = Simulation::new().unwrap();
        let numbers = simulation.numbers(&[]).unwrap();
        let found = explained(&simulation, numbers).unwrap();
        assert_eq!(found.causes, []);
        assert_eq!(found.after_m, 0.0);
    }
}
