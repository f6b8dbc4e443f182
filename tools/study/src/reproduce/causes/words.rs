//! Causes in words.

use super::candidate::{Candidate, Kind, Scope};
use super::explanation::{Cause, FinalPosition, in_words};

/// Names of the experiments.
pub(super) const EXPERIMENTS: [&str; 2] = ["without_limit", "with_limit"];

/// The robot that a cause acts on, if it is one.
pub(super) fn robot(scope: Scope) -> Option<String> {
    match scope {
        Scope::Robot(own) => Some(format!("r{}", own + 1)),
        _ => None,
    }
}

/// The experiment that a cause acts on, if it is one.
pub(super) fn experiment(scope: Scope) -> Option<String> {
    match scope {
        Scope::Experiment(own) => Some(EXPERIMENTS[own].to_owned()),
        _ => None,
    }
}

/// A cause of a size as a sentence without its full stop.
pub(super) fn of(candidate: Candidate, size: f64) -> String {
    let who = match candidate.scope {
        Scope::Robot(own) => format!("r{}", own + 1),
        _ => "all robots".to_owned(),
    };
    let than = |more: &'static str, less: &'static str| if size >= 0.0 { more } else { less };
    let percent = format!("{:.1} %", 100.0 * size.abs());
    let degrees = format!("{:.1}°", size.abs().to_degrees());
    let cm = format!("{:.1} cm", 100.0 * size.abs());
    let seconds = format!("{:.2} s", size.abs());
    let said = match candidate.kind {
        Kind::WheelRadius => format!(
            "the wheels of {who} are {percent} {}",
            than("larger", "smaller")
        ),
        Kind::RightWheelRadius => format!(
            "the right wheel of {who} is {percent} {} than the left one",
            than("larger", "smaller")
        ),
        Kind::MotorGain => format!(
            "the {} motor of {who} is {percent} too strong and the other one as much too weak",
            than("right", "left")
        ),
        Kind::LoadPlace => format!(
            "0.3 kg of the load of {who} lie {cm} {} of the middle",
            than("left", "right")
        ),
        Kind::FloorFriction => format!(
            "under the {} wheel of {who} the friction is {:.3} lower",
            than("left", "right"),
            size.abs()
        ),
        Kind::DecelerationStart => format!(
            "the deceleration begins {seconds} {}",
            than("later", "earlier")
        ),
        Kind::DecelerationTime => format!(
            "the deceleration lasts {seconds} {}",
            than("longer", "less long")
        ),
        Kind::StartHeading => format!(
            "{who} starts turned by {degrees} to the {}",
            than("left", "right")
        ),
        Kind::FrameYaw => format!(
            "the tape's frame is turned by {degrees} to the {}",
            than("right", "left")
        ),
        Kind::FrameX => format!(
            "the tape's frame lies {cm} too far {}",
            than("back", "ahead")
        ),
        Kind::FrameY => format!(
            "the tape's frame lies {cm} too far to the {}",
            than("right", "left")
        ),
    };
    match candidate.scope {
        Scope::Experiment(own) => format!("{} {said}", in_words(EXPERIMENTS[own])),
        _ => said,
    }
}

/// The answer.
pub(super) fn sentence(causes: &[Cause], numbers: &[FinalPosition]) -> String {
    let within = |number: fn(&FinalPosition) -> f64| {
        numbers
            .iter()
            .filter(|own| own.is_within(number(own)))
            .count()
    };
    let (before, after) = (within(|own| own.before_m), within(|own| own.after_m));
    let count = match causes.len() {
        0 => "No cause explains".to_owned(),
        1 => "One cause explains".to_owned(),
        count => format!("{count} causes explain"),
    };
    format!(
        "{count} {after} of the {} final positions to within the tape's 1 cm; as assumed {before} agree.",
        numbers.len()
    )
}

/// The numbers that the causes do not explain, by figure, the worst first.
pub(super) fn remains(numbers: &[FinalPosition]) -> String {
    let mut groups: Vec<(String, f64, Vec<&str>)> = Vec::new();
    for own in numbers.iter().filter(|own| !own.is_within(own.after_m)) {
        let which = in_words(&own.experiment);
        let by = match own.by == "tape" {
            true => "by the tape",
            false => "by the encoders",
        };
        let name = format!("{} {by} {which}", own.axis);
        let off_m = (own.after_m - own.printed_m).abs();
        match groups.iter_mut().find(|group| group.0 == name) {
            Some((_, largest_m, robots)) => {
                *largest_m = largest_m.max(off_m);
                robots.push(&own.robot);
            }
            None => groups.push((name, off_m, vec![&own.robot])),
        }
    }
    groups.sort_by(|a, b| b.1.total_cmp(&a.1));
    let words = groups.into_iter().map(|(name, largest_m, robots)| {
        let most = if robots.len() > 1 { "up to " } else { "" };
        format!(
            "{name} ({}: {most}{:.1} cm)",
            robots.join(", "),
            100.0 * largest_m
        )
    });
    words.collect::<Vec<String>>().join("; ")
}
