//! Predictions of a recording by a model, in windows of 5 s whose initial states are free. They have no
//! noise and use the simulator that made the recording.

use std::f64::consts::TAU;

use nalgebra::DVector;
use slipstream_bus::RobotModel;
use slipstream_trial_plant::{OutsideEffect, Physics, Plant, State};

use super::information::Nuisance;
use super::scene::{Camera, Scene};
use super::sensors::{IMU_M_S2, IMU_RAD_S, POSE_M, POSE_RAD, Sensors, Stream, interpolate};
use super::simulate::SimulatedRobot;

/// Step of the predictions (s).
const STEP_S: f64 = 5e-4;
/// Largest shift of sample times by clocks and latencies (s).
const MAX_CLOCK_SHIFT_S: f64 = 0.2;
/// Number of components of an initial state: x, y, yaw, surge, yaw rate.
const INITIAL_COMPONENTS: usize = 5;
/// How many of them belong to the pose.
const POSE_COMPONENTS: usize = 3;
/// Difference step of an initial state (m, rad, m/s, rad/s).
const DIFFERENCE: f64 = 1e-5;

/// A model that predicts a recording.
pub(crate) struct PredictionModel {
    plant: Plant,
    sensors: Sensors,
}

impl PredictionModel {
    /// A model with an effect outside the vocabulary, if any.
    ///
    /// # Errors
    /// A model that cannot be simulated.
    pub(crate) fn new(
        scene: &Scene,
        model: &RobotModel,
        outside: Option<OutsideEffect>,
    ) -> Result<Self, String> {
        let mut physics = Physics::new(model)?;
        physics.outside.extend(outside);
        let sensors = Sensors::new(&model.effects, physics.grade);
        Ok(Self {
            plant: Plant::new(physics, scene.command_kind.quantity(), STEP_S),
            sensors,
        })
    }
}

/// The windows of one robot's recording.
pub(crate) struct Windows<'a> {
    robot_run: &'a SimulatedRobot,
    /// Encoder counts per revolution.
    counts: f64,
    camera: Camera,
    accelerometer: bool,
}

impl<'a> Windows<'a> {
    /// The windows of robot `i` of a scene.
    pub(crate) fn new(scene: &Scene, i: usize, robot_run: &'a SimulatedRobot) -> Self {
        Self {
            robot_run,
            counts: scene.counts_per_rev(),
            camera: scene.robots[i].camera,
            accelerometer: scene.recorded.accelerometer,
        }
    }

    /// Predicts the measurements of each window, wheels first: wheel angles in counts, the others in standard
    /// deviations of their noise. With `component`, this component of the initial state is perturbed.
    pub(crate) fn predict(
        &self,
        model: &PredictionModel,
        component: Option<usize>,
    ) -> Vec<DVector<f64>> {
        let windows = self.initial_states();
        windows
            .map(|(start, end_s)| self.predict_window(model, start, end_s, component))
            .collect()
    }

    /// What was measured in each window, without the noise of the sensors, in the order and the units of
    /// [`Self::predict`].
    pub(crate) fn measured(&self, model: &PredictionModel) -> Vec<DVector<f64>> {
        let truth = &self.robot_run.truth;
        let window = |(start, end_s): (&State, f64)| {
            let mut rows = Vec::new();
            for (stream, times) in truth.sample_times.0.iter().enumerate() {
                let sampled = &truth.sampled[stream];
                for (at, t_s) in times.iter().enumerate() {
                    // The last samples may lie behind the end of the simulation.
                    let state = sampled.get(at).or(sampled.last());
                    if let Some(state) = state.filter(|_| within(*t_s, [start.t_s, end_s])) {
                        self.rows(model, stream, state, &mut rows);
                    }
                }
            }
            DVector::from_vec(rows)
        };
        self.initial_states().map(window).collect()
    }

    /// The initial state and the end (s) of each window.
    fn initial_states(&self) -> impl Iterator<Item = (&State, f64)> {
        let states = &self.robot_run.truth.window_starts;
        let ends = states
            .iter()
            .skip(1)
            .map(|state| state.t_s)
            .chain([f64::INFINITY]);
        states.iter().zip(ends)
    }

    /// The nuisance parameters of each window: its initial state and the phases of the encoders.
    /// `predictions` and `perturbed` are those of the true model, the latter for each component;
    /// `count_weight` is the weight of the wheels' rows.
    pub(crate) fn nuisances(
        &self,
        predictions: &[DVector<f64>],
        perturbed: &[Vec<DVector<f64>>],
        count_weight: f64,
    ) -> Vec<Nuisance> {
        let bounds: Vec<[f64; 2]> = self
            .initial_states()
            .map(|(start, end_s)| [start.t_s, end_s])
            .collect();
        let nuisance = |(at, window): (usize, &DVector<f64>)| {
            let wheels = 2 * self.samples_in(Stream::Wheels, bounds[at]).count();
            let rows = |value: &dyn Fn(usize) -> f64| {
                DVector::from_iterator(window.len(), (0..window.len()).map(value))
            };
            let phase =
                |wheel: usize| rows(&|row| f64::from(u8::from(row < wheels && row % 2 == wheel)));
            let scale = rows(&|row| if row < wheels { count_weight } else { 1.0 });
            let states = perturbed
                .iter()
                .map(|perturbed| (&perturbed[at] - window).component_mul(&scale));
            let columns: Vec<DVector<f64>> = states.chain([phase(0), phase(1)]).collect();
            Nuisance::new(scale, columns.into_iter())
        };
        predictions.iter().enumerate().map(nuisance).collect()
    }

    /// The sample times of a stream in a window, without the first 0.2 s: with another clock these might lie
    /// before its start.
    fn samples_in(&self, stream: Stream, window_s: [f64; 2]) -> impl Iterator<Item = f64> {
        let sample_times = self.robot_run.truth.sample_times.0[stream as usize]
            .iter()
            .copied();
        sample_times.filter(move |t_s| within(*t_s, window_s))
    }

    fn predict_window(
        &self,
        model: &PredictionModel,
        start: &State,
        end_s: f64,
        component: Option<usize>,
    ) -> DVector<f64> {
        let commands = &self.robot_run.commands;
        let mut state = model.plant.adopt(start, commands);
        let at_rest = state.velocity.iter().all(|value| value.abs() < 1e-9);
        // A robot at rest is known to have no velocity.
        if let Some(component) =
            component.filter(|component| *component < POSE_COMPONENTS || !at_rest)
        {
            model.plant.perturb(&mut state, component, DIFFERENCE);
        }
        // True sample times by the clocks of this model, latest first.
        let mut due = [Stream::Wheels, Stream::Pose, Stream::Imu].map(|stream| {
            let stamps = self.samples_in(stream, [start.t_s, end_s]);
            let stamps = stamps.map(|t_s| self.robot_run.truth.sensors.stamp_s(stream, t_s));
            let mut times: Vec<f64> = stamps
                .map(|stamp| model.sensors.true_s(stream, stamp))
                .collect();
            times.reverse();
            times
        });
        let last_s = due
            .iter()
            .filter_map(|times| times.first().copied())
            .fold(start.t_s, f64::max);
        let mut rows = [Vec::new(), Vec::new(), Vec::new()];
        model
            .plant
            .advance(commands, &mut state, last_s, |before, after| {
                for (stream, times) in due.iter_mut().enumerate() {
                    while let Some(t_s) = times.pop_if(|t_s| *t_s <= after.t_s) {
                        let sample = interpolate(before, after, t_s.max(before.t_s));
                        self.rows(model, stream, &sample, &mut rows[stream]);
                    }
                }
            });
        for (stream, times) in due.iter().enumerate() {
            for _ in times {
                self.rows(model, stream, &state, &mut rows[stream]);
            }
        }
        DVector::from_vec(rows.concat())
    }

    /// Appends the measurements of one sample.
    fn rows(&self, model: &PredictionModel, stream: usize, state: &State, rows: &mut Vec<f64>) {
        match stream {
            0 => {
                let angles = model.sensors.angles(state);
                rows.extend(angles.map(|angle| angle * self.counts / TAU));
            }
            1 => {
                let [x, y, yaw] = model.sensors.pose(state);
                rows.extend([x / POSE_M, y / POSE_M]);
                if self.camera == Camera::Pose {
                    rows.push(yaw / POSE_RAD);
                }
            }
            _ => {
                let [along, across, rate] = model.sensors.inertial(state);
                if self.accelerometer {
                    rows.extend([along / IMU_M_S2, across / IMU_M_S2]);
                }
                rows.push(rate / IMU_RAD_S);
            }
        }
    }
}

/// Whether a sample counts in a window: not in its first 0.2 s.
fn within(t_s: f64, [from_s, end_s]: [f64; 2]) -> bool {
    (from_s + MAX_CLOCK_SHIFT_S..end_s).contains(&t_s)
}

/// Predicts the windows with each component of the initial state perturbed.
pub(crate) fn perturbed(windows: &Windows<'_>, model: &PredictionModel) -> Vec<Vec<DVector<f64>>> {
    (0..INITIAL_COMPONENTS)
        .map(|component| windows.predict(model, Some(component)))
        .collect()
}
