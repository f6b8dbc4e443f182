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
    fn get(&self, name: &str) -> Option<Shown> {
        let own = self.finding.parameters.iter().find(|p| p.name == name)?;
        shown(&self.finding.effect, own, self.model)
    }

    /// The size of a parameter with its unit; from the least to the largest one where several findings are told.
    fn text(&self, name: &str) -> String {
        let Some(own) = self.get(name) else {
            return "an unknown amount".to_owned();
        };
        let sizes = self.all.iter().filter_map(|finding| {
            let own = finding.parameters.iter().find(|p| p.name == name)?;
            Some(shown(&finding.effect, own, self.model)?.is.abs())
        });
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
        "wheel_radius" => radii("the wheels are", "wheel", "smaller", "larger", finding),
        "encoder_scale" => radii(
            "the encoders count",
            "encoder",
            "too little",
            "too much",
            finding,
        ),
        "pose_offset" => {
            let yaw = told.get("yaw_rad");
            mounting(
                told.get("x_m").as_ref(),
                told.get("y_m").as_ref(),
                yaw.as_ref(),
            )
        }
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

/// Two factors of the wheels in words.
fn radii(both: &str, each: &str, less: &str, more: &str, finding: &Finding) -> String {
    let factor = |name: &str| {
        let own = finding.parameters.iter().find(|p| p.name == name);
        own.and_then(|own| Some((own.estimate? / own.nominal.unwrap_or(1.0), own.ci95?)))
    };
    let change = |factor: f64| {
        let side = if factor < 1.0 { less } else { more };
        format!("{}\u{202f}% {side}", short(100.0 * (factor - 1.0).abs()))
    };
    match (factor("right_scale"), factor("left_scale")) {
        (Some((right, own)), Some((left, other))) => {
            let apart = own[0] > left || left > own[1] || other[0] > right || right > other[1];
            if apart {
                format!(
                    "the right {each} is {}, the left {}",
                    change(right),
                    change(left)
                )
                .replace("encoder is", "encoder counts")
            } else {
                format!("{both} {}", change(f64::midpoint(right, left)))
            }
        }
        (Some((one, _)), None) | (None, Some((one, _))) => format!("{both} {}", change(one)),
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

fn mounting(x: Option<&Shown>, y: Option<&Shown>, yaw: Option<&Shown>) -> String {
    let part = |own: Option<&Shown>| own.map_or(0.0, |own| own.is - own.was.unwrap_or(0.0));
    let off_cm = part(x).hypot(part(y));
    let is_known = |own: &&Shown| own.interval[0] > 0.0 || own.interval[1] < 0.0;
    let turned = yaw
        .filter(is_known)
        .map(|own| fixed(own.is.abs(), own.digits.min(2)));
    let place = (x.is_some() || y.is_some()).then(|| {
        format!(
            "the pose sensor sits {} cm from where the model has it",
            short(off_cm)
        )
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
