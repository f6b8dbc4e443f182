//! One run of an experiment with its reports, true states and outer ticks.

use slipstream_bus::Experiment;
use slipstream_bus::record::{OuterTick, Record, State};
use slipstream_bus::time::s_from_ns;
use slipstream_launch::{Reports, Request, in_process, resolve};

use crate::StudyError;

/// A run with its reports, true states and outer ticks.
#[derive(Debug, Clone)]
pub struct RecordedRun {
    /// The experiment.
    pub experiment: Experiment,
    /// The reports of plant and agents.
    pub reports: Reports,
    states: Vec<State>,
    ticks: Vec<OuterTick>,
}

impl RecordedRun {
    /// Runs a built-in experiment with a torque limit and other keys.
    ///
    /// # Errors
    /// When the run fails.
    pub fn of_experiment(
        name: &str,
        torque_limit: &str,
        keys: &[(&str, &str)],
    ) -> Result<Self, StudyError> {
        let set = [&[("control.torque_limit", torque_limit)], keys].concat();
        let own = |(key, value): (&str, &str)| (key.to_owned(), value.to_owned());
        let request = Request {
            experiment: Some(name.to_owned()),
            set: set.into_iter().map(own).collect(),
            ..Request::default()
        };
        Self::new(resolve(&request)?.experiment)
    }

    /// Runs an experiment.
    ///
    /// # Errors
    /// When the run fails.
    pub fn new(experiment: Experiment) -> Result<Self, StudyError> {
        let (reports, records) =
            in_process::run_recorded(&experiment, false, Vec::<Record>::new())?;
        let states = records.iter().filter_map(|record| match record {
            Record::State(state) => Some(*state),
            _ => None,
        });
        let ticks = records.iter().filter_map(|record| match record {
            Record::Outer(tick) => Some(*tick),
            _ => None,
        });
        Ok(Self {
            states: states.collect(),
            ticks: ticks.collect(),
            experiment,
            reports,
        })
    }

    /// The true states of a robot.
    pub fn states(&self, robot: u32) -> impl Iterator<Item = &State> {
        self.states.iter().filter(move |state| state.robot == robot)
    }

    /// The outer ticks of a robot.
    pub fn ticks(&self, robot: u32) -> impl Iterator<Item = &OuterTick> {
        self.ticks.iter().filter(move |tick| tick.robot == robot)
    }

    /// Number of robots.
    pub fn robots(&self) -> u32 {
        self.experiment.settings.robots.count
    }

    /// A coordinate of the true position over time: (s, m).
    pub fn true_line(&self, robot: u32, axis: usize) -> Vec<(f64, f64)> {
        self.states(robot)
            .map(|state| (s_from_ns(state.t_ns), state.pose[axis]))
            .collect()
    }

    /// A coordinate of the position by odometry over time: (s, m).
    pub fn odometry_line(&self, robot: u32, axis: usize) -> Vec<(f64, f64)> {
        self.ticks(robot)
            .map(|tick| (s_from_ns(tick.t_ns), tick.pose[axis]))
            .collect()
    }

    /// The true path of a robot: (m, m).
    pub fn true_path(&self, robot: u32) -> Vec<(f64, f64)> {
        let poses = self.states(robot).map(|state| state.pose);
        poses.map(|[x_m, y_m, _]| (x_m, y_m)).collect()
    }

    /// The path of a robot by odometry: (m, m).
    pub fn odometry_path(&self, robot: u32) -> Vec<(f64, f64)> {
        let poses = self.ticks(robot).map(|tick| tick.pose);
        poses.map(|[x_m, y_m, _]| (x_m, y_m)).collect()
    }

    /// Odometry minus truth at the end, along an axis (m).
    pub fn final_gap_m(&self, robot: u32, axis: usize) -> f64 {
        let i = robot as usize;
        self.reports.agents[i].final_odometry[axis] - self.reports.plant.robots[i].final_true[axis]
    }

    /// Slip time: how long contacts slid, summed over all robots and both wheels (s).
    pub fn slip_time_s(&self) -> f64 {
        let robots = self.reports.plant.robots.iter();
        robots.flat_map(|robot| robot.slip_time_s).sum()
    }

    /// The largest true spacing error (m).
    pub fn max_spacing_error_m(&self) -> f64 {
        let robots = self.reports.plant.robots.iter();
        robots
            .filter_map(|robot| robot.max_spacing_error_m)
            .fold(0.0, f64::max)
    }

    /// True spacing errors of all followers along x, with their times, from the beginning of
    /// coordination on: (s, m). For a platoon that drives straight.
    fn spacing_errors(&self) -> impl Iterator<Item = (f64, f64)> {
        let formation = &self.experiment.settings.formation;
        (1..self.robots()).flat_map(move |robot| {
            let pairs = self.states(robot - 1).zip(self.states(robot));
            pairs.filter_map(move |(ahead, own)| {
                let t_s = s_from_ns(own.t_ns);
                let error_m = (ahead.pose[0] - own.pose[0] - formation.spacing_m).abs();
                (t_s >= formation.start_s).then_some((t_s, error_m))
            })
        })
    }

    /// Root mean square of the true spacing errors of all followers (m).
    pub fn rms_spacing_error_m(&self) -> f64 {
        let (sum, count) = self
            .spacing_errors()
            .fold((0.0, 0.0), |(sum, count), (_, e)| {
                (sum + e * e, count + 1.0)
            });
        f64::sqrt(sum / f64::max(count, 1.0))
    }

    /// When the true spacing error of a follower was largest (s).
    pub fn worst_spacing_at_s(&self) -> f64 {
        let largest = self.spacing_errors().max_by(|a, b| a.1.total_cmp(&b.1));
        largest.map_or(f64::NAN, |(t_s, _)| t_s)
    }

    /// Error of the true spacings at the end, the largest (m).
    pub fn final_spacing_error_m(&self) -> f64 {
        let spacing_m = self.experiment.settings.formation.spacing_m;
        let robots = self.reports.plant.robots.windows(2);
        let error =
            robots.map(|pair| (pair[0].final_true[0] - pair[1].final_true[0] - spacing_m).abs());
        error.fold(0.0, f64::max)
    }

    /// Mean distance of all robots from the straight line at the end (m).
    pub fn mean_lateral_m(&self) -> f64 {
        let robots = &self.reports.plant.robots;
        let sum: f64 = robots.iter().map(|robot| robot.final_true[1].abs()).sum();
        sum / robots.len() as f64
    }

    /// Roughness of x(t) by odometry from the start of coordination on: root mean square jerk (m/s³) of
    /// all robots, from the third difference over the outer ticks.
    pub fn roughness_m_s3(&self) -> f64 {
        let settings = &self.experiment.settings;
        let period_s = settings.control.outer_period_s;
        let (mut sum, mut count) = (0.0, 0.0);
        for robot in 0..self.robots() {
            let line = self.odometry_line(robot, 0);
            let from = line.partition_point(|&(t_s, _)| t_s < settings.formation.start_s);
            for four in line[from..].windows(4) {
                let [a, b, c, d] = [0, 1, 2, 3].map(|i| four[i].1);
                let jerk = (d - 3.0 * c + 3.0 * b - a) / period_s.powi(3);
                sum += jerk * jerk;
                count += 1.0;
            }
        }
        f64::sqrt(sum / f64::max(count, 1.0))
    }
}
