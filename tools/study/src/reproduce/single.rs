//! Section 3: one robot, a torque step, encoder against camera (Fig. 5 and 6). The true pose stands in
//! for the camera.

use slipstream_bus::time::s_from_ns;

use super::recorded_run::RecordedRun;
use super::row::{PaperRow, TOLERANCE};

/// Source of the run without the torque limit.
const WITHOUT: &str = "Fig. 5, section 3";
/// Source of the run with the torque limit.
const WITH: &str = "Fig. 6, section 3";

/// Assumptions that change the run without the torque limit.
const ASSUMPTIONS: [&str; 2] = ["motor", "friction"];

/// The gap between encoder and camera, then the contradictions in the paper's text.
pub(super) fn rows(runs: &[RecordedRun; 2]) -> Vec<PaperRow> {
    let [without, with] = runs;
    let mut rows = gaps(without, with);
    rows.extend(contradictions(without));
    rows
}

/// The gap between encoder and camera at the end of both runs.
fn gaps(without: &RecordedRun, with: &RecordedRun) -> Vec<PaperRow> {
    let gaps = [without, with].map(|run| run.final_gap_m(0, 0));
    let distance_m = with.reports.plant.robots[0].final_true[0];
    vec![
        PaperRow::claim(
            "single_gap_without_limit_m",
            WITHOUT,
            gaps[0],
            gaps[0] > 0.0,
        )
        .note("encoder minus camera at the end: the encoder is ahead, as Fig. 5 says")
        .depending_on(&ASSUMPTIONS),
        PaperRow::claim(
            "single_gap_with_limit_m",
            WITH,
            gaps[1],
            gaps[1].abs() <= TOLERANCE * distance_m,
        )
        .note(format!(
            "encoder minus camera after {distance_m:.3} m: they match, as Fig. 6 says"
        ))
        .depending_on(&["motor", "friction", "limit"]),
    ]
}

/// Where the run without the limit contradicts the paper's text.
fn contradictions(without: &RecordedRun) -> Vec<PaperRow> {
    let (_, off_s) = step(without);
    let slip_after_s = slip_after_s(without, off_s);
    let [speed_off, speed_end] = [speed_m_s(without, off_s), speed_m_s(without, f64::INFINITY)];
    let fastest = without
        .states(0)
        .flat_map(|state| state.wheel_speed_rad_s)
        .fold(0.0, f64::max);
    let model = &without.experiment.robots[0].model;
    let no_load = model
        .motor
        .as_ref()
        .map_or(f64::NAN, |motor| motor.no_load_speed_rad_s);
    vec![
        PaperRow::printed(
            "single_speed_at_end_over_speed_when_torque_ends",
            "\"the torque is set to zero (i.e., constant velocity)\", section 3",
            1.0,
            speed_end / speed_off,
        )
        .note(
            "a contradiction in the text: without the limit the wheels still slide when the torque \
             ends, and their spin drives the robot on until they roll",
        )
        .depending_on(&ASSUMPTIONS),
        PaperRow::found("single_slip_after_torque_ends_s", WITHOUT, slip_after_s)
            .note("how long the right wheel goes on sliding after the torque has ended")
            .depending_on(&ASSUMPTIONS),
        PaperRow::claim(
            "single_fastest_wheel_rad_s",
            "350 1/min without load, section 3",
            fastest,
            fastest <= no_load,
        )
        .note(format!(
            "a sliding wheel under 0.13 N m for 0.5 s would pass the printed no-load speed of \
             {no_load} rad/s, where the motor gives no torque: 0.13 N m cannot have been constant"
        ))
        .depending_on(&ASSUMPTIONS),
    ]
}

/// The torque step: its size (N m) and end (s).
fn step(run: &RecordedRun) -> (f64, f64) {
    let open_loop = &run.experiment.settings.open_loop;
    (open_loop.torque_nm, open_loop.torque_for_s)
}

/// The true speed at the last state not after `t_s` (m/s).
fn speed_m_s(run: &RecordedRun, t_s: f64) -> f64 {
    let before = run
        .states(0)
        .take_while(|state| s_from_ns(state.t_ns) <= t_s);
    before.last().map_or(f64::NAN, |state| state.velocity[0])
}

/// How long the right wheel keeps sliding after `t_s` (s), in whole state periods.
fn slip_after_s(run: &RecordedRun, t_s: f64) -> f64 {
    let sliding = run
        .states(0)
        .filter(|state| s_from_ns(state.t_ns) > t_s)
        .take_while(|state| state.slides[0]);
    sliding
        .last()
        .map_or(0.0, |state| s_from_ns(state.t_ns) - t_s)
}
