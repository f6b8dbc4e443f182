//! Something that the catalogue does not hold: on what it acts, which variable it follows, and what
//! it looks like.

use crate::bench::{Bench, Node};
use crate::drivers::Sampled;
use crate::force::{self, Missing, PULSE_S};

/// Δ(−2 ln L) that a missing force has to bring, and for each of its numbers more.
const PAY: [f64; 2] = [30.0, 2.0];
/// Share of the largest force from which on it counts as at work.
const AT_WORK: f64 = 0.5;

/// What was found beyond the catalogue.
pub(crate) struct Unknown {
    pub(crate) missing: Missing,
    /// When the force is large (s).
    pub(crate) intervals_s: Vec<[f64; 2]>,
    /// What it looks like, for a person.
    pub(crate) shape: String,
    /// ln L that it brings, to first order.
    pub(crate) gain: f64,
}

/// The missing force beside `node`, if there is one that pays.
pub(crate) fn beside(bench: &Bench, node: &Node) -> Option<Unknown> {
    let answers = force::answers(bench, node)?;
    let all = force::missing(bench, node, &answers);
    let missing = all.into_iter().next()?;
    let gain = missing.misfit.gain_over(&node.fit.misfit);
    (gain > PAY[0] + PAY[1] * missing.weights.len() as f64).then(|| describe(bench, node, missing))
}

fn describe(bench: &Bench, node: &Node, missing: Missing) -> Unknown {
    let gain = (node.fit.misfit.deviance() - missing.deviance) / 2.0;
    let mut moments: Vec<(f64, f64, f64)> = Vec::new();
    for window in &bench.windows {
        let track = &bench.tracks[window.run];
        let steps = ((window.to_s - window.from_s) / PULSE_S) as usize;
        for k in 0..steps {
            let at_s = window.from_s + PULSE_S * (k as f64 + 0.5);
            let sampled = Sampled::new(bench, track, at_s);
            let force = missing
                .driver
                .force(&missing.weights, &sampled, missing.part);
            let still = missing.against && sampled.v.abs() < 2e-3 && sampled.w.abs() < 2e-3;
            let z = missing.driver.variable(&sampled, missing.part);
            moments.push((
                at_s,
                missing.driver.shown(z),
                if still { 0.0 } else { force },
            ));
        }
    }
    let middle = median(moments.iter().map(|m| m.2));
    let deviates = |force: f64| force - if missing.against { 0.0 } else { middle };
    let most = moments
        .iter()
        .map(|m| deviates(m.2))
        .max_by(|a, b| a.abs().total_cmp(&b.abs()))
        .unwrap_or(0.0);
    let large = |force: f64| deviates(force) * most.signum() > AT_WORK * most.abs();
    let mut intervals_s: Vec<[f64; 2]> = Vec::new();
    for (at_s, ..) in moments.iter().filter(|m| large(m.2)) {
        let [from, to] = [at_s - PULSE_S / 2.0, at_s + PULSE_S / 2.0];
        match intervals_s.last_mut() {
            Some(last) if from - last[1] < 1.5 * PULSE_S => last[1] = to,
            _ => intervals_s.push([from, to]),
        }
    }
    let shape = shape(&missing, &moments, most, &large);
    Unknown {
        missing,
        intervals_s,
        shape,
        gain,
    }
}

fn median(values: impl Iterator<Item = f64>) -> f64 {
    let mut values: Vec<f64> = values.collect();
    values.sort_by(f64::total_cmp);
    values.get(values.len() / 2).copied().unwrap_or(0.0)
}

fn shape(
    missing: &Missing,
    moments: &[(f64, f64, f64)],
    most: f64,
    large: &dyn Fn(f64) -> bool,
) -> String {
    let unit = if missing.part == force::Part::Longitudinal {
        "N"
    } else {
        "N m"
    };
    let what = match missing.part {
        force::Part::Longitudinal => "force along the body",
        force::Part::Yaw => "moment about the vertical",
        force::Part::WheelRight => "torque at the right wheel",
        force::Part::WheelLeft => "torque at the left wheel",
    };
    let way = if missing.against {
        " against the motion"
    } else {
        ""
    };
    let driver = &missing.driver;
    let at: Vec<f64> = moments
        .iter()
        .filter(|m| large(m.2))
        .map(|m| m.1)
        .filter(|z| z.is_finite())
        .collect();
    let (low, high) = at
        .iter()
        .fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), z| {
            (l.min(*z), h.max(*z))
        });
    let place = if low.is_finite() {
        format!(
            "; most of it where {} lies between {low:.2} and {high:.2} {}",
            driver.name, driver.unit
        )
    } else {
        String::new()
    };
    format!(
        "a {what}{way} that follows {}, up to {:.3} {unit}{place}",
        driver.name,
        most.abs()
    )
}
