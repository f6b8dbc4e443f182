//! The calibration of a robot as parameters of ros2_control's diff_drive_controller.

use std::fmt::Write as _;

use slipstream_bus::RobotModel;
use slipstream_recording::Recording;

use super::digits::in_digits;
use super::setup::Setup;
use super::{Answer, Finding, ParameterEstimate};

/// Digits behind the point of a number whose interval is not known.
const DIGITS: usize = 6;

/// A YAML file with the calibration of `robot`: parameters of diff_drive_controller, and as comments what has no
/// parameter there: the transform of the pose sensor, counts per turn, slip.
///
/// `improved` is the model that the diagnosis hands out: nominal lengths, and the effects in force today.
/// Where the diagnosis of `recordings` found nothing, the file has the values of that model.
pub fn calibration(
    answer: &Answer,
    robot: &str,
    improved: &RobotModel,
    recordings: &[Recording],
) -> String {
    let own = Calibration {
        findings: answer
            .findings
            .iter()
            .filter(|own| own.robot == robot)
            .collect(),
        model: improved,
    };
    let mut text = own.parameters(robot);
    let setup = Setup::of(robot, improved, recordings);
    let ahead_m = setup.as_ref().map_or(0.0, |own| own.declared_ahead_m);
    let notes = [
        own.differs_between_runs(),
        own.slip(),
        own.encoders(setup.and_then(|own| own.counts_per_turn)),
        own.transform(ahead_m),
    ];
    for note in notes.into_iter().flatten() {
        text.push('\n');
        text.push_str(&note);
    }
    text
}

struct Calibration<'a> {
    findings: Vec<&'a Finding>,
    model: &'a RobotModel,
}

impl Calibration<'_> {
    fn parameters(&self, robot: &str) -> String {
        let body = &self.model.robot;
        let multiplier = |effect: &str, name: &str| {
            let value = self.model.number(effect, name).unwrap_or(1.0);
            float(&self.write(effect, name, value))
        };
        let rows = [
            (
                "wheel_separation",
                float(&(2.0 * body.half_track_m).to_string()),
            ),
            ("wheel_radius", float(&body.wheel_radius_m.to_string())),
            (
                "wheel_separation_multiplier",
                multiplier("track_width", "scale"),
            ),
            (
                "left_wheel_radius_multiplier",
                multiplier("wheel_radius", "left_scale"),
            ),
            (
                "right_wheel_radius_multiplier",
                multiplier("wheel_radius", "right_scale"),
            ),
        ];
        let mut text = format!(
            "# Calibration of robot {robot}, written by slipstream diagnose (m, rad).\n\
             # Put these into the parameters of your controller, which also name its wheels:\n\
             #   ros2 run controller_manager spawner diff_drive_controller --param-file FILE.yaml\n\
             diff_drive_controller:\n  ros__parameters:\n"
        );
        for (name, value) in rows {
            let _ = writeln!(text, "    {name}: {value}");
        }
        text
    }

    /// A number of the model with the digits that the finding of its effect lets count.
    fn write(&self, effect: &str, name: &str, value: f64) -> String {
        match self.interval(effect, name) {
            Some(interval) => in_digits(value, interval)[0].clone(),
            None if value == 1.0 => "1.0".to_owned(),
            None => format!("{value:.DIGITS$}"),
        }
    }

    /// What the findings of an effect say about one of its parameters.
    fn parameters_of(&self, effect: &str, name: &str) -> impl Iterator<Item = &ParameterEstimate> {
        let of_effect = self.findings.iter().filter(move |own| own.effect == effect);
        let parameters = of_effect.flat_map(|own| &own.parameters);
        parameters.filter(move |own| own.name == name)
    }

    /// Where the value of a parameter lies, as far as its first finding says.
    fn interval(&self, effect: &str, name: &str) -> Option<[f64; 2]> {
        self.parameters_of(effect, name).next()?.ci95
    }

    /// Of what is not the same in all recordings.
    fn differs_between_runs(&self) -> Option<String> {
        let differs = |own: &&&Finding| own.runs.is_some() && own.effect == "track_width";
        self.findings.iter().find(differs)?;
        let note =
            "# wheel_separation_multiplier differs between the recordings: this is the mean.\n";
        Some(note.to_owned())
    }

    fn slip(&self) -> Option<String> {
        let ratio = self.model.number("slip_ratio", "ratio")?;
        Some(format!(
            "# On this floor the wheels slip by a ratio of {}, which the radii do not contain.\n",
            self.write("slip_ratio", "ratio", ratio)
        ))
    }

    fn encoders(&self, counts_per_turn: Option<f64>) -> Option<String> {
        let side = |name: &str| {
            let scale = self.model.number("encoder_scale", name)?;
            let of = |scale: f64| scale * counts_per_turn.unwrap_or(1.0);
            Some(match self.interval("encoder_scale", name) {
                Some(ends) => in_digits(of(scale), ends.map(of))[0].clone(),
                None => format!("{:.4}", of(scale)),
            })
        };
        let (left, right) = (side("left_scale")?, side("right_scale")?);
        let what = match counts_per_turn {
            Some(_) => "set counts per turn to",
            None => "divide the measured wheel angles by",
        };
        Some(format!(
            "# The encoders count wrong, for which the controller has no parameter.\n\
             # In the hardware interface, {what} {left} (left) and {right} (right).\n"
        ))
    }

    /// What was estimated of the pose sensor's place. `ahead_m` is the way from the middle of the axle forward to the
    /// declared point (m).
    fn transform(&self, ahead_m: f64) -> Option<String> {
        let effect = "pose_offset";
        let number = |name: &str, option: &str, ahead_m: f64| {
            let value = self.model.number(effect, name)?;
            let is_zero = self.is_zero(effect, name);
            (!is_zero).then(|| (option.to_owned(), self.write(effect, name, value + ahead_m)))
        };
        let known = [
            number("x_m", "x", ahead_m),
            number("y_m", "y", 0.0),
            number("yaw_rad", "yaw", 0.0),
        ];
        let known: Vec<(String, String)> = known.into_iter().flatten().collect();
        if known.is_empty() {
            return None;
        }
        let lines: String = known
            .iter()
            .map(|(name, value)| format!("#   {name}: {value}\n"))
            .collect();
        let option = |name: &str| {
            let own = known.iter().find(|(own, _)| own == name);
            own.map_or(name.to_uppercase(), |(_, value)| value.clone())
        };
        let [x, y, yaw] = ["x", "y", "yaw"].map(option);
        Some(format!(
            "# The camera, laser or marker of the poses, from base_link in the middle of the axle (m, rad).\n\
             # What is not listed was not estimated or is zero within its interval: keep it.\n{lines}\
             # Where the poses were transformed to base_link already: put this in front of it.\n\
             #   ros2 run tf2_ros static_transform_publisher --x {x} --y {y} --z Z --yaw {yaw} --pitch PITCH --roll ROLL \
             --frame-id base_link --child-frame-id camera\n"
        ))
    }

    /// Whether a finding says that a number is zero within its interval, and was not known before.
    fn is_zero(&self, effect: &str, name: &str) -> bool {
        let mut parameters = self.parameters_of(effect, name);
        let own = parameters.find(|own| own.nominal.is_none_or(|was| was == 0.0));
        own.and_then(|own| own.ci95)
            .is_some_and(|[low, high]| low <= 0.0 && 0.0 <= high)
    }
}

/// A number as YAML reads it as a float: with a point.
fn float(text: &str) -> String {
    if text.contains('.') {
        text.to_owned()
    } else {
        format!("{text}.0")
    }
}

#[cfg(test)]
mod tests;
