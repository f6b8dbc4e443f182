//! What holds of the numbers of every answer and of its figures, whatever was recorded.

use slipstream_answer::{Answer, Figures, Finding, Motion, ParameterEstimate, Profile, Verdict};

use crate::contradictions::worse;

/// Numbers that were computed on two ways differ by this share at most.
const ROUNDING: f64 = 1e-9;
/// Stamps that are wrong by less tell nothing (s).
const NO_TIME_S: f64 = 1e-9;

/// Every invariant that an answer breaks, in words.
pub(crate) fn broken(answer: &Answer, figures: &[Figures]) -> Vec<String> {
    let mut all: Vec<String> = answer.findings.iter().flat_map(of_finding).collect();
    all.extend(of_errors(answer));
    for own in figures {
        all.extend(own.profiles.iter().filter_map(|p| lowest(answer, p)));
        all.extend(own.spans_s.iter().filter_map(|s| backwards(s, "a run")));
        all.extend(late_limits(own, answer.held_out.horizon_s));
        all.extend(late_parts(answer, own));
    }
    for own in &answer.outliers {
        if own.count != own.times_s.len() {
            all.push(format!(
                "{} outliers with {} times",
                own.count,
                own.times_s.len()
            ));
        }
    }
    let sizes = answer.detectable.iter().filter_map(|own| own.smallest);
    let noises = answer.process_noise.iter().map(|own| own.size);
    for size in sizes.chain(noises) {
        if !(size >= 0.0 && size.is_finite()) {
            all.push(format!("a size of {size}"));
        }
    }
    all
}

fn of_finding(own: &Finding) -> Vec<String> {
    let place = own.place.intervals_s.iter();
    let mut all: Vec<String> = place
        .filter_map(|span| backwards(span, &own.effect))
        .collect();
    for pair in own.place.intervals_s.windows(2) {
        if pair[1][0] < pair[0][1] {
            all.push(format!("{}: intervals {pair:?} overlap", own.effect));
        }
    }
    let p = own.evidence.p_value;
    if !(0.0..=1.0).contains(&p) {
        all.push(format!("{}: p = {p}", own.effect));
    }
    all.extend(own.parameters.iter().flat_map(|p| of_parameter(own, p)));
    all
}

/// An interval holds its estimate, and that from before the value from before.
fn of_parameter(finding: &Finding, own: &ParameterEstimate) -> Vec<String> {
    let pairs = [(own.estimate, own.ci95), (own.nominal, own.nominal_ci95)];
    let both = pairs.into_iter().filter_map(|(at, ends)| at.zip(ends));
    let mut all: Vec<String> = both
        .filter(|(at, [low, high])| !(low <= at && at <= high && (high - low).is_finite()))
        .map(|(at, ends)| format!("{} {}: {at} in {ends:?}", finding.effect, own.name))
        .collect();
    if own.text.is_none() && (own.estimate.is_none() || own.ci95.is_none()) {
        all.push(format!("{} {}: no estimate", finding.effect, own.name));
    }
    all
}

fn backwards([from, to]: &[f64; 2], what: &str) -> Option<String> {
    (from.is_nan() || to < from).then(|| format!("{what} lasts from {from} to {to} s"))
}

/// No error is negative, and none that is called explained is larger than before.
fn of_errors(answer: &Answer) -> Vec<String> {
    let channels = answer.held_out.channels.iter();
    let channels = channels.map(|own| {
        let name = format!("{} {}", own.robot, own.channel);
        (name, [own.rms_before, own.rms_after, own.rms_expected])
    });
    let budgets = answer.budget.iter();
    let budgets = budgets.map(|own| {
        let name = format!("{} budget in {}", own.robot, own.unit);
        (name, [own.before, own.after, own.expected])
    });
    let is_odd = |own: &f64| !(*own >= 0.0 && own.is_finite());
    let odd = channels.chain(budgets);
    let mut all: Vec<String> = odd
        .filter(|(_, numbers)| numbers.iter().any(is_odd))
        .map(|(name, numbers)| format!("{name}: {numbers:?}"))
        .collect();
    if answer.verdict == Verdict::Explained {
        all.extend(worse(answer));
    }
    all
}

/// The lowest point of a curve lies at the estimate, beside it, or at least in its interval, unless the answer says that the fit did not come to
/// its end.
fn lowest(answer: &Answer, own: &Profile) -> Option<String> {
    if answer.warnings.iter().any(|own| own.id == "unfinished") {
        return None;
    }
    let finding = answer.findings.get(own.finding)?;
    let mut parameters = finding.parameters.iter();
    let parameter = parameters.find(|p| p.name == own.parameter)?;
    let estimate = parameter.estimate?;
    let by_error = |a: &(f64, f64), b: &(f64, f64)| a.1.total_cmp(&b.1);
    let (at, _) = own.points.iter().copied().min_by(by_error)?;
    let sizes = own.points.windows(2);
    let step = sizes.map(|pair| (pair[1].0 - pair[0].0).abs());
    let step = step.fold(0.0, f64::max);
    let [low, high] = parameter.ci95?;
    let known = (low.min(estimate - step) - ROUNDING)..=(high.max(estimate + step) + ROUNDING);
    (!known.contains(&at)).then(|| {
        format!(
            "{} {}: estimate {estimate} in {low} to {high}, lowest at {at} (steps of {step})",
            finding.effect, own.parameter
        )
    })
}

/// How far stamps that are wrong by `late_s` can move a prediction over the horizon (m, rad).
///
/// The robot goes so far in that time. The turn at a window's start, and the turn at its end, are wrong by as much as
/// the robot turns in that time; the first of the two is carried along over the window.
fn reach(own: &Figures, late_s: f64, horizon_s: f64) -> Option<[f64; 2]> {
    let fastest = |pick: fn(&Motion) -> &Vec<(f64, f64)>| {
        let values = own.motion.iter().flat_map(pick).map(|(_, y)| y.abs());
        values.filter(|y| y.is_finite()).fold(0.0, f64::max)
    };
    let [v, w] = [
        fastest(|own| &own.speed_m_s),
        fastest(|own| &own.turn_rad_s),
    ];
    let turn = 2.0 * w * late_s;
    (v > 0.0).then_some([2.0 * v * late_s + v * horizon_s * turn, turn])
}

fn is_clock(parameter: &str) -> bool {
    ["latency_s", "delay_s"].contains(&parameter)
}

/// No clock that was looked at could make a larger error than the robot moves in that time.
fn late_limits(own: &Figures, horizon_s: f64) -> Vec<String> {
    let clocks = own.limits.iter().filter(|own| is_clock(own.parameter));
    let known = clocks.filter_map(|limit| Some((limit, limit.size?)));
    let each = known.flat_map(|(limit, size)| {
        let most = reach(own, size, horizon_s).unwrap_or([f64::INFINITY; 2]);
        let pairs = limit.error.into_iter().zip(most);
        let over = pairs.filter_map(|(error, most)| Some((error?, most)));
        over.filter(|(error, most)| *error > most * (1.0 + ROUNDING) + NO_TIME_S)
            .map(move |(error, most)| {
                format!("{} of {size} s is worth {error} of {most}", limit.effect)
            })
    });
    each.collect()
}

/// No clock that was found takes away more than the robot moves in that time.
fn late_parts(answer: &Answer, own: &Figures) -> Vec<String> {
    let findings = answer.findings.iter().filter(|f| f.robot == own.robot);
    let clocks = findings.filter_map(|finding| {
        let mut parameters = finding.parameters.iter();
        let clock = parameters.find(|p| is_clock(&p.name))?;
        let shift = clock.estimate? - clock.nominal.unwrap_or(0.0);
        Some((finding, shift.abs()))
    });
    let each = clocks.flat_map(|(finding, shift)| {
        let most = reach(own, shift, answer.held_out.horizon_s).unwrap_or([f64::INFINITY; 2]);
        let budgets = answer.budget.iter().filter(|b| b.robot == own.robot);
        let own = budgets.filter_map(move |budget| {
            let part = budget.part_of(&finding.effect)?;
            let most = most[usize::from(budget.unit == "rad")];
            let over = !part.is_shared() && part.share > most * (1.0 + ROUNDING);
            over.then(|| format!("{} of {shift} s takes {} of {most}", part.name, part.share))
        });
        own.collect::<Vec<_>>()
    });
    each.collect()
}
