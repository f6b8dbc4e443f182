//! The terms that wheels and a reference can show, with what nobody would call a difference.

use super::drive_terms as drive;
use super::term::{
    CLOCK_TERM, DELAY_TERM, FLOOR, GAIN_TERM, GEOMETRY, GYRO_CLOCK, GYRO_LATE, LAG_TERM, LAW_TERMS,
    OFFSET, OFFSET_TURN, POSE_CLOCK, POSE_LATE, RATE_CAUTION, term,
};
use crate::filter::motion_law::VALUES;
use crate::model::drive::{DEAD_ZONE, LAG, SAG, SATURATION};
use crate::model::from_wheels::{
    ASYMMETRY, COMMON, DRIVE_FIRST, FromWheels, GYRO_LATENCY, GYRO_RATE, LAW_FIRST, MACHINE,
    OFFSET_X, OFFSET_Y, OFFSET_YAW, POSE_LATENCY, POSE_RATE, RUN_SCALE, RUN_TRACK, TRACK,
};
use crate::model::run::Run;
use crate::select::elimination::Term;

/// What the stamp of a row means within a sampling interval is a convention: this share of it.
const STAMP_SHARE: f64 = 0.1;
/// A robot that turns more slowly than this does not show a law of turns (rad/s).
const LEAST_TURN_RAD_S: f64 = 0.02;
/// A robot that is slower than this does not show a law of speed (m/s).
const LEAST_SPEED_M_S: f64 = 5e-3;
/// A turn rate that jumps is integrated late or early by up to this share of the gyro's interval.
const GYRO_STEP_SHARE: f64 = 0.5;
/// A latency of a log wanders more slowly than blocks see.
const LATENCY_CAUTION: f64 = 1.3;
/// Two simulators differ by this much in factors and angles, and in lengths by this share of the half
/// track.
const FACTOR_FLOOR: f64 = 1e-4;
const LENGTH_SHARE: f64 = 1e-3;
/// Wheels that differ by less than this cannot be told from the gyro's own errors.
const GYRO_ASYMMETRY: f64 = 0.004;
/// What recordings of one machine differ by without anybody calling it a change (standard deviations):
/// radii, right against left, track (shares), place of the reference (share of the track) and its yaw,
/// latencies, rates of clocks.
const UNNOTICED_SCALE: f64 = 0.006;
const UNNOTICED_ASYMMETRY: f64 = 0.003;
const UNNOTICED_TRACK: f64 = 0.008;
const UNNOTICED_OFFSET: f64 = 0.02;
const UNNOTICED_YAW_RAD: f64 = 5e-3;
const UNNOTICED_S: f64 = 5e-3;
const UNNOTICED_RATE: f64 = 2e-4;
/// Every term that the streams can show, without effects that are excluded. `by_run`: scale and track
/// are those of each run.
pub(crate) fn terms(machine: &FromWheels, excluded: &[String], by_run: [bool; 2]) -> Vec<Term> {
    let allowed = |effect: &str| !excluded.iter().any(|own| own == effect);
    let mut terms = Vec::new();
    for (effect, term) in sensor_terms(machine) {
        if allowed(effect) {
            terms.push(term);
        }
    }
    let mut geometry: Vec<(usize, f64)> = Vec::new();
    if allowed("wheel_radius") {
        geometry.extend(radii(machine, by_run[0] && allowed("slip_ratio")));
    }
    if allowed("track_width") {
        let tracks = shared_or_of_runs(machine, by_run[1], TRACK, RUN_TRACK);
        geometry.extend(tracks.into_iter().map(|index| (index, FACTOR_FLOOR)));
    }
    let is_floor = |(index, _): &(usize, f64)| machine.before.any() && *index >= MACHINE;
    let (floor, machines): (Vec<_>, Vec<_>) = geometry.into_iter().partition(is_floor);
    for (name, own) in [(FLOOR, floor), (GEOMETRY, machines)] {
        if !own.is_empty() {
            let mut own = term(name, &own, 1.0);
            own.lasting = machine.is_commanded();
            terms.push(own);
        }
    }
    if machine.is_commanded() {
        let drive = drive::terms(DRIVE_FIRST, machine.largest_rad_s(), excluded);
        // a gain and a radius are one where no wheels were recorded, a clock runs against those of
        // the sensors, and a slow response is no effect
        let apart = |t: &Term| ![GAIN_TERM, CLOCK_TERM].contains(&t.name) && !drive::is_nuisance(t);
        let mut drive: Vec<Term> = drive.into_iter().filter(apart).collect();
        if !machine.has_pose() {
            let intervals_s = machine.runs.iter().map(Run::gyro_interval_s);
            let step_s = GYRO_STEP_SHARE * intervals_s.fold(0.0, f64::max);
            let timed = |t: &&mut Term| [DELAY_TERM, LAG_TERM].contains(&t.name);
            for term in drive.iter_mut().filter(timed) {
                term.floors[0] += step_s * step_s;
            }
        }
        terms.extend(drive);
    }
    if machine.before.any() {
        for term in &mut terms {
            term.widen(|index| unnoticed(machine, index));
        }
    }
    terms
}

/// Deviation by which a parameter differs between two recordings of one machine.
fn unnoticed(machine: &FromWheels, index: usize) -> f64 {
    let late_s = |interval_s: fn(&Run) -> f64| {
        let intervals_s = machine.runs.iter().map(interval_s);
        UNNOTICED_S.max(STAMP_SHARE * intervals_s.fold(0.0, f64::max))
    };
    match index {
        COMMON => UNNOTICED_SCALE,
        ASYMMETRY => UNNOTICED_ASYMMETRY,
        TRACK => UNNOTICED_TRACK,
        OFFSET_X | OFFSET_Y => UNNOTICED_OFFSET * 2.0 * machine.half_track_m,
        OFFSET_YAW => UNNOTICED_YAW_RAD,
        POSE_LATENCY => late_s(Run::pose_interval_s),
        GYRO_LATENCY => late_s(|run| run.wheel_interval_s),
        POSE_RATE | GYRO_RATE => UNNOTICED_RATE,
        own if (DRIVE_FIRST..LAW_FIRST).contains(&own) => {
            drive::unnoticed(own - DRIVE_FIRST, machine.largest_rad_s())
        }
        own => {
            // as much as the runs from before differ among themselves
            let [scale, track] = machine.before.spread.map(|own| own.unwrap_or(0.0));
            let scale = (RUN_SCALE, UNNOTICED_SCALE.hypot(scale));
            let track = (RUN_TRACK, UNNOTICED_TRACK.hypot(track));
            let runs = machine.before.runs..machine.runs.len();
            let mut all = runs.flat_map(|run| {
                [scale, track].map(|(parameter, size)| (machine.of_run(run, parameter), size))
            });
            let found = all.find(|(index, _)| *index == own);
            found.map_or(0.0, |(_, size)| size)
        }
    }
}

/// What runs from before and of today share and is fitted with whatever changed: what the streams can
/// show, and what the machine had before.
pub(crate) fn shared(machine: &FromWheels, nominal: &[f64], excluded: &[String]) -> Vec<usize> {
    let later = [
        POSE_RATE,
        GYRO_RATE,
        DRIVE_FIRST + LAG,
        DRIVE_FIRST + DEAD_ZONE,
        DRIVE_FIRST + SATURATION,
        DRIVE_FIRST + SAG,
    ];
    let smooth = terms(machine, excluded, [false; 2]);
    let smooth = smooth.into_iter().filter(|term| !term.by_profile);
    let had = |index: &usize| !later.contains(index) || nominal[machine.shared(*index)] != 0.0;
    let mut all: Vec<usize> = smooth
        .flat_map(|term| term.parameters)
        .filter(had)
        .collect();
    let laws = (0..VALUES.len()).filter(|place| machine.before.laws[*place]);
    all.extend(laws.flat_map(of_law));
    let mut all: Vec<usize> = all.into_iter().map(|i| machine.shared(i)).collect();
    for (spread, own) in machine.before.spread.iter().zip([RUN_SCALE, RUN_TRACK]) {
        if spread.is_some() {
            all.extend((0..machine.before.runs).map(|run| machine.of_run(run, own)));
        }
    }
    all
}

/// Laws of speed over turn rate and over speed: what the catalogue does not have. None over a driver
/// that hardly changes.
pub(crate) fn laws(machine: &FromWheels, excluded: &[String]) -> Vec<Term> {
    let allowed = machine.has_pose() && !excluded.iter().any(|own| own == "motion_law");
    let [w, v] = machine.knots.map(|knots| knots.reach());
    let floor = LENGTH_SHARE * (w * machine.half_track_m).max(v);
    let both = [(w, LEAST_TURN_RAD_S), (v, LEAST_SPEED_M_S)];
    let moved = both.into_iter().zip(LAW_TERMS).enumerate();
    let moved = moved.filter(|(_, ((largest, least), _))| allowed && largest > least);
    moved
        .map(|(place, (_, name))| {
            let own = of_law(place);
            let values: Vec<(usize, f64)> = own.map(|i| (i, floor)).collect();
            let mut law = term(name, &values, 1.0);
            law.lasting = true;
            law
        })
        .collect()
}

/// Parameters of the law over the turn rate (0) or over the speed (1).
fn of_law(place: usize) -> std::ops::Range<usize> {
    let first = LAW_FIRST + place * VALUES[0];
    first..first + VALUES[place]
}

/// Scales of both wheels and their difference, with floors. A gyro alone sees the difference only.
fn radii(machine: &FromWheels, by_run: bool) -> Vec<(usize, f64)> {
    if !machine.has_pose() {
        return vec![(ASYMMETRY, GYRO_ASYMMETRY)];
    }
    let scales = shared_or_of_runs(machine, by_run, COMMON, RUN_SCALE);
    let all = scales.into_iter().chain([ASYMMETRY]);
    all.map(|index| (index, FACTOR_FLOOR)).collect()
}

/// Effects of the sensors and their terms.
fn sensor_terms(machine: &FromWheels) -> Vec<(&'static str, Term)> {
    let stamp_s = |interval_s: fn(&Run) -> f64| {
        let intervals_s = machine.runs.iter().map(interval_s);
        STAMP_SHARE * intervals_s.fold(0.0, f64::max)
    };
    let durations_s = machine
        .runs
        .iter()
        .map(|run| run.blocks.span_s[1] - run.blocks.span_s[0]);
    let duration_s = durations_s.fold(1.0, f64::max);
    let [pose_s, gyro_s] = [
        stamp_s(Run::pose_interval_s),
        stamp_s(|run| run.wheel_interval_s),
    ];
    let length_m = LENGTH_SHARE * machine.half_track_m;
    let mut terms = Vec::new();
    if machine.has_pose() {
        let offset = [(OFFSET_X, length_m), (OFFSET_Y, length_m)];
        terms.push(("pose_offset", term(OFFSET, &offset, 1.0)));
        if !machine.is_commanded() {
            // else a late pose and a late command are one
            let latency = [(POSE_LATENCY, pose_s)];
            terms.push(("pose_latency", term(POSE_LATE, &latency, LATENCY_CAUTION)));
        }
        let rate = [(POSE_RATE, pose_s / duration_s)];
        terms.push(("clock_drift", term(POSE_CLOCK, &rate, RATE_CAUTION)));
    }
    if machine.has_heading() {
        let yaw = [(OFFSET_YAW, FACTOR_FLOOR)];
        terms.push(("pose_offset", term(OFFSET_TURN, &yaw, 1.0)));
    }
    if machine.has_gyro() {
        if machine.has_pose() || !machine.is_commanded() {
            let latency = [(GYRO_LATENCY, gyro_s)];
            terms.push(("imu_latency", term(GYRO_LATE, &latency, LATENCY_CAUTION)));
        }
        let rate = [(GYRO_RATE, gyro_s / duration_s)];
        terms.push(("clock_drift", term(GYRO_CLOCK, &rate, RATE_CAUTION)));
    }
    terms
}

fn shared_or_of_runs(machine: &FromWheels, by_run: bool, shared: usize, own: usize) -> Vec<usize> {
    if by_run {
        (machine.before.runs..machine.runs.len())
            .map(|run| machine.of_run(run, own))
            .collect()
    } else {
        vec![shared]
    }
}
