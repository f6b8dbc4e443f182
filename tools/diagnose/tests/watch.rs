//! A watch over a simulated robot: nothing is raised while nothing changes, and what changes is named soon.
#![expect(
    clippy::unwrap_used,
    clippy::panic,
    reason = "a test that cannot go on says so and stops"
)]

#[expect(dead_code, reason = "shared with tests of the diagnosis")]
mod common;
mod course;

use std::time::Instant;

use slipstream_diagnose::{Change, Event, Request, State, Watch};

use course::{Course, HALF_TRACK_M, Other, RADIUS_M, SAME};

/// Length of the baseline and of a piece (s).
const BASELINE_S: f64 = 40.0;
const PIECE_S: f64 = 0.5;

/// A watch over a robot like that with this seed.
fn watch(seed: u64) -> Watch {
    let nominal = slipstream_testkit::kinematic(RADIUS_M, HALF_TRACK_M);
    let baseline = [Course::new(seed).rows(BASELINE_S)];
    let request = Request {
        recordings: &baseline,
        against: &[],
        model_of: &|_| Some(nominal.clone()),
        excluded: &[],
        excluded_s: &[],
        progress: &|_| (),
    };
    Watch::new(&request).unwrap()
}

/// The changes that are raised within so many seconds.
fn raised(watch: &mut Watch, course: &mut Course, span_s: f64) -> Vec<Change> {
    let pieces = (span_s / PIECE_S).round() as u64;
    let events = (0..pieces).flat_map(|_| watch.hear(&course.rows(PIECE_S)));
    let changes = events.filter_map(|event| match event {
        Event::Change(own) if own.state == State::Raised => Some(*own),
        _ => None,
    });
    changes.collect()
}

/// What is raised after a change that begins after a minute and a third: by what it is called at last.
fn named(other: Other, seed: u64) -> (Change, f64, f64) {
    let mut watch = watch(seed);
    let mut course = Course::new(seed + 1000);
    assert!(
        raised(&mut watch, &mut course, 80.0).is_empty(),
        "raised too early"
    );
    course.other = other;
    let (begin_s, begin_m) = (course.now_s(), course.way_m);
    for _ in 0..120 {
        let own = raised(&mut watch, &mut course, PIECE_S);
        if let Some(first) = own.first() {
            let (delay_s, way_m) = (course.now_s() - begin_s, course.way_m - begin_m);
            let later = raised(&mut watch, &mut course, 12.0);
            let last = later
                .into_iter()
                .next_back()
                .unwrap_or_else(|| first.clone());
            return (last, delay_s, way_m);
        }
    }
    panic!("{other:?} was never raised");
}

#[test]
fn nothing_is_raised_while_nothing_changes() {
    let found = nothing(1, 600.0);
    assert!(found.is_empty(), "{found:?}");
}

/// What is raised in so many seconds, of a robot with another course than that of the baseline: when, since when, what, and
/// by which gain (nats).
fn nothing(seed: u64, span_s: f64) -> Vec<(f64, f64, String, f64)> {
    let mut watch = watch(seed);
    let mut course = Course::new(seed + 1000);
    let found = raised(&mut watch, &mut course, span_s);
    found
        .into_iter()
        .map(|own| {
            let gain = own.finding.evidence.log_likelihood_gain;
            (own.t_s, own.onset_s, own.finding.effect, gain)
        })
        .collect()
}

/// Ten hours of it, from five baselines: `just watch`.
#[test]
#[ignore = "a minute of computing"]
fn nothing_is_raised_in_ten_hours() {
    let hours = (1..=5).map(|seed| nothing(seed, 7200.0));
    let found: Vec<Vec<_>> = hours.collect();
    let counts: Vec<usize> = found.iter().map(Vec::len).collect();
    println!("false alarms in 10 h, two hours of each baseline: {counts:?}");
    let few = found.iter().flatten().take(10).collect::<Vec<_>>();
    assert!(
        counts.iter().sum::<usize>() <= 3,
        "{counts:?}, the first are {few:?}"
    );
}

#[test]
fn a_smaller_wheel_is_named_soon() {
    let other = Other {
        radii: [0.92, 1.0],
        ..SAME
    };
    let (change, delay_s, way_m) = named(other, 3);
    assert_eq!(change.finding.effect, "wheel_radius");
    assert!(delay_s <= 3.0 || way_m <= 2.0, "{delay_s} s, {way_m} m");
    assert!((change.onset_s - 80.0).abs() <= 1.0, "{}", change.onset_s);
}

#[test]
fn weaker_motors_are_named_soon() {
    let other = Other { gain: 0.9, ..SAME };
    let (change, delay_s, _) = named(other, 4);
    assert_eq!(change.finding.effect, "motor_gain");
    assert!(delay_s <= 3.0, "{delay_s} s");
    assert!((change.onset_s - 80.0).abs() <= 1.0, "{}", change.onset_s);
}

#[test]
fn late_poses_are_named() {
    let other = Other {
        late_s: 0.15,
        ..SAME
    };
    let (change, ..) = named(other, 5);
    assert_eq!(change.finding.effect, "pose_latency");
}

/// Resident memory of this process (MB).
fn resident_mb() -> f64 {
    let pages = std::fs::read_to_string("/proc/self/statm").unwrap_or_default();
    let mut numbers = pages
        .split_whitespace()
        .filter_map(|own| own.parse::<f64>().ok());
    numbers.nth(1).unwrap_or(0.0) * 4096.0 / 1e6
}

/// A day of one robot, heard as fast as it goes: memory, and how much faster than the robot drives: `just watch`.
#[test]
#[ignore = "some minutes of computing"]
fn memory_is_flat_over_a_day() {
    let mut watch = watch(1);
    let mut course = Course::new(7);
    let (mut after_an_hour, mut heard) = (0.0, std::time::Duration::ZERO);
    for hour in 1..=24 {
        for _ in 0..7200 {
            let rows = course.rows(PIECE_S);
            let began = Instant::now();
            watch.hear(&rows);
            heard += began.elapsed();
        }
        if hour == 1 {
            after_an_hour = resident_mb();
        }
    }
    let (now, speed) = (resident_mb(), 86_400.0 / heard.as_secs_f64());
    println!(
        "memory after an hour {after_an_hour:.1} MB, after a day {now:.1} MB; {speed:.0} times as fast as the robot"
    );
    assert!(
        now < after_an_hour + 5.0,
        "{after_an_hour} MB, then {now} MB"
    );
}
