//! `slipstream robot-in-a-box`: our plant behind the topics of a real robot.

use std::io::Write;
use std::path::{Path, PathBuf};
use std::sync::atomic::Ordering;
use std::time::{Duration, Instant};

use clap::Args;
use slipstream_bus::experiment::Drive;
use slipstream_bus::{Camera, Imu, InputError};
use slipstream_recording::robot_file;
use slipstream_robots::boxed::{self, BoxError, BoxOptions, BoxReport};
use slipstream_robots::lab::{Lab, LabRobot};

use crate::exit::{Error, Exit};
use crate::host_options::require_network;
use crate::print::{eprint_line, print_line};
use crate::{interrupt, output_file};

/// Time to end after the first Ctrl-C.
const GRACE: Duration = Duration::from_secs(2);

/// Play a robot of robots.toml: a simulated robot behind the topics of a real one
///
/// It takes commands and sends wheels and poses as the real robot would, on the wall clock, until Ctrl-C. What the effects
/// of its model do is concealed: a run with --real cannot tell it from a real robot.
///
/// Example: slipstream robot-in-a-box robots.toml r2 --robot small-wheel.toml
#[derive(Debug, Args)]
pub(crate) struct Arguments {
    /// File with the robots, as for run --real
    lab: PathBuf,
    /// The robot to play, such as r2
    name: String,
    /// Its true model, with effects [default: the nominal one of robots.toml]
    #[arg(long, value_name = "FILE")]
    robot: Option<PathBuf>,
    /// Where it stands: x (m), y (m), yaw (rad) [default: the start of robots.toml]
    #[arg(
        long,
        value_name = "X,Y,YAW",
        value_delimiter = ',',
        num_args = 3,
        allow_hyphen_values = true
    )]
    pose: Option<Vec<f64>>,
    /// Rate of its wheels or odometry (1/s)
    #[arg(long, value_name = "HZ", default_value_t = 50.0)]
    wheels_hz: f64,
    /// Rate of its poses (1/s)
    #[arg(long, value_name = "HZ", default_value_t = 50.0)]
    poses_hz: f64,
    /// Standard deviations of its poses (m, rad)
    #[arg(long, value_name = "M,RAD", value_delimiter = ',', num_args = 2, default_values_t = [0.001, 0.002])]
    noise: Vec<f64>,
    /// It stands when no command has come for so long (s), as base controllers do
    #[arg(long, value_name = "S", default_value_t = 0.5)]
    command_timeout_s: f64,
    /// Seed of its noise
    #[arg(long, value_name = "N", default_value_t = 1)]
    seed: u64,
    /// End after so long (s) [default: at Ctrl-C]
    #[arg(long, value_name = "S")]
    duration_s: Option<f64>,
    /// Write every change of what it follows: time of the system's monotonic clock (ns), then v (m/s) and w (rad/s), or
    /// the torques of the right and the left wheel (N m)
    #[arg(long, value_name = "FILE.csv")]
    log: Option<PathBuf>,
    /// Write what it has seen as JSON
    #[arg(long, value_name = "FILE")]
    json: Option<PathBuf>,
}

/// Plays the robot until it is interrupted.
pub(crate) fn run(arguments: &Arguments) -> Result<Exit, Error> {
    require_network("slipstream robot-in-a-box")?;
    let lab = Lab::read(&arguments.lab)?;
    let robot = arguments.find(&lab)?;
    let path = arguments.robot.as_ref().unwrap_or(&robot.model);
    let model = robot_file::read_model(path)?;
    let options = BoxOptions {
        model: &model,
        pose: arguments.pose(&lab, robot)?,
        camera: arguments.camera()?,
        imu: Imu::default(),
        wheels_hz: positive("--wheels-hz", arguments.wheels_hz)?,
        command_timeout_s: positive("--command-timeout-s", arguments.command_timeout_s)?,
        seed: arguments.seed,
    };
    let mut log = log(arguments.log.as_deref())?;
    let stop = interrupt::stop_flag(Some(GRACE))?;
    let begin = Instant::now();
    let mut goes_on = || {
        let over = |end_s: f64| begin.elapsed().as_secs_f64() > end_s;
        !stop.load(Ordering::Relaxed) && !arguments.duration_s.is_some_and(over)
    };
    let (name, address) = (&robot.name, &robot.address);
    eprint_line!("{name} is a robot in a box at {address}; Ctrl-C ends it");
    let report = boxed::run(&lab, robot, &options, &mut *log, &mut goes_on);
    let report = report.map_err(|error| failed(path, error))?;
    log.flush()
        .map_err(|error| failed(path, BoxError::Log(error)))?;
    print_report(name, robot.command.message.drive(), &report);
    if let Some(path) = &arguments.json {
        output_file::write_json(path, &report)?;
    }
    Ok(Exit::Done)
}

impl Arguments {
    fn find<'a>(&self, lab: &'a Lab) -> Result<&'a LabRobot, InputError> {
        let found = lab.robots.iter().find(|robot| robot.name == self.name);
        found.ok_or_else(|| {
            let names: Vec<&str> = lab.robots.iter().map(|robot| robot.name.as_str()).collect();
            let problem = format!("has no robot {}", self.name);
            InputError::file(
                &self.lab,
                problem,
                format!("give one of {}", names.join(", ")),
            )
        })
    }

    /// Where it stands.
    fn pose(&self, lab: &Lab, robot: &LabRobot) -> Result<[f64; 3], InputError> {
        let Some(given) = &self.pose else {
            let index = lab.robots.iter().position(|own| own.name == robot.name);
            return Ok(lab.start_pose(u32::try_from(index.unwrap_or(0)).unwrap_or(0)));
        };
        let pose = <[f64; 3]>::try_from(given.as_slice()).ok();
        let pose = pose.filter(|pose| pose.iter().all(|own| own.is_finite()));
        pose.ok_or_else(|| InputError::new("--pose", "is no pose", "give x (m), y (m), yaw (rad)"))
    }

    fn camera(&self) -> Result<Camera, InputError> {
        let noise = |place: usize| self.noise.get(place).copied().unwrap_or(0.0);
        let camera = Camera {
            rate_hz: positive("--poses-hz", self.poses_hz)?,
            noise_m: noise(0),
            noise_rad: noise(1),
            ..Camera::default()
        };
        let valid = camera.noise_m >= 0.0 && camera.noise_rad >= 0.0;
        match valid && camera.noise_m.is_finite() && camera.noise_rad.is_finite() {
            true => Ok(camera),
            false => Err(InputError::new(
                "--noise",
                "is below 0 or no number",
                "give 0 or more",
            )),
        }
    }
}

/// A number that has to be above 0 and below the rate of the plant.
fn positive(argument: &str, value: f64) -> Result<f64, InputError> {
    match (1e-3..=1000.0).contains(&value) {
        true => Ok(value),
        false => Err(InputError::new(
            argument,
            format!("is {value}"),
            "give 0.001 to 1000",
        )),
    }
}

/// Where changes are logged: nowhere if no file is given.
fn log(path: Option<&Path>) -> Result<Box<dyn Write>, InputError> {
    let Some(path) = path else {
        return Ok(Box::new(std::io::sink()));
    };
    let file = std::fs::File::create(path);
    match file {
        // Lines are few, and what is not written when the box is killed is lost.
        Ok(file) => Ok(Box::new(std::io::LineWriter::new(file))),
        Err(error) => Err(InputError::unreadable(path, &error)),
    }
}

fn failed(model: &Path, error: BoxError) -> Error {
    match error {
        BoxError::Model(error) => {
            let place = format!("{}: {}", model.display(), error.place);
            InputError { place, ..error }.into()
        }
        other => Error::Failed(other.to_string()),
    }
}

fn print_report(name: &str, drive: Drive, report: &BoxReport) {
    let BoxReport {
        commands,
        unreadable,
        largest: [first, second],
        final_pose: [x, y, yaw],
        ..
    } = report;
    let degrees = yaw.to_degrees();
    let largest = match drive {
        Drive::Twist => format!("{first:.3} m/s and {second:.2} rad/s"),
        Drive::Torque => format!("{first:.3} N m right and {second:.3} N m left"),
    };
    print_line!(
        "{name}: {commands} commands, up to {largest}; ended at {x:.3}, {y:.3} m, {degrees:.1}°"
    );
    if *unreadable > 0 {
        print_line!(
            "  {unreadable} more could not be read: is the command's type right in robots.toml?"
        );
    }
}
