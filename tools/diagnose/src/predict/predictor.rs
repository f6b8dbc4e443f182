//! The runs of one machine cut into windows, and how far predictions of them go astray.

use rayon::prelude::*;
use slipstream_bus::{InputError, RobotModel};
use slipstream_recording::Recording;
use slipstream_recording::recording::Robot as Recorded;
use slipstream_sim::effects::{Info, When, find};
use slipstream_sim::{CommandKind, Robot};

use crate::data::track::{CHANNEL_NAMES, Sensor, Track};
use crate::judge::{HEADING, PLACE, POSE, Score};
use crate::model::hypothesis::{
    Hypothesis, changes_commands_over_time, is_bound_to_place, slides, with,
};
use crate::predict::facing::Facing;
use crate::predict::simulation::{Simulated, asinh_expanded};
use crate::predict::start::Start;
use crate::predict::sum_of_squares::SumOfSquares;
use crate::predict::window::{Window, at_most, cut_some};
use crate::request::{Request, model_of};

/// Rows of a series above which it is thinned: more say no more.
const ROWS: usize = 9000;

/// Longest step of a simulation (s): where wheels slip or gears have play, where they do not, and
/// where they turn exactly as told.
const SHORT_STEP_S: f64 = 2e-3;
const STEP_S: f64 = 4e-3;
const LONG_STEP_S: f64 = 0.02;

/// Channels that tell whether a start is known: wheels and pose.
const FITTED: [usize; 5] = [0, 1, POSE, POSE + 1, POSE + 2];
/// Time over which the start of a window is fitted (s), and up to how many times as long where the
/// pose was seen less often than `SEEN` times in it.
pub(crate) const FITTED_S: f64 = 0.5;
const AT_MOST: u32 = 5;
const SEEN: usize = 5;

/// The runs of one machine, windows of them, and its nominal model.
pub(crate) struct Predictor {
    pub(crate) tracks: Vec<Track>,
    pub(crate) windows: Vec<Window>,
    pub(crate) model: RobotModel,
}

/// A window that was predicted.
struct JudgedWindow {
    /// Residuals (deviations) behind what the start was fitted to; NaN for that.
    residuals: Vec<f64>,
    /// How far the channel that is worst is from what the start was fitted to (deviations).
    start: f64,
    /// How long that is (s).
    fitted_s: f64,
}

impl Predictor {
    /// The runs of a machine, with its nominal model.
    ///
    /// # Errors
    /// A run that cannot be read, or too little to predict.
    pub(crate) fn new(
        request: &Request<'_>,
        machine: &[(&Recording, &Recorded)],
    ) -> Result<Self, InputError> {
        let robot = machine[0].1;
        let model = model_of(request, machine[0])?;
        let constants = Robot::<f64>::new(&model)?;
        let mut tracks = Vec::new();
        for (recording, robot) in machine {
            let mut track = Track::new(recording, robot, &model)?;
            constants.accepts(track.kind())?;
            track.leave_out(request.excluded_s);
            track.thin(ROWS);
            tracks.push(track);
        }
        let windows = cut_some(&tracks);
        if windows.is_empty() {
            let remedy = "record at least a few seconds, or exclude less";
            return Err(InputError::new(&robot.name, "has nothing to fit", remedy));
        }
        Ok(Self {
            tracks,
            windows,
            model,
        })
    }

    /// At most so many windows, at equal distances.
    pub(crate) fn some_windows(&self, most: usize) -> Vec<Window> {
        at_most(&self.windows, most)
    }

    /// The robot with these effects. `None` for one that cannot be.
    pub(crate) fn simulated(&self, hypotheses: &[Hypothesis]) -> Option<Simulated> {
        let model = with(&self.model, hypotheses);
        let listed = model.effects.iter();
        let infos: Vec<&Info> = listed.filter_map(|own| find(&own.effect)).collect();
        let has = |such: fn(&Info) -> bool| infos.iter().any(|info| such(info));
        let slips = has(|info| slides(info) || info.acts == When::Apart);
        let kind = self.tracks.first().map_or(CommandKind::Torque, Track::kind);
        let as_told = kind == CommandKind::Speed && !has(changes_commands_over_time);
        let step_s = if as_told && !slips {
            LONG_STEP_S
        } else if slips {
            SHORT_STEP_S
        } else {
            STEP_S
        };
        Some(Simulated {
            robot: Robot::new(&model).ok()?.draft(),
            step_s,
            bound_to_place: has(is_bound_to_place),
        })
    }

    /// What each of `windows` scores by the model with `hypotheses`.
    pub(crate) fn scores(&self, windows: &[Window], hypotheses: &[Hypothesis]) -> Vec<Score> {
        let all = self.each(windows, hypotheses, |simulated, window| {
            let judged = self.judged(simulated, window)?;
            Some(self.score(window, &judged))
        });
        all.into_iter().map(Option::unwrap_or_default).collect()
    }

    /// Residuals (deviations) of each of `windows` by the model with `hypotheses`.
    pub(crate) fn residuals(
        &self,
        windows: &[Window],
        hypotheses: &[Hypothesis],
    ) -> Vec<Option<Vec<f64>>> {
        self.each(windows, hypotheses, |simulated, window| {
            Some(self.predicted(simulated, window)?.0)
        })
    }

    /// What `of` says of each of `windows` by the model with `hypotheses`.
    fn each<T: Send>(
        &self,
        windows: &[Window],
        hypotheses: &[Hypothesis],
        of: impl Fn(&Simulated, &Window) -> Option<T> + Sync,
    ) -> Vec<Option<T>> {
        let simulated = self.simulated(hypotheses);
        let all = windows.par_iter();
        all.map(|window| of(simulated.as_ref()?, window)).collect()
    }

    fn score(&self, window: &Window, judged: &JudgedWindow) -> Score {
        let mut score = Score::default();
        let mut start = judged.start;
        let track = &self.tracks[window.run];
        let has_pose = track.of(Sensor::Pose).is_some();
        for (which, series) in track.series.iter().enumerate() {
            let (first, width) = (series.sensor.channel(), series.sensor.width());
            let variance = series.deviation.map(|own| own * own);
            let facing = Facing::new(window, track, which, judged.fitted_s);
            if facing.is_unknown() {
                start = f64::INFINITY;
            }
            let mut first_row = None;
            for (_, values, base) in window.measured(track, which) {
                let square = |part: usize| judged.residuals[base + part].powi(2) * variance[part];
                let of_start = facing.spread(values);
                let known = [0, 1, 2].map(|part| variance[part] + of_start[part]);
                for part in 0..width {
                    score.add(first + part, square(part), variance[part], known[part]);
                }
                let zero = match series.sensor {
                    Sensor::WheelSpeed => [0.0; 3],
                    _ => *first_row.get_or_insert(values),
                };
                let gone = [0, 1, 2].map(|part| (values[part] - zero[part]).powi(2));
                match series.sensor {
                    Sensor::Pose => {
                        let both = variance[0] + variance[1];
                        let expected = both + of_start[0] + of_start[1];
                        score.add(PLACE, square(0) + square(1), both, expected);
                        score.add(HEADING, square(2), variance[2], variance[2]);
                        let each = [gone, [0, 1, 2].map(square), known];
                        let squares = each.map(|[x, y, yaw]| [x + y, yaw]);
                        score.follow(self.model.robot.half_track_m, squares);
                    }
                    Sensor::WheelAngle | Sensor::WheelSpeed if !has_pose => {
                        for part in 0..width {
                            score.follow_wheel([gone[part], square(part), variance[part]]);
                        }
                    }
                    _ => {}
                }
            }
        }
        for (channel, more) in window.repeated(&judged.residuals) {
            score.repeat(channel, more, self.deviation(channel).powi(2));
        }
        score.begin(start);
        score
    }

    fn judged(&self, simulated: &Simulated, window: &Window) -> Option<JudgedWindow> {
        let (mut residuals, fitted_s) = self.predicted(simulated, window)?;
        let mut head = residuals.clone();
        for (residual, stamp_s) in head.iter_mut().zip(&window.stamps_s) {
            if *stamp_s >= window.from_s + fitted_s {
                *residual = f64::NAN;
            }
        }
        let head = SumOfSquares::new(window, &head);
        let levels = FITTED.map(|channel| head.mean_square(channel).sqrt());
        let start = levels.into_iter().fold(0.0, f64::max);
        let acceleration = [0, 1].map(|part| Sensor::Imu.channel() + part);
        let stamped = window.stamps_s.iter().zip(&window.channels);
        for (residual, (stamp_s, channel)) in residuals.iter_mut().zip(stamped) {
            if *stamp_s < window.from_s + fitted_s {
                *residual = f64::NAN;
            } else if acceleration.contains(&usize::from(*channel)) {
                *residual = asinh_expanded(*residual);
            }
        }
        Some(JudgedWindow {
            residuals,
            start,
            fitted_s,
        })
    }

    /// Residuals (deviations) of the prediction of one window, what its start was fitted to included,
    /// and how long that is (s).
    pub(crate) fn predicted(
        &self,
        simulated: &Simulated,
        window: &Window,
    ) -> Option<(Vec<f64>, f64)> {
        let track = &self.tracks[window.run];
        (1..=AT_MOST).find_map(|times| {
            let fitted_s = FITTED_S * f64::from(times);
            let mut head = window.head(track, fitted_s);
            head.free = window.free;
            let start = Start::guess(simulated, track, &head, &self.model.robot);
            if times < AT_MOST && window.free[0] && start.poses() < SEEN {
                return None;
            }
            let start = start.fitted()?;
            Some((simulated.over(track, window).residuals(&start), fitted_s))
        })
    }

    /// Standard deviation of the sensor of a channel, in its unit.
    pub(crate) fn deviation(&self, channel: usize) -> f64 {
        let mut series = self.tracks[0].series.iter();
        let own = series.find_map(|series| {
            let part = channel.checked_sub(series.sensor.channel())?;
            (part < series.sensor.width()).then(|| series.deviation[part])
        });
        own.unwrap_or(1.0)
    }
}

/// Unit of a channel; wheels are measured by `angles` or by speeds.
pub(crate) fn unit(channel: usize, angles: bool) -> &'static str {
    match CHANNEL_NAMES[channel] {
        "wheel_right" | "wheel_left" if angles => "rad",
        "pose_x" | "pose_y" => "m",
        "pose_yaw" => "rad",
        "odometry_v" => "m/s",
        "imu_ax" | "imu_ay" => "m/s²",
        _ => "rad/s",
    }
}
