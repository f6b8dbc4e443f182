//! What differs most between two recordings, in a sentence.

use super::answer::{LinkPair, RobotPair, TwoRuns};

/// Differences that count as one step each, so that those of several kinds have an order.
const STEP_SPACING_M: f64 = 0.01;
const STEP_PATH_M: f64 = 0.02;
const STEP_DELAY_S: f64 = 0.010;
const STEP_SLIP_PERCENT: f64 = 2.0;
/// Size (steps) from which a difference is said.
const SAID: f64 = 0.2;
/// Differences that are said.
const CLAUSES: usize = 3;

/// A difference: how many steps it has, and its words.
type Clause = (f64, String);

/// The sentence.
pub(super) fn headline(answer: &TwoRuns) -> String {
    let all = [
        largest_of(answer.robots.iter().filter_map(spacing)),
        largest_of(answer.robots.iter().filter_map(path)),
        largest_of(answer.links.iter().filter_map(delay)),
        largest_of(answer.robots.iter().filter_map(slip)),
    ];
    let mut known: Vec<Clause> = all.into_iter().flatten().collect();
    if known.is_empty() {
        return "Nothing to compare: no robot has poses or a traced link in both recordings."
            .to_owned();
    }
    known.sort_by(|a, b| b.0.total_cmp(&a.0));
    let said = known.iter().filter(|own| own.0 >= SAID);
    let words: Vec<&str> = said.take(CLAUSES).map(|own| &*own.1).collect();
    if words.is_empty() {
        return agreement(answer);
    }
    capital(&words.join("; ")) + "."
}

fn largest_of(clauses: impl Iterator<Item = Clause>) -> Option<Clause> {
    clauses.reduce(|most, own| if own.0 > most.0 { own } else { most })
}

fn spacing(pair: &RobotPair) -> Option<Clause> {
    let [real, simulated] = pair.spacing.as_ref()?.errors.pair()?;
    let difference_m = real.largest_m - simulated.largest_m;
    let how = if difference_m < 0.0 {
        "better"
    } else {
        "worse"
    };
    let words = format!(
        "{} keeps its distance {} {how} than simulated (largest spacing error {} against {})",
        pair.robot,
        cm(difference_m.abs()),
        cm(real.largest_m),
        cm(simulated.largest_m)
    );
    Some((difference_m.abs() / STEP_SPACING_M, words))
}

fn path(pair: &RobotPair) -> Option<Clause> {
    let path = pair.path?;
    let (robot, at_s) = (&pair.robot, path.at_s);
    let words = format!(
        "paths differ by at most {} ({robot}, {at_s:.1} s)",
        cm(path.largest_m)
    );
    let steps = match path.is_noise() {
        true => 0.0,
        false => path.largest_m / STEP_PATH_M,
    };
    Some((steps, words))
}

fn delay(link: &LinkPair) -> Option<Clause> {
    let whole = link.stages.iter().find(|own| own.stage == "end_to_end")?;
    let [real, simulated] = whole.delays.pair()?.map(|own| own.p50_s);
    let difference_s = real - simulated;
    let how = if difference_s < 0.0 {
        "sooner"
    } else {
        "later"
    };
    let words = format!(
        "positions of {} reach the wheels of {} {} {how} (median {} against {})",
        link.from,
        link.to,
        ms(difference_s.abs()),
        ms(real),
        ms(simulated)
    );
    Some((difference_s.abs() / STEP_DELAY_S, words))
}

fn slip(pair: &RobotPair) -> Option<Clause> {
    let slip = pair.slip?;
    let [real, simulated] = slip.slips.pair()?.map(|own| own.slip_percent);
    // Rounded as it is said; 0 has no sign.
    let [real, simulated] = [real?, simulated?].map(|own| (10.0 * own).round() / 10.0 + 0.0);
    let difference = real - simulated;
    let how = if difference < 0.0 { "less" } else { "more" };
    let words = format!(
        "{} slips {:.1} % {how} of its way ({real:.1} % against {simulated:.1} %)",
        pair.robot,
        difference.abs()
    );
    Some((difference.abs() / STEP_SLIP_PERCENT, words))
}

fn agreement(answer: &TwoRuns) -> String {
    let robots = answer.robots.iter();
    let path_m = robots.clone().filter_map(|own| Some(own.path?.largest_m));
    let spacing_m =
        robots.filter_map(|own| Some(own.spacing.as_ref()?.largest_difference_m?.abs()));
    let mut words = vec!["both recordings agree".to_owned()];
    if let Some(path_m) = path_m.reduce(f64::max) {
        let mut paths = answer.robots.iter().filter_map(|own| own.path);
        let noise = match path_m > 0.0 && paths.all(|path| path.is_noise()) {
            true => ", which is noise of the poses",
            false => "",
        };
        words.push(format!("paths differ by at most {}{noise}", cm(path_m)));
    }
    if let Some(spacing_m) = spacing_m.reduce(f64::max) {
        words.push(format!(
            "largest spacing errors by at most {}",
            cm(spacing_m)
        ));
    }
    let (first, others) = (&words[0], words[1..].join(", "));
    let text = if others.is_empty() {
        first.clone()
    } else {
        format!("{first}: {others}")
    };
    capital(&text) + "."
}

fn cm(metres: f64) -> String {
    format!("{:.1} cm", 100.0 * metres)
}

fn ms(seconds: f64) -> String {
    let ms = 1000.0 * seconds;
    let digits = usize::from(ms < 10.0);
    format!("{ms:.digits$} ms")
}

/// Words that begin a sentence. The name of a robot stays as it is.
fn capital(text: &str) -> String {
    for word in ["paths", "positions", "both"] {
        if let Some(rest) = text.strip_prefix(word) {
            return word[..1].to_uppercase() + &word[1..] + rest;
        }
    }
    text.to_owned()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::compare::two_runs::{
        Both, DelayPercentiles, PathApart, SpacingError, SpacingPair, StagePair,
    };

    fn robot(name: &str, largest_m: f64, spacing_m: [f64; 2]) -> RobotPair {
        let error = |largest_m: f64| SpacingError {
            spacing_m: 0.6,
            rms_m: largest_m / 2.0,
            largest_m,
            at_s: 4.0,
        };
        let [real, simulated] = spacing_m;
        RobotPair {
            robot: name.to_owned(),
            path: Some(PathApart {
                rms_m: largest_m / 2.0,
                largest_m,
                at_s: 8.4,
                start_m: 0.0,
                noise_m: None,
                poses: 100,
            }),
            spacing: Some(SpacingPair {
                ahead: "r1".to_owned(),
                errors: Both {
                    real: Some(error(real)),
                    simulated: Some(error(simulated)),
                },
                rms_difference_m: Some((real - simulated) / 2.0),
                largest_difference_m: Some(real - simulated),
            }),
            slip: None,
            lines: Default::default(),
        }
    }

    fn answer(robots: Vec<RobotPair>, delays_s: &[[f64; 2]]) -> TwoRuns {
        let percentiles = |s: f64| DelayPercentiles { p50_s: s, p95_s: s };
        let link = |[real, simulated]: &[f64; 2]| LinkPair {
            from: "r1".to_owned(),
            to: "r2".to_owned(),
            stages: vec![StagePair {
                stage: "end_to_end".to_owned(),
                delays: Both {
                    real: Some(percentiles(*real)),
                    simulated: Some(percentiles(*simulated)),
                },
                changed: None,
            }],
        };
        TwoRuns {
            format: 1,
            headline: String::new(),
            real: String::new(),
            simulated: String::new(),
            span_s: [0.0, 15.0],
            robots,
            left_out: Vec::new(),
            links: delays_s.iter().map(link).collect(),
        }
    }

    #[test]
    fn what_differs_most_comes_first() {
        let robots = || {
            vec![
                robot("r2", 0.01, [0.02, 0.02]),
                robot("r3", 0.052, [0.06, 0.019]),
            ]
        };
        assert_eq!(
            headline(&answer(robots(), &[])),
            "r3 keeps its distance 4.1 cm worse than simulated (largest spacing error 6.0 cm against 1.9 cm); paths differ by \
             at most 5.2 cm (r3, 8.4 s)."
        );
        let late = headline(&answer(robots(), &[[0.11, 0.0105]]));
        let first = "Positions of r1 reach the wheels of r2 100 ms later (median 110 ms against 10 ms); r3 keeps";
        assert!(late.starts_with(first), "{late}");
        let better = headline(&answer(vec![robot("r2", 0.0, [0.01, 0.03])], &[]));
        assert!(
            better.starts_with("r2 keeps its distance 2.0 cm better than simulated"),
            "{better}"
        );
    }

    #[test]
    fn what_noise_makes_is_no_difference_of_paths() {
        let mut robots = vec![robot("r2", 0.014, [0.02, 0.019])];
        robots[0].path.as_mut().unwrap().noise_m = Some(0.005);
        assert_eq!(
            headline(&answer(robots.clone(), &[])),
            "Both recordings agree: paths differ by at most 1.4 cm, which is noise of the poses, largest spacing errors by at most \
             0.1 cm."
        );
        robots[0].path.as_mut().unwrap().noise_m = Some(0.004);
        assert_eq!(
            headline(&answer(robots, &[])),
            "Paths differ by at most 1.4 cm (r2, 8.4 s)."
        );
    }

    #[test]
    fn small_differences_are_agreement() {
        assert_eq!(
            headline(&answer(
                vec![robot("r2", 0.003, [0.02, 0.019])],
                &[[0.05, 0.05]]
            )),
            "Both recordings agree: paths differ by at most 0.3 cm, largest spacing errors by at most 0.1 cm."
        );
        let nothing = headline(&answer(Vec::new(), &[]));
        assert!(nothing.starts_with("Nothing to compare"), "{nothing}");
    }
}
