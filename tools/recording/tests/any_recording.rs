//! Property test: a random recording is bit-identical after a round trip through MCAP.

use std::path::Path;

use proptest::prelude::*;
use slipstream_recording::recording::{Pose, Recording, Robot, Stream, UnknownColumn, Wheels};
use slipstream_recording::{mcap_bytes, read_mcap_from};

/// The number in a cell: any number up to 1e9, or NaN for an empty cell.
fn cell() -> impl Strategy<Value = f64> {
    let plain = -10.0..10.0;
    prop_oneof![
        4 => plain,
        2 => any::<f64>().prop_map(|x| up_to(x, 1e9)),
        1 => Just(f64::NAN),
        1 => Just(-0.0),
    ]
}

/// A number of the same digits that is not larger than `limit`.
fn up_to(x: f64, limit: f64) -> f64 {
    match x.is_finite() {
        true if x.abs() <= limit => x,
        true => 1.0 / x,
        false => limit,
    }
}

/// Times that never decrease: decimal milliseconds, or any that nanoseconds can express.
fn times(rows: usize) -> impl Strategy<Value = Vec<f64>> {
    let round = (0..1_000_000_i32).prop_map(|ms| f64::from(ms) / 1000.0);
    let odd = any::<f64>().prop_map(|x| up_to(x, 9.2e9));
    let sorted = |mut times: Vec<f64>| {
        times.sort_by(f64::total_cmp);
        times
    };
    prop_oneof![
        prop::collection::vec(round, rows).prop_map(sorted),
        prop::collection::vec(odd, rows).prop_map(sorted),
    ]
}

fn recording() -> impl Strategy<Value = Recording> {
    (0..20_usize).prop_flat_map(|rows| {
        let column = || prop::collection::vec(cell(), rows);
        let pose = (times(rows), column(), column(), prop::option::of(column()));
        let ticks = || prop::collection::vec(prop::option::weighted(0.9, any::<i64>()), rows);
        let wheels = (times(rows), ticks(), ticks());
        let texts = prop::option::of(prop::collection::vec(".{0,8}", rows));
        (pose, wheels, texts).prop_map(|(pose, wheels, texts)| {
            let mut robot = Robot::named("r1");
            let (t_s, x_m, y_m, yaw_rad) = pose;
            let unknown = texts.map(|cells| UnknownColumn {
                name: "note".to_owned(),
                cells,
            });
            robot.pose = Some(Stream {
                t_s,
                values: Pose { x_m, y_m, yaw_rad },
                unknown: unknown.into_iter().collect(),
            });
            let (t_s, right, left) = wheels;
            robot.wheels = Some(Stream {
                t_s,
                values: Wheels::Ticks { right, left },
                unknown: Vec::new(),
            });
            Recording {
                robots: vec![robot],
                ..Recording::default()
            }
        })
    })
}

proptest! {
    #[test]
    fn mcap_round_trip_is_bit_identical(recording in recording()) {
        let path = Path::new("any.mcap");
        let bytes = mcap_bytes(&recording, path).unwrap();
        let back = read_mcap_from(&bytes[..], bytes.len() as u64, path).unwrap();
        prop_assert_eq!(&back.warnings, &Vec::<String>::new());
        // `Debug` distinguishes all numbers, the sign of zero, and NaN.
        let text = |recording: &Recording| format!("{:?}", recording.robots);
        prop_assert_eq!(text(&back.recording), text(&recording));
    }
}
