//! What a finding says in physics, in one clause.

use slipstream_answer::Finding;
use slipstream_bus::RobotModel;

use crate::effect_words::{Shown, driver, shown};
use crate::parts::{fixed, short, with_unit};

/// Parameters of a finding in words, and of all findings that are told together with it.
struct SaidFindings<'a> {
    finding: &'a Finding,
    all: &'a [&'a Finding],
    model: Option<&'a RobotModel>,
}

impl SaidFindings<'_> {
    fn of(&self, finding: &Finding, name: &str) -> Option<Shown> {
        let own = finding.parameters.iter().find(|p| p.name == name)?;
        shown(&finding.effect, own, self.model)
    }

    fn get(&self, name: &str) -> Option<Shown> {
        self.of(self.finding, name)
    }

    /// The parameter of every finding that is told.
    fn each(&self, name: &str) -> Vec<Option<Shown>> {
        let all = self.all.iter();
        all.map(|finding| self.of(finding, name)).collect()
    }

    /// The size of a parameter with its unit; from the least to the largest one where several findings are told.
    fn text(&self, name: &str) -> String {
        let Some(own) = self.get(name) else {
            return "an unknown amount".to_owned();
        };
        let each = self.each(name);
        let sizes = each.iter().flatten().map(|own| own.is.abs());
        with_unit(
            &range(sizes, |size| fixed(size, own.digits.min(2))),
            own.unit,
        )
    }

    /// The size of a threshold, whatever it is a threshold of.
    fn size(&self) -> String {
        let own = self.finding.parameters.first();
        own.map_or_else(String::new, |own| self.text(&own.name))
    }

    fn word(&self) -> &str {
        let mut words = self
            .finding
            .parameters
            .iter()
            .filter_map(|p| p.text.as_deref());
        words.next().unwrap_or_default()
    }

    /// How late a clock is: early where that is negative.
    fn late(&self) -> String {
        let is_early = self.get("latency_s").is_some_and(|own| own.is < 0.0);
        let side = if is_early { "early" } else { "late" };
        format!("{} {side}", self.text("latency_s"))
    }
}

/// What findings of one effect say in physics, without a full stop, beginning small.
pub fn headline(all: &[&Finding], model: Option<&RobotModel>) -> String {
    let [finding, ..] = all else {
        return String::new();
    };
    let told = SaidFindings {
        finding,
        all,
        model,
    };
    let said = of_force(&told)
        .or_else(|| of_drive(&told))
        .or_else(|| of_sensor(&told));
    said.unwrap_or_else(|| outside(finding))
}

/// Whether two findings say the same with other sizes, so that one clause tells both.
pub(super) fn are_alike(pair: [&Finding; 2], model: Option<&RobotModel>) -> bool {
    let [one, other] = pair.map(|own| {
        let mut words = headline(&[own], model);
        words.retain(|c| !c.is_ascii_digit() && c != '.');
        // messages name their robot
        let to = own.effect.starts_with("link_").then_some(&own.robot);
        (&own.effect, &own.driver, to, words)
    });
    one == other
}

/// From the least to the largest size, where they differ as they are written.
fn range(sizes: impl Iterator<Item = f64>, written: impl Fn(f64) -> String) -> String {
    let ends = sizes.fold([f64::INFINITY, 0.0], |[low, high], own| {
        [own.min(low), own.max(high)]
    });
    let [low, high] = ends.map(written);
    if low == high {
        high
    } else {
        format!("{low} to {high}")
    }
}

/// What acts between robot and floor.
fn of_force(told: &SaidFindings<'_>) -> Option<String> {
    let text = |name: &str| told.text(name);
    Some(match told.finding.effect.as_str() {
        "wheel_slip" => format!("the wheels slip: friction is {}", text("friction_kinetic")),
        "friction_patch" => format!(
            "a patch of the floor at ({}, {}) has a friction of {}",
            text("x_m"),
            text("y_m"),
            text("friction")
        ),
        "rolling_resistance" => format!("rolling costs {} of the weight", text("coefficient")),
        "viscous_drag" => format!("a drag of {} acts on the body", text("coefficient")),
        "quadratic_drag" => format!("a drag of {} times speed squared acts", text("coefficient")),
        "caster_drag" => format!("the caster drags with a friction of {}", text("friction")),
        "yaw_scrub" => format!("turning meets a moment of {}", text("moment_nm")),
        "load_transfer" => format!(
            "acceleration shifts load: the centre of mass is {} high",
            text("com_height_m")
        ),
        "slip_ratio" => format!(
            "the wheels lose {} of their way to the floor",
            text("ratio")
        ),
        "track_width" => track(told.all),
        "payload" => format!("the robot carries {}", text("mass_kg")),
        "floor_slope" => format!("the floor falls by {}", text("grade")),
        "push" => format!(
            "something pushed the robot with {} at {}",
            text("impulse_n_s"),
            text("t_s")
        ),
        "force_law" | "motion_law" => "a measured law has other values".to_owned(),
        _ => return None,
    })
}

/// What acts between command and wheel.
fn of_drive(told: &SaidFindings<'_>) -> Option<String> {
    let text = |name: &str| told.text(name);
    Some(match told.finding.effect.as_str() {
        "axle_friction" => format!("each axle has a friction of {}", text("torque_nm")),
        "torque_speed_droop" => {
            format!("torque falls by {} with wheel speed", text("coefficient"))
        }
        "actuator_lag" => format!(
            "the drive lags with a time constant of {}",
            text("time_constant_s")
        ),
        "actuator_delay" => format!("commands act {} late", text("delay_s")),
        "motor_gain" => format!(
            "the right wheel gets {} and the left {} of what is commanded",
            text("right"),
            text("left")
        ),
        "supply_sag" => format!("the drive loses {}", text("rate_per_s")),
        "command_dead_band" => format!("commands below {} do nothing", told.size()),
        "command_saturation" => format!("commands above {} are cut", told.size()),
        "command_dead_zone" => format!("every command loses {}", told.size()),
        "backlash" => format!("the gears have a play of {}", text("gap_rad")),
        _ => return None,
    })
}

/// What belongs to geometry, sensors, clocks and messages.
fn of_sensor(told: &SaidFindings<'_>) -> Option<String> {
    let finding = told.finding;
    Some(match finding.effect.as_str() {
        "wheel_radius" => radii("the wheels are", "wheel", ["smaller", "larger"], told.all),
        "encoder_scale" => radii(
            "the encoders count",
            "encoder",
            ["too little", "too much"],
            told.all,
        ),
        "pose_offset" => mounting(told),
        "pose_latency" => format!("the poses are stamped {}", told.late()),
        "wheels_latency" => format!("the wheels are stamped {}", told.late()),
        "imu_latency" => format!("the IMU is stamped {}", told.late()),
        "clock_drift" => {
            let gains = told.get("rate").is_none_or(|own| own.is > 0.0);
            let verb = if gains { "gains" } else { "loses" };
            format!(
                "the clock of the {} {verb} {}",
                stream(told.word()),
                told.text("rate")
            )
        }
        "link_delay" => format!(
            "messages to {} are {} older than stamped",
            finding.robot,
            told.text("delay_s")
        ),
        _ => return None,
    })
}

/// What the catalogue does not hold, by what it acts on and what it follows.
fn outside(finding: &Finding) -> String {
    let shape = finding.shape.as_deref().unwrap_or_default();
    let what = [
        "turn rate beside that of the track",
        "forward speed",
        "force along the body",
        "moment about the vertical",
    ];
    let what = what
        .into_iter()
        .find(|own| shape.contains(own))
        .unwrap_or("force");
    match finding.driver.as_deref() {
        Some(id) => format!(
            "a {what} that follows {} is missing from the model",
            driver(id).0
        ),
        None => format!("a {what} is missing from the model"),
    }
}

fn stream(word: &str) -> &str {
    match word {
        "pose" => "poses",
        "imu" => "IMU",
        other => other,
    }
}

/// Two factors of the wheels in words. All findings say the same with other sizes.
fn radii(both: &str, each: &str, [less, more]: [&str; 2], all: &[&Finding]) -> String {
    let factor = |finding: &Finding, name: &str| {
        let own = finding.parameters.iter().find(|p| p.name == name);
        own.and_then(|own| Some((own.estimate? / own.nominal.unwrap_or(1.0), own.ci95?)))
    };
    let pairs = || {
        let pair = |own: &&Finding| ["right_scale", "left_scale"].map(|name| factor(own, name));
        all.iter().map(pair)
    };
    let change = |factors: Vec<f64>| {
        let side = if factors.first().is_some_and(|own| *own < 1.0) {
            less
        } else {
            more
        };
        let sizes = factors.iter().map(|own| 100.0 * (own - 1.0).abs());
        format!("{}\u{202f}% {side}", range(sizes, short))
    };
    let wheel = |side: usize| change(pairs().filter_map(|own| Some(own[side]?.0)).collect());
    match pairs().next() {
        Some([Some((right, own)), Some((left, other))])
            if own[0] > left || left > own[1] || other[0] > right || right > other[1] =>
        {
            format!("the right {each} is {}, the left {}", wheel(0), wheel(1))
                .replace("encoder is", "encoder counts")
        }
        Some([Some(_), Some(_)]) => {
            let middles = pairs().filter_map(|[a, b]| Some(f64::midpoint(a?.0, b?.0)));
            format!("{both} {}", change(middles.collect()))
        }
        Some([Some(_), None]) => format!("{both} {}", wheel(0)),
        Some([None, Some(_)]) => format!("{both} {}", wheel(1)),
        _ => format!("{both} other than the model has them"),
    }
}

fn track(all: &[&Finding]) -> String {
    let factors = all.iter().filter_map(|finding| {
        let own = finding.parameters.first()?;
        Some(own.estimate? / own.nominal.unwrap_or(1.0))
    });
    let factors: Vec<f64> = factors.collect();
    let Some(first) = factors.first() else {
        return String::new();
    };
    let side = if *first < 1.0 { "narrower" } else { "wider" };
    let changes = factors.iter().map(|factor| 100.0 * (factor - 1.0).abs());
    format!(
        "it turns as if its track were {}\u{202f}% {side}",
        range(changes, short)
    )
}

/// Where the pose sensor sits. All findings say the same with other sizes.
fn mounting(told: &SaidFindings<'_>) -> String {
    let [x, y, yaw] = ["x_m", "y_m", "yaw_rad"].map(|name| told.each(name));
    let part = |own: &Option<Shown>| {
        own.as_ref()
            .map_or(0.0, |own| own.is - own.was.unwrap_or(0.0))
    };
    let is_known = |own: &&Shown| own.interval[0] > 0.0 || own.interval[1] < 0.0;
    let has_place = x.iter().chain(&y).any(Option::is_some);
    let place = has_place.then(|| {
        let off_cm = x.iter().zip(&y).map(|(x, y)| part(x).hypot(part(y)));
        format!(
            "the pose sensor sits {} cm from where the model has it",
            range(off_cm, short)
        )
    });
    let turned = yaw[0].as_ref().filter(is_known).map(|first| {
        let sizes = yaw.iter().flatten().map(|own| own.is.abs());
        range(sizes, |size| fixed(size, first.digits.min(2)))
    });
    match (place, turned) {
        (Some(place), Some(turned)) => format!("{place} and is turned by {turned}°"),
        (Some(place), None) => place,
        (None, Some(turned)) => format!("the pose sensor is turned by {turned}°"),
        (None, None) => "the pose sensor sits elsewhere".to_owned(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::effect_words::name;
    use slipstream_answer::ParameterEstimate;
    use slipstream_sim::effects::CATALOGUE;

    /// A finding with numbers for every parameter of an effect.
    fn finding(effect: &str) -> Finding {
        let info = slipstream_sim::effects::find(effect).unwrap();
        let numbers = info.parameters.iter().filter(|own| own.unit != "text");
        Finding {
            robot: "r1".to_owned(),
            effect: effect.to_owned(),
            statement: String::new(),
            parameters: numbers
                .map(|own| ParameterEstimate {
                    name: own.name.to_owned(),
                    unit: own.unit.to_owned(),
                    nominal: None,
                    nominal_ci95: None,
                    estimate: Some(0.9),
                    ci95: Some([0.88, 0.92]),
                    text: None,
                })
                .collect(),
            place: slipstream_answer::Place {
                channel: "longitudinal".to_owned(),
                intervals_s: Vec::new(),
                condition: "always".to_owned(),
            },
            runs: None,
            confused_with: Vec::new(),
            evidence: slipstream_answer::Evidence {
                log_likelihood_gain: 10.0,
                p_value: 1e-6,
            },
            shape: None,
            driver: None,
            actions: Vec::new(),
        }
    }

    #[test]
    fn every_effect_of_the_catalogue_has_words() {
        for info in CATALOGUE {
            let own = finding(info.id);
            assert_ne!(name(info.id), "Outside of the catalogue", "{}", info.id);
            let said = headline(&[&own], None);
            assert!(
                !said.is_empty() && !said.contains("unknown"),
                "{}: {said}",
                info.id
            );
            if !info.is_table() {
                for parameter in own.parameters.iter().filter(|p| p.unit != "text") {
                    let own = shown(info.id, parameter, None).unwrap();
                    assert!(!own.label.is_empty(), "{}: {}", info.id, parameter.name);
                }
            }
        }
    }

    #[test]
    fn wheels_that_do_not_differ_are_told_together() {
        let own = finding("wheel_radius");
        assert_eq!(
            headline(&[&own], None),
            "the wheels are 10.0\u{202f}% smaller"
        );
        let mut apart = own.clone();
        apart.parameters[0].estimate = Some(1.05);
        apart.parameters[0].ci95 = Some([1.04, 1.06]);
        assert_eq!(
            headline(&[&apart], None),
            "the right wheel is 5.0\u{202f}% larger, the left 10.0\u{202f}% smaller"
        );
    }

    #[test]
    fn only_what_says_the_same_with_another_size_is_told_together() {
        let of = |robot: &str, right: f64, left: f64| {
            let mut own = finding("wheel_radius");
            robot.clone_into(&mut own.robot);
            for (parameter, value) in own.parameters.iter_mut().zip([right, left]) {
                parameter.estimate = Some(value);
                parameter.ci95 = Some([value - 0.02, value + 0.02]);
            }
            own
        };
        let [a, b] = [of("a", 1.046, 1.052), of("b", 1.36, 1.38)];
        assert!(are_alike([&a, &b], None));
        assert_eq!(
            headline(&[&a, &b], None),
            "the wheels are 4.9 to 37.0\u{202f}% larger"
        );
        for other in [of("b", 0.9, 0.91), of("b", 1.2, 1.05)] {
            assert!(!are_alike([&a, &other], None));
        }
        let unknown = |shape: &str| Finding {
            effect: "unknown".to_owned(),
            shape: Some(shape.to_owned()),
            driver: Some("w".to_owned()),
            ..a.clone()
        };
        let speed = unknown("forward speed that depends on the turn rate: -0.1 m/s at +0.4 rad/s");
        let turn = unknown(
            "turn rate beside that of the track that depends on the turn rate: +0.3 rad/s at +0.3 rad/s",
        );
        assert!(!are_alike([&speed, &turn], None));
        assert!(headline(&[&turn], None).starts_with("a turn rate beside that of the track that"));
        let mut late = finding("link_delay");
        late.robot = "r2".to_owned();
        assert!(!are_alike([&late, &finding("link_delay")], None));
    }

    #[test]
    fn findings_that_are_told_together_keep_their_sizes() {
        let own = finding("track_width");
        let mut other = own.clone();
        other.parameters[0].estimate = Some(0.7);
        assert_eq!(
            headline(&[&own, &other], None),
            "it turns as if its track were 10.0 to 30.0\u{202f}% narrower"
        );
        let own = finding("slip_ratio");
        let mut other = own.clone();
        other.parameters[0].estimate = Some(0.5);
        assert_eq!(
            headline(&[&own, &other], None),
            "the wheels lose 50 to 90\u{202f}% of their way to the floor"
        );
    }
}
