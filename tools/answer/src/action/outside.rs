//! What no lasting effect of the catalogue is: a push, a law, and what is unknown.

use slipstream_bus::{EffectSpec, Parameter};

use super::quantity::Quantity;
use crate::setup::Setup;
use crate::{Finding, manoeuvre};

/// How long a push lasts (s), and what is left out around it (s).
const PUSH_S: f64 = 0.06;
const AROUND_S: f64 = 0.05;

pub(super) fn push(finding: &Finding) -> Option<Vec<String>> {
    let [from_s, to_s] = Quantity::of(finding, "t_s")?.interval;
    let round = |t_s: f64, up: bool| {
        let hundredths = 100.0 * t_s;
        let whole = if up {
            hundredths.ceil()
        } else {
            hundredths.floor()
        };
        whole / 100.0
    };
    let from_s = round(from_s - AROUND_S, false).max(0.0);
    let to_s = round(to_s + PUSH_S + AROUND_S, true);
    Some(vec![format!(
        "leave this moment out: --exclude-time {from_s:.2}:{to_s:.2}"
    )])
}

/// Of an effect whose numbers do not fit into a line.
pub(super) fn table(finding: &Finding) -> Vec<String> {
    vec![format!(
        "use the model that --improved writes: it has {}",
        finding.effect
    )]
}

pub(super) fn unknown(finding: &Finding, setup: &Setup<'_>) -> Vec<String> {
    let driver = finding.driver.as_deref().unwrap_or_default();
    let mut actions = Vec::new();
    if setup
        .model
        .effects
        .iter()
        .any(|own| is_law_over(own, driver))
    {
        actions.push(format!("use the law over {driver} that --improved writes"));
    }
    let words = what_follows(driver);
    actions.push(format!("look on the robot and the floor for {words}"));
    let which = manoeuvre(&["unknown"]);
    actions.push(format!("record this to see more of it: {which}"));
    actions
}

fn is_law_over(spec: &EffectSpec, driver: &str) -> bool {
    let is_law = matches!(spec.effect.as_str(), "force_law" | "motion_law");
    let named = |(name, value): &(String, Parameter)| {
        name == "driver" && matches!(value, Parameter::Text(text) if text == driver)
    };
    is_law && spec.parameters.iter().any(named)
}

/// What to look for, by what it follows.
fn what_follows(driver: &str) -> &'static str {
    match driver {
        "t" => "what changes with time: battery, temperature, load",
        "v" => "what depends on the speed",
        "w" => "what depends on the turn rate",
        "wheel_angle" => {
            "what comes back with each turn of a wheel: a flat spot, a bent axle, a gear"
        }
        "heading" => "what depends on the heading: a slope, a cable, the nap of a carpet",
        "x" | "y" | "position" => "what depends on the place: seams, slopes, soft spots",
        "torque" => "what depends on the torque: gears, motors, a loose wheel",
        "time_at_rest" => "what depends on how long it stood: sticking bearings, flattened tyres",
        _ => "what acts there",
    }
}
