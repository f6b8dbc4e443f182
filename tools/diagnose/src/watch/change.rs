//! A hypothesis that holds, as a finding.

use slipstream_bus::RobotModel;

use super::hypotheses::Hypothesis;
use super::robot::Found;
use super::statistic::Tested;
use crate::answer::Finding;
use crate::estimate::term::Link;
use crate::explain::claim::{Claim, Value};
use crate::explain::finding::finding;
use crate::explain::naming::TYRES;

/// Half width of a 95 % interval in deviations.
const HALF_WIDTH: f64 = 1.96;

/// What a hypothesis is as a finding about `robot`, whose model has everything that the baseline showed; `alike` are effects
/// that fit as well, `tried` how many there are.
pub(super) fn as_finding(
    own: &Hypothesis,
    found: &Found,
    (robot, model): (&str, &RobotModel),
    tried: usize,
    span_s: [f64; 2],
) -> Finding {
    let tested = &found.tested;
    let values = own.values.iter().map(|value| {
        let (change, _) = tested.value(&value.weights);
        let [low, high] = interval(&found.same, &value.weights);
        Value {
            half: [change - low, high - change],
            ..Value::new(value.name, value.link, change, 0.0)
        }
    });
    let mut claim = Claim {
        effect: own.effect,
        values: values.collect(),
        word: None,
        runs: None,
        toggles: Vec::new(),
        gain: tested.gain(),
        p_value: (tried as f64 * (-tested.factor).exp()).min(1.0),
        confused: own.confused.clone(),
        law: None,
    };
    claim.confused.extend(&found.alike);
    slipped(&mut claim);
    spun(&mut claim);
    mirrored(&mut claim, own.mirror, model);
    claim.confused.sort_unstable();
    claim.confused.dedup();
    let effect = claim.effect;
    claim.confused.retain(|other| *other != effect);
    finding(&claim, robot, &[], model, span_s).0
}

/// The 95 % interval of a number, whichever of these onsets it is.
fn interval(same: &[Tested], weights: &[f64]) -> [f64; 2] {
    let each = same.iter().map(|own| {
        let (change, deviation) = own.value(weights);
        [
            change - HALF_WIDTH * deviation,
            change + HALF_WIDTH * deviation,
        ]
    });
    let both = each.reduce(|[a, b], [c, d]| [a.min(c), b.max(d)]);
    both.unwrap_or_default()
}

/// Wheels that both carry less far, by more than tyres change, slip.
fn slipped(claim: &mut Claim) {
    let [right, left] = claim.values.as_slice() else {
        return;
    };
    let alike = right.change == left.change && claim.effect == "wheel_radius";
    if !alike || right.change.abs() < TYRES {
        return;
    }
    let ratio = Value {
        name: "ratio",
        link: Link::LogLoss,
        ..right.clone()
    };
    claim.effect = "slip_ratio";
    claim.values = vec![ratio];
    claim.confused.push("wheel_radius");
}

/// A motor that is so much stronger than it was (logarithm of its gain) rather turns a wheel without a grip.
const STRONGER: f64 = 0.2;

/// Wheels that turn far more easily than before may spin.
fn spun(claim: &mut Claim) {
    let mut all = claim.values.iter();
    if claim.effect == "motor_gain" && all.any(|own| own.change > STRONGER) {
        claim.confused.push("friction_patch");
    }
}

/// A stream that is stamped before it was measured is the less likely of two.
fn mirrored(claim: &mut Claim, mirror: Option<(&'static str, f64)>, model: &RobotModel) {
    let (Some((effect, sign)), [value]) = (mirror, claim.values.as_slice()) else {
        return;
    };
    let total = claim.nominal(model, value.name).unwrap_or(0.0) + value.change;
    if total < 0.0 {
        let was = std::mem::replace(&mut claim.effect, effect);
        claim.values[0].change *= sign;
        claim.confused.push(was);
    }
}
