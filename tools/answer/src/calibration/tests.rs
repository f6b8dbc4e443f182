use slipstream_recording::robot_file;

use super::*;
use crate::fixture::finding;

/// An effect, and its parameters: name, estimate, half width of the interval.
type Found<'a> = (&'a str, &'a [(&'a str, f64, f64)]);

/// A model with these effects as they were found, and its calibration.
fn calibrated(found: &[Found<'_>]) -> String {
    let mut model = RobotModel::default();
    let mut answer = Answer::default();
    for (effect, parameters) in found {
        let values: Vec<(&str, f64)> = parameters.iter().map(|own| (own.0, own.1)).collect();
        model = model.with(effect, &values);
        answer.findings.push(finding(effect, parameters));
    }
    let robot = slipstream_recording::recording::Robot {
        name: "r1".to_owned(),
        ..Default::default()
    };
    let recording = Recording {
        robots: vec![robot],
        ..Recording::default()
    };
    calibration(&answer, "r1", &model, &[recording])
}

const HEAD: &str = "\
# Calibration of robot r1, written by slipstream diagnose (m, rad).
# Put these into the parameters of your controller, which also name its wheels:
#   ros2 run controller_manager spawner diff_drive_controller --param-file FILE.yaml
diff_drive_controller:
  ros__parameters:
    wheel_separation: 0.21
    wheel_radius: 0.0365
";

#[test]
fn nothing_found_is_the_nominal_model() {
    let rest = "    wheel_separation_multiplier: 1.0\n    left_wheel_radius_multiplier: 1.0\n    \
                right_wheel_radius_multiplier: 1.0\n";
    assert_eq!(calibrated(&[]), format!("{HEAD}{rest}"));
}

#[test]
fn what_was_found_is_a_multiplier_or_a_comment() {
    let text = calibrated(&[
        (
            "wheel_radius",
            &[("right_scale", 0.9571, 0.002), ("left_scale", 1.0, 0.002)],
        ),
        ("track_width", &[("scale", 1.45, 0.02)]),
        ("slip_ratio", &[("ratio", 0.07, 0.002)]),
        (
            "encoder_scale",
            &[
                ("right_scale", 1.0001, 0.0003),
                ("left_scale", 0.98, 0.0003),
            ],
        ),
        (
            "pose_offset",
            &[
                ("x_m", 0.12, 0.02),
                ("y_m", 0.03, 0.02),
                ("yaw_rad", 0.05, 0.002),
            ],
        ),
    ]);
    let rest = "    \
    wheel_separation_multiplier: 1.450
    left_wheel_radius_multiplier: 1.0000
    right_wheel_radius_multiplier: 0.9571

# On this floor the wheels slip by a ratio of 0.0700, which the radii do not contain.

# The encoders count wrong, for which the controller has no parameter.
# In the hardware interface, set counts per turn to 1818.9 (left) and 1856.2 (right).

# The camera, laser or marker of the poses, from base_link in the middle of the axle (m, rad).
# What is not listed was not estimated or is zero within its interval: keep it.
#   x: 0.175
#   y: 0.030
#   yaw: 0.0500
# Where the poses were transformed to base_link already: put this in front of it.
#   ros2 run tf2_ros static_transform_publisher --x 0.175 --y 0.030 --z Z --yaw 0.0500 --pitch PITCH --roll ROLL \
--frame-id base_link --child-frame-id camera
";
    assert_eq!(text, format!("{HEAD}{rest}"));
}

#[test]
fn a_number_is_a_float_to_yaml() {
    assert_eq!(float("1"), "1.0");
    assert_eq!(float("0.21"), "0.21");
}

/// The model that a controller with this calibration has.
fn read_back(text: &str) -> RobotModel {
    let described = robot_file::parse(text, std::path::Path::new("calibration.yaml"));
    described.unwrap().model().unwrap()
}

#[test]
fn the_calibration_of_nothing_is_read_as_the_nominal_lengths() {
    let (nominal, read) = (RobotModel::default(), read_back(&calibrated(&[])));
    assert_eq!(read.robot.wheel_radius_m, nominal.robot.wheel_radius_m);
    assert_eq!(read.robot.half_track_m, nominal.robot.half_track_m);
    assert_eq!(read.effects, []);
}

/// Radii of right and left wheel, and half of the track (m), all effects counted.
fn true_lengths(model: &RobotModel) -> [f64; 3] {
    let scale = |effect, name| model.number(effect, name).unwrap_or(1.0);
    let radius = |name| model.robot.wheel_radius_m * scale("wheel_radius", name);
    let half_track = model.robot.half_track_m * scale("track_width", "scale");
    [radius("right_scale"), radius("left_scale"), half_track]
}

#[test]
fn a_calibration_is_read_as_the_wheels_and_the_track_that_were_found() {
    let alike: [(&str, f64, f64); 2] = [("right_scale", 0.957, 2e-3), ("left_scale", 0.957, 2e-3)];
    let apart = [("right_scale", 0.9571, 2e-3), ("left_scale", 1.0313, 2e-3)];
    for scales in [alike, apart] {
        let track = ("track_width", &[("scale", 1.45, 0.02)][..]);
        let read = read_back(&calibrated(&[("wheel_radius", &scales), track]));
        let mut found = RobotModel::default().with("track_width", &[("scale", 1.45)]);
        found = found.with(
            "wheel_radius",
            &scales.map(|(name, value, _)| (name, value)),
        );
        for (own, expected) in true_lengths(&read).into_iter().zip(true_lengths(&found)) {
            assert!(
                (own / expected - 1.0).abs() < 1e-14,
                "{own} where {expected} is right"
            );
        }
        // What both wheels have in common is a length of the model, not an effect.
        assert_eq!(read.number("track_width", "scale"), None);
        assert_eq!(read.effects.len(), usize::from(scales == apart));
    }
}
