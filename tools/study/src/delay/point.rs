//! One point of a study: the results of its runs, combined.

use serde::{Deserialize, Serialize};
use slipstream_agents::Geometry;
use slipstream_bus::Experiment;
use slipstream_launch::Reports;

use super::follower_recorder::FollowerRecorder;
use super::forms::{Form, bound_m_s};
use super::grid::GridCell;
use super::string_stability::string_gain;

/// The combined results of one point. Maxima are over all followers' outer ticks from the start of
/// coordination on, and over all runs; times and gains are means over the runs.
///
/// The forms of the paper's Eq. 13 and 14 are evaluated at the same ticks with τ = `age_s`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Point {
    /// The point of the grid.
    #[serde(flatten)]
    pub cell: GridCell,
    /// Number of runs.
    pub runs: u32,
    /// The largest desired speed before limiting (m/s).
    pub max_desired_speed_m_s: f64,
    /// The largest bound that Eq. 14 gives (m/s).
    pub bound_eq14_m_s: f64,
    /// The largest speed by Eq. 13 as printed, the exponentials taken as numbers (m/s).
    pub literal_eq13_m_s: f64,
    /// The same with the sign of Eq. 12 (m/s).
    pub literal_eq13_sign_m_s: f64,
    /// The largest speed by Eq. 13 read as a transport delay (m/s).
    pub transport_delay_m_s: f64,
    /// Slip time: how long contacts slid, summed over all followers and both wheels (s).
    pub slip_time_s: f64,
    /// The largest true spacing error (m).
    pub max_spacing_error_m: f64,
    /// String gain: the largest ratio of a follower's largest true spacing error to that of the
    /// follower ahead; null with one follower, or if the one ahead had no error.
    pub string_gain: Option<f64>,
    /// Peak of the linear model's frequency response from follower to follower.
    pub string_gain_frequency: Option<f64>,
    /// Mean age of the position in use (s): link delay, waiting for ticks, token round of the ring.
    pub age_s: f64,
    /// Share of the sent messages that were lost (1).
    pub lost: f64,
    /// Error of each form against the measured desired speed.
    pub fits: Vec<FormError>,
    /// Share of the ticks at which the measured desired speed exceeded Eq. 14's bound (1).
    pub beyond_bound: f64,
}

/// Error of a form against the measured desired speed.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct FormError {
    /// The form, by its name.
    pub form: String,
    /// Root mean square over all ticks of all runs (m/s).
    pub rms_m_s: f64,
}

/// The result of one run.
#[derive(Debug, Clone)]
pub struct RunResult {
    max_desired_m_s: f64,
    bound_m_s: f64,
    /// Largest speed (m/s) and sum of squared errors (m²/s²) of each form, in the order of
    /// [`Form::ALL`].
    largest_m_s: [f64; 5],
    squares: [f64; 5],
    beyond_bound: f64,
    ticks: f64,
    slip_time_s: f64,
    max_spacing_error_m: f64,
    string_gain: Option<f64>,
    age_s: f64,
    sent: u64,
    lost: u64,
}

impl RunResult {
    /// Combines a run's reports with what was recorded of it.
    pub fn new(experiment: &Experiment, reports: &Reports, recorder: &FollowerRecorder) -> Self {
        let k_x = experiment.settings.control.k_x;
        let age_s = recorder.mean_age_s();
        let decay = (-age_s).exp();
        let followers = reports.plant.robots.iter().skip(1);
        let errors: Vec<f64> = followers
            .clone()
            .filter_map(|robot| robot.max_spacing_error_m)
            .collect();
        let received = reports.agents.iter().flat_map(|agent| &agent.received);
        let mut run = Self {
            max_desired_m_s: recorder.max_desired_m_s(),
            bound_m_s: 0.0,
            largest_m_s: [0.0; 5],
            squares: [0.0; 5],
            beyond_bound: 0.0,
            ticks: 0.0,
            slip_time_s: followers.flat_map(|robot| robot.slip_time_s).sum(),
            max_spacing_error_m: errors.iter().copied().fold(0.0, f64::max),
            string_gain: gain(&errors),
            age_s,
            sent: reports
                .agents
                .iter()
                .flat_map(|agent| &agent.sent)
                .map(|&(_, sent)| sent)
                .sum(),
            lost: received.map(|(_, counts)| counts.lost).sum(),
        };
        for (tick, delayed) in recorder.ticks(age_s) {
            let bound = bound_m_s(tick, decay, k_x);
            run.bound_m_s = run.bound_m_s.max(bound);
            run.beyond_bound += f64::from(u8::from(tick.desired_m_s.abs() > bound));
            run.ticks += 1.0;
            for (i, form) in Form::ALL.iter().enumerate() {
                let v = form.desired_m_s(tick, delayed, decay, k_x);
                run.largest_m_s[i] = run.largest_m_s[i].max(v.abs());
                run.squares[i] += (v - tick.desired_m_s).powi(2);
            }
        }
        run
    }
}

/// The largest ratio of one error to the one before it.
fn gain(errors: &[f64]) -> Option<f64> {
    let ratios = errors
        .windows(2)
        .filter(|pair| pair[0] > 0.0)
        .map(|pair| pair[1] / pair[0]);
    ratios.reduce(f64::max)
}

impl Point {
    /// Combines the runs of a cell, in their order.
    pub fn new(cell: &GridCell, experiment: &Experiment, runs: &[RunResult]) -> Self {
        let largest = |pick: &dyn Fn(&RunResult) -> f64| runs.iter().map(pick).fold(0.0, f64::max);
        let sum = |pick: &dyn Fn(&RunResult) -> f64| runs.iter().map(pick).sum::<f64>();
        let count = runs.len().max(1) as f64;
        let ticks = sum(&|run| run.ticks).max(1.0);
        let gains: Vec<f64> = runs.iter().filter_map(|run| run.string_gain).collect();
        let [lost, sent] = [
            runs.iter().map(|run| run.lost).sum::<u64>(),
            runs.iter().map(|run| run.sent).sum::<u64>(),
        ];
        let age_s = sum(&|run| run.age_s) / count;
        let control = &experiment.settings.control;
        let geometry = experiment
            .robots
            .first()
            .and_then(|robot| Geometry::new(&robot.model).ok());
        Self {
            cell: cell.clone(),
            runs: u32::try_from(runs.len()).unwrap_or(u32::MAX),
            max_desired_speed_m_s: largest(&|run| run.max_desired_m_s),
            bound_eq14_m_s: largest(&|run| run.bound_m_s),
            literal_eq13_m_s: largest(&|run| run.largest_m_s[2]),
            literal_eq13_sign_m_s: largest(&|run| run.largest_m_s[3]),
            transport_delay_m_s: largest(&|run| run.largest_m_s[4]),
            slip_time_s: sum(&|run| run.slip_time_s) / count,
            max_spacing_error_m: largest(&|run| run.max_spacing_error_m),
            string_gain: (!gains.is_empty())
                .then(|| gains.iter().sum::<f64>() / gains.len() as f64),
            string_gain_frequency: geometry
                .and_then(|geometry| string_gain(control, &geometry, age_s, cell.robots)),
            age_s,
            lost: lost as f64 / (sent.max(1)) as f64,
            fits: Form::ALL
                .iter()
                .enumerate()
                .map(|(i, form)| FormError {
                    form: form.name().to_owned(),
                    rms_m_s: (sum(&|run| run.squares[i]) / ticks).sqrt(),
                })
                .collect(),
            beyond_bound: sum(&|run| run.beyond_bound) / ticks,
        }
    }

    /// Root mean square error of a form (m/s); NaN if the point does not have it.
    pub fn rms_m_s(&self, form: Form) -> f64 {
        let fit = self.fits.iter().find(|fit| fit.form == form.name());
        fit.map_or(f64::NAN, |fit| fit.rms_m_s)
    }
}
