//! `check` on a synthetic drive without faults, and with one fault at a time.

#![expect(clippy::unwrap_used, reason = "helpers of tests")]

use std::sync::Arc;

use slipstream_bus::RobotModel;
use slipstream_recording::recording::{
    Command, Imu, LinkMessage, Links, Pose, Recording, Robot, Stream, Wheels,
};
use slipstream_recording::{Finding, Report, Severity, check, faults};

const R: f64 = 0.0365;
const B: f64 = 0.105;

fn stream<V>(t_s: Vec<f64>, values: V) -> Stream<V> {
    Stream {
        t_s,
        values,
        unknown: Vec::new(),
    }
}

/// 40 s of forward driving along curves, recorded by all sensors.
fn drive() -> Recording {
    let step = 0.02;
    let (mut x, mut y, mut yaw, mut right, mut left) = (0.0, 0.0, 0.0_f64, 0.0, 0.0);
    let mut columns: [Vec<f64>; 8] = Default::default();
    for i in 0..2000 {
        let t = f64::from(i) * step;
        let v = 0.3 + 0.1 * (0.9 * t).sin();
        let w = 0.8 * (0.5 * t).sin();
        for (column, value) in columns.iter_mut().zip([t, x, y, yaw, right, left, v, w]) {
            column.push(value);
        }
        x += v * yaw.cos() * step;
        y += v * yaw.sin() * step;
        yaw += w * step;
        right += (v + B * w) / R * step;
        left += (v - B * w) / R * step;
    }
    let [t, x_m, y_m, yaw_rad, right_rad, left_rad, v_m_s, w_rad_s] = columns;
    let mut robot = Robot::named("r1");
    let gz_rad_s = Some(w_rad_s.clone());
    robot.command = Some(stream(t.clone(), Command::Twist { v_m_s, w_rad_s }));
    let pose = Pose {
        x_m,
        y_m,
        yaw_rad: Some(yaw_rad),
    };
    robot.pose = Some(stream(t.clone(), pose));
    robot.wheels = Some(stream(
        t.clone(),
        Wheels::Angle {
            right_rad,
            left_rad,
        },
    ));
    robot.imu = Some(stream(
        t,
        Imu {
            gz_rad_s,
            ..Imu::default()
        },
    ));
    Recording {
        robots: vec![robot],
        model: Some(RobotModel::default()),
        ..Recording::default()
    }
}

fn pose(recording: &mut Recording) -> &mut Stream<Pose> {
    recording.robots[0].pose.as_mut().unwrap()
}

fn wheels(recording: &mut Recording) -> (&mut Vec<f64>, &mut Vec<f64>) {
    match &mut recording.robots[0].wheels.as_mut().unwrap().values {
        Wheels::Angle {
            right_rad,
            left_rad,
        } => (right_rad, left_rad),
        _ => unreachable!(),
    }
}

fn scale(values: &mut [f64], by: f64) {
    values.iter_mut().for_each(|value| *value *= by);
}

/// Scales the angles of both wheels.
fn scale_both(recording: &mut Recording, by: f64) {
    let (right, left) = wheels(recording);
    scale(right, by);
    scale(left, by);
}

#[test]
fn a_clean_drive_has_no_findings() {
    let report = check(&drive(), None);
    assert_eq!(report.findings, []);
    assert!(report.can_judge.iter().any(|what| what.contains("slip")));
    let stream = &report.robots[0].streams[0];
    assert_eq!((stream.rows, stream.gaps_s.len()), (2000, 0));
    assert!((stream.rate_hz.unwrap() - 50.0).abs() < 1e-6);
}

/// Runs of one machine are judged together: in one of them the right side drags the left one backwards.
#[test]
fn a_wheel_that_is_dragged_backwards_in_one_run_is_not_reversed() {
    let of_sides = |left: [f64; 3]| {
        let mut recording = drive();
        recording.same_robot = true;
        recording.robots = (0..3)
            .map(|run| {
                let mut own = drive();
                scale(wheels(&mut own).1, left[run]);
                let mut robot = own.robots.remove(0);
                robot.name = format!("run{run}");
                robot
            })
            .collect();
        let errors = |findings: Vec<Finding>| {
            let errors = findings.into_iter();
            let errors = errors.filter(|f| f.severity == Severity::Error);
            errors.map(|f| f.id.into_owned()).collect::<Vec<String>>()
        };
        let of_one = errors(check(&recording, None).findings);
        // the same runs in recordings of their own
        let each: Vec<Recording> = std::mem::take(&mut recording.robots)
            .into_iter()
            .map(|mut robot| {
                robot.name = "r1".to_owned();
                Recording {
                    robots: vec![robot],
                    same_robot: false,
                    ..recording.clone()
                }
            })
            .collect();
        let of_each = errors(faults(&each, &|_| None).into_iter().flatten().collect());
        assert_eq!(of_one, of_each);
        of_one
    };
    assert_eq!(of_sides([1.0, -0.5, 1.0]), Vec::<String>::new());
    // the control: in all of them, and it is the encoder
    assert!(of_sides([-1.0; 3]).contains(&"wheel_reversed".to_owned()));
}

/// A diagnosis measures a scale of the wheels: it is no error.
#[test]
fn encoders_that_count_by_a_known_factor_are_a_warning_with_its_cause() {
    for (factor, words) in [
        (
            180.0 / std::f64::consts::PI,
            "wheels's angles are in degrees",
        ),
        (4.0, "quadrature x4"),
        (0.5, "a diameter in place of a radius"),
        (1.0 / 360.0, "in turns where degrees"),
    ] {
        let mut recording = drive();
        scale_both(&mut recording, factor);
        let report = check(&recording, None);
        let [found] = &report.findings[..] else {
            panic!("{words}: {report}");
        };
        assert_eq!(
            (&*found.id, found.severity),
            ("wheel_scale", Severity::Warning)
        );
        assert!(found.statement.contains(words), "{report}");
    }
}

#[test]
fn each_fault_is_found_under_its_id() {
    type Fault = fn(&mut Recording);
    let cases: [(&str, &str, Fault); 9] = [
        ("units", "yaw is in degrees", |r| {
            scale(
                pose(r).values.yaw_rad.as_mut().unwrap(),
                180.0 / std::f64::consts::PI,
            );
        }),
        ("units", "pose is in mm", |r| {
            scale(&mut pose(r).values.x_m, 1000.0);
            scale(&mut pose(r).values.y_m, 1000.0);
        }),
        ("units", "gyro is in degrees", |r| {
            let imu = r.robots[0].imu.as_mut().unwrap();
            scale(
                imu.values.gz_rad_s.as_mut().unwrap(),
                180.0 / std::f64::consts::PI,
            );
        }),
        ("wheels_swapped", "right and left wheel are swapped", |r| {
            let (right, left) = wheels(r);
            std::mem::swap(right, left);
        }),
        ("wheel_reversed", "the left wheel counts backwards", |r| {
            scale(wheels(r).1, -1.0)
        }),
        ("wheel_reversed", "the right wheel counts backwards", |r| {
            scale(wheels(r).0, -1.0)
        }),
        ("wheels_reversed", "both wheels count backwards", |r| {
            scale_both(r, -1.0)
        }),
        (
            "opposite_signs",
            "pose and gyro have opposite yaw rates",
            |r| {
                let imu = r.robots[0].imu.as_mut().unwrap();
                scale(imu.values.gz_rad_s.as_mut().unwrap(), -1.0);
            },
        ),
        ("no_overlap", "hardly overlap", |r| {
            pose(r).t_s.iter_mut().for_each(|t_s| *t_s += 1.7e9);
        }),
    ];
    for (id, words, add_fault) in cases {
        let mut recording = drive();
        add_fault(&mut recording);
        let report = check(&recording, None);
        let found = report
            .findings
            .iter()
            .find(|f| f.id == id && f.statement.contains(words));
        let found = found.unwrap_or_else(|| panic!("{words}: {report}"));
        assert_eq!(found.severity, Severity::Error);
        // Findings of other kinds follow from the same fault.
        let others = report
            .findings
            .iter()
            .filter(|f| f.id != id && f.severity == Severity::Error);
        let others: Vec<&str> = others.map(|f| &*f.id).collect();
        assert!(
            others.iter().all(|id| *id == "opposite_signs"),
            "{words}: {others:?}"
        );
    }
}

#[test]
fn lags_gaps_and_messages_from_the_future_are_found() {
    let mut recording = drive();
    pose(&mut recording)
        .t_s
        .iter_mut()
        .for_each(|t_s| *t_s += 0.15);
    recording.robots[0].command.as_mut().unwrap().t_s[1000..]
        .iter_mut()
        .for_each(|t| *t += 2.0);
    let message = |t_sent_s: f64, delay_s: f64| LinkMessage {
        t_sent_s,
        t_received_s: Some(t_sent_s + delay_s),
        from: Arc::from("r9"),
        to: Arc::from("r1"),
        x_m: 0.0,
        y_m: 0.0,
        yaw_rad: 0.0,
        v_m_s: f64::NAN,
        w_rad_s: f64::NAN,
    };
    recording.links = Some(Links {
        messages: vec![message(0.0, 0.1), message(1.0, -0.1)],
        ..Links::default()
    });
    let report = check(&recording, None);
    let assert_found = |id: &str, words: &str| {
        let found = report
            .findings
            .iter()
            .any(|f| f.id == id && f.statement.contains(words));
        assert!(found, "{id}: {report}");
    };
    let mut milliseconds = drive();
    pose(&mut milliseconds)
        .t_s
        .iter_mut()
        .for_each(|t_s| *t_s *= 1000.0);
    let found = check(&milliseconds, None).findings;
    assert!(
        found.iter().any(|f| f.remedy.contains("milliseconds")),
        "{found:?}"
    );
    assert_found("lag", "the pose is about 0.15 s behind the wheels");
    assert_found("gaps", "command pauses once, for 2.02 s");
    assert_found(
        "negative_latency",
        "1 of 2 messages from r9 arrive before they were sent",
    );
    assert_found("unknown_sender", "r9");
}

#[test]
fn the_report_reads_back_from_its_json() {
    let mut recording = drive();
    let (right, left) = wheels(&mut recording);
    std::mem::swap(right, left);
    // serde_json parses numbers of more than 15 digits only to within rounding, unless its feature
    // `float_roundtrip` is on: steps of 1/64 s have few digits.
    let robot = &mut recording.robots[0];
    let times = [
        &mut robot.command.as_mut().unwrap().t_s,
        &mut robot.pose.as_mut().unwrap().t_s,
        &mut robot.wheels.as_mut().unwrap().t_s,
        &mut robot.imu.as_mut().unwrap().t_s,
    ];
    for t_s in times {
        for (i, t_s) in t_s.iter_mut().enumerate() {
            *t_s = i as f64 / 64.0;
        }
    }
    let report = check(&recording, None);
    assert!(report.findings.iter().any(|f| f.id == "wheels_swapped"));
    let json = serde_json::to_string(&report).unwrap();
    let back: Report = serde_json::from_str(&json).unwrap();
    assert_eq!(back, report);
    assert_eq!(serde_json::to_string(&back).unwrap(), json);
}
