//! References that see a robot before and after each drive alone: a tape measure, a scan that needs the robot to
//! stand.

mod common;

use slipstream_recording::Recording;
use slipstream_recording::recording::Robot;

use common::{diagnosed, noise, recording};

const RADIUS_M: f64 = 0.04;
const HALF_TRACK_M: f64 = 0.12;
/// What is true of the nominal sizes.
const RADIUS_SCALE: f64 = 1.025;
const TRACK_SCALE: f64 = 1.07;
const DRIVES: u32 = 12;
const DRIVE_S: f64 = 8.0;

/// A drive on an arc: wheels at 20 Hz, one pose at its begin and one at its end, with 2 mm and 3 mrad.
fn drive(number: u32) -> Robot {
    let k = f64::from(number);
    let noise = |part: f64| noise(k + part);
    let (v, w) = (0.2 + 0.01 * k, 0.3 * (1.7 * k).sin());
    let [right, left] = [1.0, -1.0].map(|side| {
        let rim_m_s = v + side * TRACK_SCALE * HALF_TRACK_M * w;
        rim_m_s / (RADIUS_SCALE * RADIUS_M)
    });
    let mut columns: [Vec<f64>; 10] = Default::default();
    for row in 0..=(DRIVE_S * 20.0) as u32 {
        let t_s = f64::from(row) / 20.0;
        let cells = columns[3..6].iter_mut().zip([t_s, right * t_s, left * t_s]);
        cells.for_each(|(column, value)| column.push(value));
    }
    for (part, t_s) in [(0.1, 0.0), (0.5, DRIVE_S)] {
        let turned = w * t_s;
        // the chord of an arc
        let way = if turned.abs() > 1e-9 {
            v * t_s * (turned / 2.0).sin() / (turned / 2.0)
        } else {
            v * t_s
        };
        let pose = [
            t_s,
            way * (turned / 2.0).cos() + 2e-3 * noise(part),
            way * (turned / 2.0).sin() + 2e-3 * noise(part + 0.1),
            turned + 3e-3 * noise(part + 0.2),
        ];
        let cells = columns[6..].iter_mut().zip(pose);
        cells.for_each(|(column, value)| column.push(value));
    }
    let mut robot = recording("", columns).robots.remove(0);
    robot.command = None;
    robot.name = format!("drive{number}");
    robot
}

#[test]
fn two_poses_a_drive_tell_the_sizes_of_the_robot() {
    let recording = Recording {
        name: "sparse".to_owned(),
        same_robot: true,
        robots: (0..DRIVES).map(drive).collect(),
        ..Recording::default()
    };
    let nominal = slipstream_testkit::kinematic(RADIUS_M, HALF_TRACK_M);
    let (answer, _) = diagnosed(recording, &nominal).unwrap();
    let of = |effect: &str| {
        let found = answer.findings.iter().find(|own| own.effect == effect);
        let first = found.and_then(|own| own.parameters.first());
        first.and_then(|own| own.estimate)
    };
    // 2 mm at both ends of 1.6 to 2.5 m, twelve times: 0.04 %; 3 mrad at turns of up to 2.4 rad: 0.1 %
    let radius = of("wheel_radius").unwrap();
    assert!((radius - RADIUS_SCALE).abs() < 2e-3, "{radius}");
    let track = of("track_width").unwrap();
    assert!((track - TRACK_SCALE).abs() < 5e-3, "{track}");
}
