//! What the filter found, as findings.

use slipstream_sim::effects::When;

use super::condition::condition;
use super::selection::Known;
use super::selection::Selected;
use super::unknown::Unknown;
use crate::answer::in_digits;
use crate::answer::statement::statement;
use crate::answer::{
    Evidence, Finding, ParameterEstimate, Place, ProcessNoise, Unexplained, Warning,
};
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

/// The findings of one machine.
pub(crate) fn findings(machine: &Machine, selected: &Selected) -> Vec<Finding> {
    let fit = &selected.fit;
    let known = selected.known.as_ref();
    let mut first = 0;
    let mut out = Vec::new();
    for (index, hypothesis) in fit.hypotheses.iter().enumerate() {
        let intervals: Vec<[f64; 2]> = hypothesis
            .values
            .iter()
            .enumerate()
            .map(|(i, (name, value))| {
                interval(machine, fit, known, (index, first + i), (name, *value))
            })
            .collect();
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
    fit: &Filtered,
    known: Option<&Known>,
    (index, place): (usize, usize),
    (name, value): (&str, f64),
) -> [f64; 2] {
    let hypothesis = &fit.hypotheses[index];
    let profiled = || {
        let wide = [value * 0.5, value * 1.5];
        machine.profile(fit, index, name).unwrap_or(wide)
    };
    if hypothesis.is_threshold() || name == STATIC {
        return profiled();
    }
    let Some(known) = known else {
        return profiled();
    };
    let local = hypothesis.is_local();
    let variance = if local {
        known.model[(place, place)]
    } else {
        known.covariance[(place, place)]
    };
    if !variance.is_finite() {
        return profiled();
    }
    let width = if local {
        // its one block has no spread
        NORMAL
    } else {
        let blocks = known.blocks;
        Criterion { tried: 1, blocks }.half_width()
    };
    let nothing = hypothesis.nothing(&machine.model, name);
    let grain = INTEGRATORS * (value - nothing).abs();
    let half = width * (variance + grain * grain).sqrt();
    [value - half, value + half]
}

fn finding(
    machine: &Machine,
    selected: &Selected,
    index: usize,
    intervals: &[[f64; 2]],
) -> Finding {
    let fit = &selected.fit;
    let hypothesis = &fit.hypotheses[index];
    let info = hypothesis.info;
    let unit = |name: &str| info.parameter(name).map_or("1", |p| p.unit).to_owned();
    let mut parameters: Vec<ParameterEstimate> = hypothesis
        .values
        .iter()
        .zip(intervals)
        .map(|((name, value), ci95)| ParameterEstimate {
            name: (*name).to_owned(),
            unit: unit(name),
            nominal: hypothesis.nominal(&machine.model, name),
            nominal_ci95: None,
            estimate: Some(*value),
            ci95: Some(*ci95),
            text: None,
        })
        .collect();
    if let Some((name, word)) = hypothesis.text {
        parameters.push(ParameterEstimate::word(name, word));
    }

    let mut finding = Finding {
        statement: String::new(),
        robot: machine.tracks[0].robot.clone(),
        effect: info.id.to_owned(),
        parameters,
        place: Place {
            channel: info.channels[0].name().to_owned(),
            intervals_s: at_work(machine, fit, hypothesis),
            condition: condition(&machine.model, hypothesis),
        },
        runs: None,
        confused_with: selected.alike[index]
            .iter()
            .map(|id| (*id).to_owned())
            .collect(),
        evidence: evidence(selected.gains[index], selected.tried),
        shape: None,
        driver: None,
        actions: Vec::new(),
    };
    let span_s = machine.tracks[0].span_s();
    let known = hypothesis.replaces.is_some();
    finding.statement = statement(&finding, info.summary, span_s, known);
    finding
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
    let floor = machine.floor(fit.noise.of_wheels);
    let names = if fit.noise.of_wheels {
        [
            ("surge_force", "N"),
            ("yaw_moment", "N m"),
            ("wheel_torque", "N m"),
            ("wheel_torque", "N m"),
            ("lateral_speed", "m/s"),
        ]
    } else {
        [
            ("surge_force", "N"),
            ("yaw_moment", "N m"),
            ("speed", "m/s"),
            ("turn_rate", "rad/s"),
            ("lateral_speed", "m/s"),
        ]
    };
    let has_pose = machine.has_pose();
    let each = (0..5).filter(|i| !(fit.noise.of_wheels && *i == 3));
    let each = each.filter(|i| has_pose || *i < 2 || fit.noise.of_wheels && *i == 2);
    let above = each.filter(|i| fit.noise.size[*i] > ABOVE_FLOOR * floor[*i]);
    above
        .map(|i| ProcessNoise {
            robot: machine.tracks[0].robot.clone(),
            acts_on: names[i].0,
            size: fit.noise.size[i],
            unit: names[i].1,
            correlation_time_s: fit.noise.time_s[i.min(2)],
        })
        .collect()
}

/// A warning where something pushed more than once.
pub(crate) fn gusts(machine: &Machine) -> Option<Warning> {
    let mut times: Vec<f64> = machine
        .runs
        .iter()
        .flat_map(|run| {
            run.gusts_s
                .iter()
                .map(|[from, to]| f64::midpoint(*from, *to))
        })
        .collect();
    times.sort_by(f64::total_cmp);
    if times.is_empty() {
        return None;
    }
    let words: Vec<String> = times.iter().map(|t_s| format!("{t_s:.2}")).collect();
    Some(Warning {
        recording: machine.tracks[0].recording.clone(),
        robot: Some(machine.tracks[0].robot.clone()),
        id: "gusts".to_owned(),
        statement: format!(
            "something pushes for a moment now and then, near {} s; these moments count for nothing",
            words.join(", ")
        ),
        remedy: "record again where nobody and nothing pushes the robot".to_owned(),
    })
}

/// A warning where forces without pattern were found.
pub(crate) fn wandering(machine: &Machine, noise: &[ProcessNoise]) -> Option<Warning> {
    if noise.is_empty() {
        return None;
    }
    let parts: Vec<String> = noise
        .iter()
        .map(|own| {
            let name = own.acts_on.replace('_', " ");
            let (size, unit, time_s) = (own.size, own.unit, own.correlation_time_s);
            let [size, ..] = in_digits(size, [0.0, size]);
            format!("{name} {size} {unit} for about {time_s:.2} s")
        })
        .collect();
    Some(Warning {
        recording: machine.tracks[0].recording.clone(),
        robot: Some(machine.tracks[0].robot.clone()),
        id: "wandering_forces".to_owned(),
        statement: format!(
            "something pushes that follows no variable looked at (standard deviations: {})",
            parts.join(", ")
        ),
        remedy: "effects that do not stand out from it were not accepted; a smoother floor or a \
                 longer recording would show more"
            .to_owned(),
    })
}

/// Multiple of the floor from which on a size is said.
const ABOVE_FLOOR: f64 = 3.0;

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
    let condition = format!("follows {}", unknown.driver);
    (
        what.finding(condition, evidence(unknown.gain / 2.0, selected.tried)),
        what,
    )
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
