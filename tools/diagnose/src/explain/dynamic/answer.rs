//! What the filter found, as findings.

use slipstream_sim::effects::When;

use super::condition::condition;
use super::selection::{Known, Selected};
use super::unknown::Unknown;
use crate::answer::{Evidence, Finding, ProcessNoise, Unexplained, Warning, in_digits};
use crate::explain::finding::{self, Named, Number};
use crate::model::hypothesis::{Hypothesis, STATIC};
use crate::model::plant::filtered::Filtered;
use crate::model::plant::machine::Machine;
use crate::select::criterion::Criterion;

/// Share of a value by which integrators differ.
const INTEGRATORS: f64 = 0.0015;
/// Half width of a 95 % interval of a normal distribution (deviations).
const NORMAL: f64 = 1.96;
/// Speed at which a contact counts as sliding (m/s), and the gap that does not part an interval (s).
const SLIDING_M_S: f64 = 3e-3;
const GAP_S: f64 = 0.1;
/// Duration of a push (s).
const PUSH_S: f64 = 0.06;
/// Multiple of the floor from which on a size of process noise is said.
const ABOVE_FLOOR: f64 = 3.0;

/// The findings of one machine.
pub(crate) fn findings(machine: &Machine, selected: &Selected) -> Vec<Finding> {
    let mut first = 0;
    let mut out = Vec::new();
    for (index, hypothesis) in selected.fit.hypotheses.iter().enumerate() {
        let numbers = hypothesis.values.iter().enumerate();
        let intervals = numbers.map(|(i, (name, value))| {
            interval(machine, selected, [index, first + i], (name, *value))
        });
        let intervals: Vec<[f64; 2]> = intervals.collect();
        if !hypothesis.is_threshold() {
            first += hypothesis.values.len();
        }
        if selected.names(hypothesis) {
            out.push(finding(machine, selected, index, &intervals));
        }
    }
    out
}

/// 95 % interval of the parameter `name` of the effect `index`, the `place`th of all.
fn interval(
    machine: &Machine,
    selected: &Selected,
    [index, place]: [usize; 2],
    (name, value): (&str, f64),
) -> [f64; 2] {
    let hypothesis = &selected.fit.hypotheses[index];
    let has_derivative = !hypothesis.is_threshold() && name != STATIC;
    let known = selected.known.as_ref().filter(|_| has_derivative);
    let deviation = known.and_then(|known| half_width(known, hypothesis.is_local(), place));
    let Some([width, variance]) = deviation else {
        let wide = [value * 0.5, value * 1.5];
        return machine.profile(&selected.fit, index, name).unwrap_or(wide);
    };
    let nothing = hypothesis.nothing(&machine.model, name);
    let grain = INTEGRATORS * (value - nothing).abs();
    let half = width * (variance + grain * grain).sqrt();
    [value - half, value + half]
}

/// Half width of a 95 % interval in deviations, and the variance of a number, where that is known. The one block of
/// what is local has no spread.
fn half_width(known: &Known, is_local: bool, place: usize) -> Option<[f64; 2]> {
    let [width, variance] = if is_local {
        [NORMAL, known.model[(place, place)]]
    } else {
        let blocks = known.blocks;
        let width = Criterion { tried: 1, blocks }.half_width();
        [width, known.covariance[(place, place)]]
    };
    variance.is_finite().then_some([width, variance])
}

fn finding(
    machine: &Machine,
    selected: &Selected,
    index: usize,
    intervals: &[[f64; 2]],
) -> Finding {
    let fit = &selected.fit;
    let own = &fit.hypotheses[index];
    let numbers = own.values.iter().zip(intervals);
    let numbers = numbers.map(|((name, value), ci95)| Number {
        name,
        nominal: own.nominal(&machine.model, name),
        estimate: *value,
        ci95: *ci95,
    });
    let named = Named {
        robot: &machine.tracks[0].robot,
        effect: own.info.id,
        numbers: numbers.collect(),
        word: own.text,
        intervals_s: at_work(machine, fit, own),
        condition: Some(condition(&machine.model, own)),
        runs: None,
        confused: &selected.alike[index],
        evidence: evidence(selected.gains[index], selected.tried),
        known: own.replaces.is_some(),
    };
    named.finding(machine.tracks[0].span_s())
}

/// When an effect is at work (s): while a wheel slides, during a push, always.
fn at_work(machine: &Machine, fit: &Filtered, hypothesis: &Hypothesis) -> Vec<[f64; 2]> {
    match hypothesis.info.acts {
        When::Sliding => sliding(machine, fit, None),
        When::Inside => sliding(machine, fit, Some(hypothesis)),
        When::Once => {
            let t_s = hypothesis.value("t_s").unwrap_or(0.0);
            vec![[t_s, t_s + PUSH_S]]
        }
        _ => vec![machine.tracks[0].span_s()],
    }
}

/// When a wheel slides in the first run, or only on a patch.
fn sliding(machine: &Machine, fit: &Filtered, patch: Option<&Hypothesis>) -> Vec<[f64; 2]> {
    let value = |name: &str| patch.and_then(|p| p.value(name)).unwrap_or(0.0);
    let (px, py, radius) = (value("x_m"), value("y_m"), value("radius_m"));
    let Some(robot) = machine.robot(&fit.hypotheses) else {
        return Vec::new();
    };
    let mut intervals: Vec<[f64; 2]> = Vec::new();
    let mut last = machine.runs[0].begin_s;
    machine.watched(fit, &fit.hypotheses, |run, t_s, state, _| {
        if run > 0 {
            return;
        }
        let [right, left, across] = robot.slip_m_s(state);
        let slides = state.slides();
        let contacts = machine.contacts(state.pose());
        let on_patch = |[x, y]: [f64; 2]| patch.is_none() || (x - px).hypot(y - py) < radius;
        let fast = |i: usize, along: f64| {
            slides[i] && along.hypot(across) > SLIDING_M_S && on_patch(contacts[i])
        };
        if fast(0, right) || fast(1, left) {
            match intervals.last_mut() {
                Some(own) if last - own[1] < GAP_S => own[1] = t_s,
                _ => intervals.push([last, t_s]),
            }
        }
        last = t_s;
    });
    intervals
}

/// What always pushes and follows nothing that was looked at.
pub(crate) fn process_noise(machine: &Machine, fit: &Filtered) -> Vec<ProcessNoise> {
    let noise = &fit.noise;
    let floor = machine.floor(noise.of_wheels);
    let [third, fourth] = if noise.of_wheels {
        [("wheel_torque", "N m"); 2]
    } else {
        [("speed", "m/s"), ("turn_rate", "rad/s")]
    };
    let names = [
        ("surge_force", "N"),
        ("yaw_moment", "N m"),
        third,
        fourth,
        ("lateral_speed", "m/s"),
    ];
    let each = machine.disturbances(noise.of_wheels);
    let above = each.filter(|i| noise.size[*i] > ABOVE_FLOOR * floor[*i]);
    above
        .map(|i| ProcessNoise {
            robot: machine.tracks[0].robot.clone(),
            acts_on: names[i].0,
            size: noise.size[i],
            unit: names[i].1,
            correlation_time_s: noise.time_s[i.min(2)],
        })
        .collect()
}

fn warning(machine: &Machine, id: &str, statement: String, remedy: &str) -> Warning {
    Warning {
        recording: machine.tracks[0].recording.clone(),
        robot: Some(machine.tracks[0].robot.clone()),
        id: id.to_owned(),
        statement,
        remedy: remedy.to_owned(),
    }
}

/// A warning where something pushed more than once.
pub(crate) fn gusts(machine: &Machine) -> Option<Warning> {
    let gusts = machine.runs.iter().flat_map(|run| &run.disturbances_s);
    let mut times: Vec<f64> = gusts.map(|[from, to]| f64::midpoint(*from, *to)).collect();
    times.sort_by(f64::total_cmp);
    let words: Vec<String> = times.iter().map(|t_s| format!("{t_s:.2}")).collect();
    let statement = format!(
        "something pushes for a moment now and then, near {} s; these moments count for nothing",
        words.join(", ")
    );
    let remedy = "record again where nobody and nothing pushes the robot";
    (!times.is_empty()).then(|| warning(machine, "gusts", statement, remedy))
}

/// A warning where forces without pattern were found.
pub(crate) fn wandering(machine: &Machine, noise: &[ProcessNoise]) -> Option<Warning> {
    let parts = noise.iter().map(|own| {
        let name = own.acts_on.replace('_', " ");
        let [size, ..] = in_digits(own.size, [0.0, own.size]);
        let (unit, time_s) = (own.unit, own.correlation_time_s);
        format!("{name} {size} {unit} for about {time_s:.2} s")
    });
    let parts: Vec<String> = parts.collect();
    let statement = format!(
        "random disturbance forces that no candidate explains (standard deviations: {})",
        parts.join(", ")
    );
    let remedy = "effects that do not stand out from it were not accepted; a smoother floor or a \
                  longer recording would show more";
    (!noise.is_empty()).then(|| warning(machine, "wandering_forces", statement, remedy))
}

/// What the catalogue does not hold, as a finding and as unexplained.
pub(crate) fn outside(
    machine: &Machine,
    selected: &Selected,
    unknown: &Unknown,
) -> (Finding, Unexplained) {
    let what = Unexplained {
        robot: machine.tracks[0].robot.clone(),
        channel: unknown.channel.to_owned(),
        driver: unknown.driver.to_owned(),
        intervals_s: unknown.intervals_s.clone(),
        shape: with_parts(selected, &unknown.shape),
    };
    let evidence = evidence(unknown.gain / 2.0, selected.tried);
    (finding::outside(&what, evidence), what)
}

/// The shape of a force outside of the catalogue with the effects that are part of it.
fn with_parts(selected: &Selected, shape: &str) -> String {
    let parts = selected.fit.hypotheses.iter();
    let parts = parts.filter(|own| !selected.names(own));
    let words: Vec<String> = parts.map(|own| own.info.id.replace('_', " ")).collect();
    if words.is_empty() {
        shape.to_owned()
    } else {
        format!("{shape}, beside a part like {}", words.join(" and "))
    }
}

/// How sure a gain (nats) is, over everything that was tried.
fn evidence(gain: f64, tried: usize) -> Evidence {
    Evidence {
        log_likelihood_gain: gain,
        p_value: (tried as f64 * (-gain).exp()).min(1.0),
    }
}
