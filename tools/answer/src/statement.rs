//! A finding as one sentence: who, where, when, what, how much, and what it could be instead.

use slipstream_sim::effects::Role;

use crate::miscount::cause;
use crate::{Finding, ParameterEstimate};
use crate::{in_digits, manoeuvre};

/// Intervals that are spelled out; more are counted.
const SPELLED: usize = 3;

/// The sentence of a finding. `summary` says what the effect is, `span_s` when the recording begins
/// and ends, `known` that the model has the effect with other numbers.
pub fn statement(finding: &Finding, summary: &str, span_s: [f64; 2], known: bool) -> String {
    let channel = finding.place.channel.replace('_', " ");
    let robot = &finding.robot;
    let when = when(finding, span_s);
    let how = if known {
        "which the model has with other numbers"
    } else {
        "which the model leaves out"
    };
    let numbers: Vec<String> = finding.parameters.iter().filter_map(number).collect();
    let cause = cause(finding).map_or_else(String::new, |cause| format!(": {cause}"));
    let numbers = numbers.join(", ") + &cause;
    let told = told(finding);
    format!("Robot {robot}, {channel}, {when}: {summary}, {how}; {numbers}. {told}.")
}

/// The sentence of a change since `before`.
pub fn changed(finding: &Finding, before: &str) -> String {
    let robot = &finding.robot;
    if let Some(shape) = &finding.shape {
        return format!(
            "Robot {robot}: since {before}, something outside of the catalogue changed: {shape}."
        );
    }
    let what = change(finding).unwrap_or_else(|| {
        let info = slipstream_sim::effects::find(&finding.effect);
        info.map_or(finding.effect.as_str(), |own| own.summary)
            .to_owned()
    });
    let numbers: Vec<String> = finding.parameters.iter().filter_map(was_and_is).collect();
    let of_runs = match &finding.runs {
        Some(runs) => format!(" ({})", runs.join(", ")),
        None => String::new(),
    };
    let (numbers, told) = (numbers.join(", "), told(finding));
    format!("Robot {robot}{of_runs}, compared with {before}: {what}; {numbers}. {told}.")
}

/// What changed, as a person would say it, without robot and numbers: "the reference sits 10.0 cm further
/// forward". `None` where no parameter is clearly another, or nobody has words for it.
pub fn change(finding: &Finding) -> Option<String> {
    let parts = finding.parameters.iter();
    let parts: Vec<String> = parts
        .filter_map(|parameter| phrase(&finding.effect, parameter))
        .collect();
    let link = finding.place.condition.strip_prefix("link ");
    let from = link.map_or_else(String::new, |link| format!(" on the link {link}"));
    (!parts.is_empty()).then(|| parts.join(", ") + &from)
}

/// A change as a person would say it; none where it lies within its interval.
fn phrase(effect: &str, parameter: &ParameterEstimate) -> Option<String> {
    let ([low, high], estimate) = (parameter.ci95?, parameter.estimate?);
    let name = parameter.name.as_str();
    let info = slipstream_sim::effects::find(effect).and_then(|own| own.parameter(name));
    let is_factor = info.is_some_and(|own| own.role == Role::Factor);
    let was = parameter
        .nominal
        .unwrap_or(if is_factor { 1.0 } else { 0.0 });
    if (low..=high).contains(&was) {
        return None;
    }
    let change = if is_factor {
        estimate / was - 1.0
    } else {
        estimate - was
    };
    let either = |up: &'static str, down: &'static str| if change > 0.0 { up } else { down };
    let percent = || format!("{:.1} %", 100.0 * change.abs());
    let cm = || format!("{:.1} cm", 100.0 * change.abs());
    let ms = || format!("{:.0} ms", 1000.0 * change.abs());
    let side = || {
        if name.starts_with("right") {
            "right"
        } else {
            "left"
        }
    };
    Some(match (effect, name) {
        ("pose_offset", "x_m") => {
            let way = either("further forward", "further back");
            format!("the reference sits {} {way}", cm())
        }
        ("pose_offset", "y_m") => {
            let way = either("further left", "further right");
            format!("the reference sits {} {way}", cm())
        }
        ("pose_offset", "yaw_rad") => format!(
            "the reference is turned by {:.2}° to the {}",
            change.abs().to_degrees(),
            either("left", "right")
        ),
        ("pose_latency", _) => format!("poses are stamped {} {}", ms(), either("later", "earlier")),
        ("imu_latency", _) => format!(
            "the gyro is stamped {} {}",
            ms(),
            either("later", "earlier")
        ),
        ("wheels_latency", _) => {
            format!("wheels are stamped {} {}", ms(), either("later", "earlier"))
        }
        ("link_delay", _) => format!("messages come {} {}", ms(), either("later", "earlier")),
        ("actuator_delay", _) => format!("commands act {} {}", ms(), either("later", "earlier")),
        ("actuator_lag", _) => {
            format!(
                "the drive follows {} {}",
                ms(),
                either("more slowly", "faster")
            )
        }
        ("wheel_radius", _) => {
            let size = either("larger", "smaller");
            format!("the {} wheel is {} {size}", side(), percent())
        }
        ("encoder_scale", _) => {
            let size = either("more", "less");
            format!("the {} encoder counts {} {size}", side(), percent())
        }
        ("motor_gain", _) => {
            let size = either("more", "less");
            format!("the {} drive gives {} {size}", side(), percent())
        }
        ("track_width", _) => format!("the track is {} {}", percent(), either("wider", "narrower")),
        ("slip_ratio", "ratio") => {
            let size = either("more", "less");
            format!("the wheels lose {} {size} of their way", percent())
        }
        _ => return None,
    })
}

/// What a parameter was and is.
fn was_and_is(parameter: &ParameterEstimate) -> Option<String> {
    let now = number(parameter)?;
    let (Some(nominal), Some(ci95)) = (parameter.nominal, parameter.ci95) else {
        return Some(now);
    };
    let [was, ..] = in_digits(nominal, ci95);
    Some(format!("{now}, was {was}"))
}

/// When it is at work: intervals where they are not the whole recording, and the condition.
fn when(finding: &Finding, [begin, end]: [f64; 2]) -> String {
    let place = &finding.place;
    let intervals = &place.intervals_s;
    let sum: f64 = intervals.iter().map(|[a, b]| b - a).sum();
    let whole = sum > 0.98 * (end - begin);
    let spelled = |[a, b]: &[f64; 2]| format!("{a:.2} to {b:.2} s");
    let condition = match place.condition.as_str() {
        "always" => "all the time",
        condition => condition,
    };
    match intervals.as_slice() {
        [] => condition.to_owned(),
        _ if whole => condition.to_owned(),
        few if few.len() <= SPELLED => {
            let few: Vec<String> = few.iter().map(spelled).collect();
            format!("{} ({condition})", few.join(", "))
        }
        [[first, _], .., [_, last]] => {
            let count = intervals.len();
            format!("{count} times between {first:.2} and {last:.2} s ({condition})")
        }
        [one] => spelled(one),
    }
}

fn number(parameter: &ParameterEstimate) -> Option<String> {
    let name = bare(&parameter.name);
    if let Some(word) = &parameter.text {
        return Some(format!("{name} {word}"));
    }
    let unit = match parameter.unit.as_str() {
        "1" => String::new(),
        unit => format!(" {unit}"),
    };
    let [estimate, low, high] = in_digits(parameter.estimate?, parameter.ci95?);
    Some(format!(
        "{name} {estimate}{unit} (95 % between {low} and {high})"
    ))
}

/// A parameter's name without its unit, which stands behind the number.
fn bare(name: &str) -> String {
    let units = [
        "_n_s", "_m_s", "_rad_s", "_per_s", "_nm", "_rad", "_kg", "_m", "_s",
    ];
    let without = units.iter().find_map(|unit| name.strip_suffix(unit));
    without.unwrap_or(name).replace('_', " ")
}

/// What it could be instead, and what would tell.
fn told(finding: &Finding) -> String {
    if finding.confused_with.is_empty() {
        return "Nothing else in the catalogue fits as well".to_owned();
    }
    let others = finding.confused_with.join(" or ");
    let mut all: Vec<&str> = vec![&finding.effect];
    all.extend(finding.confused_with.iter().map(String::as_str));
    let which = manoeuvre(&all);
    let between = between(finding).map_or_else(String::new, |words| format!(": {words}"));
    format!("This recording cannot tell it from {others}{between}; what would: {which}")
}

/// The two sides of a delay between two streams, where either may be the late one.
fn between(finding: &Finding) -> Option<String> {
    let stream = |effect: &str| match effect {
        "pose_latency" => Some("pose"),
        "wheels_latency" => Some("wheels or odometry"),
        "imu_latency" => Some("gyro"),
        _ => None,
    };
    let [other] = finding.confused_with.as_slice() else {
        return None;
    };
    let [late, early] = [stream(&finding.effect)?, stream(other)?];
    let latency = finding.parameters.first()?;
    let estimate = latency.estimate?;
    let [size, ..] = in_digits(estimate.abs(), latency.ci95?);
    Some(format!(
        "{late} {size} s behind, or the stamps of {early} {size} s ahead"
    ))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Evidence, Place};

    fn slip(intervals_s: Vec<[f64; 2]>, confused_with: Vec<String>) -> Finding {
        Finding {
            robot: "r2".to_owned(),
            effect: "wheel_slip".to_owned(),
            statement: String::new(),
            parameters: vec![ParameterEstimate {
                name: "friction_kinetic".to_owned(),
                unit: "1".to_owned(),
                nominal: None,
                nominal_ci95: None,
                estimate: Some(0.236),
                ci95: Some([0.231, 0.241]),
                text: None,
            }],
            place: Place {
                channel: "longitudinal".to_owned(),
                intervals_s,
                condition: "drive torque above 0.092 N m".to_owned(),
            },
            runs: None,
            confused_with,
            evidence: Evidence {
                log_likelihood_gain: 812.0,
                p_value: 1e-40,
            },
            shape: None,
            driver: None,
            actions: Vec::new(),
        }
    }

    #[test]
    fn a_sentence_says_where_when_and_how_much() {
        let finding = slip(vec![[5.02, 5.63]], Vec::new());
        assert_eq!(
            statement(&finding, "the wheels slip", [0.0, 30.0], false),
            "Robot r2, longitudinal, 5.02 to 5.63 s (drive torque above 0.092 N m): the wheels slip, \
             which the model leaves out; friction kinetic 0.2360 (95 % between 0.2310 and 0.2410). \
             Nothing else in the catalogue fits as well."
        );
    }

    #[test]
    fn look_alikes_come_with_an_experiment() {
        let finding = slip(vec![[0.0, 30.0]], vec!["viscous_drag".to_owned()]);
        let words = statement(&finding, "the wheels slip", [0.0, 30.0], true);
        assert!(
            words.contains("longitudinal, drive torque above"),
            "{words}"
        );
        assert!(
            words.contains("cannot tell it from viscous_drag; what would: "),
            "{words}"
        );
        assert!(words.contains("coast-down"), "{words}");
    }

    #[test]
    fn units_leave_names() {
        for (name, without) in [
            ("latency_s", "latency"),
            ("speed_rad_s", "speed"),
            ("scale", "scale"),
        ] {
            assert_eq!(bare(name), without);
        }
    }
}
