//! The robot of the paper without and with an effect, under the same commands.

use slipstream_bus::RobotModel;
use slipstream_sim::{Robot, State, Stream};

use crate::examples::{Example, Shown};
use crate::picture::{Line, svg};

/// Step of the plant (s).
const STEP_S: f64 = 1e-3;
/// Points of a line.
const POINTS: f64 = 240.0;

/// The model that an example simulates, with its effect or without.
pub(crate) fn model(example: &Example, has_effect: bool) -> RobotModel {
    let mut model = if example.slips {
        RobotModel::paper_with_slip()
    } else {
        RobotModel::default()
    };
    if has_effect {
        model.effects.push(example.spec());
    }
    model
}

/// The lines without and with the effect.
pub(crate) fn lines(example: &Example) -> [Line; 2] {
    [false, true].map(|has_effect| line(example, &model(example, has_effect)))
}

pub(crate) fn picture(example: &Example) -> String {
    let is_floor = matches!(
        example.shows,
        Shown::Path | Shown::SeenPath | Shown::OdometryPath
    );
    let legend = ["without", example.effect.as_str()];
    svg(&lines(example), example.shows.axes(), legend, is_floor)
}

fn line(example: &Example, model: &RobotModel) -> Line {
    let robot = Robot::new(model).unwrap_or_else(|error| panic!("{}: {error}", example.effect));
    let mut state = robot.start([0.0; 3]);
    let mut believed = [0.0; 3];
    let mut points = Vec::new();
    let course = example.course();
    let every = (course.length_s / POINTS / STEP_S).ceil() as u32;
    for step in 0..=(course.length_s / STEP_S).round() as u32 {
        let t_s = f64::from(step) * STEP_S;
        if step % every == 0 {
            points.push(point(example.shows, &robot, &state, believed, t_s));
        }
        let command = course.command(t_s);
        robot.step(&mut state, t_s, STEP_S, &command);
        let [v, w] = robot.odometry(robot.measured_speed(&state));
        let [x, y, heading] = believed;
        let (sin, cos) = (heading + 0.5 * w * STEP_S).sin_cos();
        believed = [
            x + v * cos * STEP_S,
            y + v * sin * STEP_S,
            heading + w * STEP_S,
        ];
    }
    points
}

/// What is shown at one instant.
fn point(shown: Shown, robot: &Robot, state: &State, believed: [f64; 3], t_s: f64) -> (f64, f64) {
    let pose = state.pose();
    let seen = robot.measured_pose(pose);
    match shown {
        Shown::Speed => (t_s, state.velocity()[0]),
        Shown::TurnRate => (t_s, state.velocity()[2]),
        Shown::EncoderSpeed => (t_s, robot.measured_speed(state)[0]),
        Shown::Path => (pose[0], pose[1]),
        Shown::SeenPath => (seen[0], seen[1]),
        Shown::OdometryPath => (believed[0], believed[1]),
        Shown::SeenX => (robot.stamp_s(Stream::Pose, t_s), seen[0]),
        Shown::EncoderAngle => (
            robot.stamp_s(Stream::Wheels, t_s),
            robot.measured_angle(state)[0],
        ),
        Shown::Gyro => (
            robot.stamp_s(Stream::Imu, t_s),
            robot.measured_inertial(state)[2],
        ),
        Shown::MessageX => (t_s + robot.link_delay_s(), pose[0]),
    }
}
