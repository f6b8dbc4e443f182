//! Logs of SysId, the drivetrain characterisation of WPILib.

use std::f64::consts::TAU;

use slipstream_recording::recording::{Command, Wheels};
use slipstream_recording::{draft_map, read};

const LOG: &str = r#"{
  "fast-backward": [],
  "fast-forward": [[2.0, 7, 7.5, 1, 2, 10, 20, 0.1, 0.25], [2.02, 7, 7.5, 1.5, 2.5, 10, 20, 0.2, 0.5]],
  "slow-forward": [[1.0, 0.1, 0.2, 0, 0.5, 0, 0, 0, 0], [1.02, 0.1, 0.2, 0, 0.5, 0, 0, 0, 0]],
  "sysid": true, "test": "Drivetrain", "units": "Meters", "unitsPerRotation": 0.5
}"#;

#[test]
fn runs_are_robots_of_one_machine() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("sysid_data20240501-120000.json");
    std::fs::write(&file, LOG).unwrap();
    let import = read(&file).unwrap();
    assert!(import.recording.same_robot);
    let names: Vec<&str> = import
        .recording
        .robots
        .iter()
        .map(|robot| robot.name.as_str())
        .collect();
    assert_eq!(names, ["fast-forward", "slow-forward"]);
    let fast = import.recording.robot("fast-forward").unwrap();
    let command = fast.command.as_ref().unwrap();
    assert_eq!(command.t_s, [2.0, 2.02]);
    let Command::Voltage { right_v, left_v } = &command.values else {
        unreachable!("voltages");
    };
    assert_eq!((right_v[1], left_v[1]), (7.5, 7.0));
    let Wheels::Angle {
        right_rad,
        left_rad,
    } = &fast.wheels.as_ref().unwrap().values
    else {
        unreachable!("angles");
    };
    assert_eq!((right_rad[1], left_rad[1]), (2.5 * TAU, 1.5 * TAU));
    assert_eq!(
        fast.imu.as_ref().unwrap().values.gz_rad_s.as_ref().unwrap(),
        &[0.25, 0.5]
    );
    // The robot stood, or had no gyro.
    assert!(
        import
            .recording
            .robot("slow-forward")
            .unwrap()
            .imu
            .is_none()
    );
    let warnings = import.warnings.join("\n");
    assert!(
        warnings.contains("run fast-backward: left out, since it has no rows"),
        "{warnings}"
    );
    assert!(
        import.guesses[0].contains("rotations of the wheels"),
        "{:?}",
        import.guesses
    );
    assert!(
        import.on_model[0].contains("wheel_radius_m = 0.0795774"),
        "{:?}",
        import.on_model
    );
    assert!(
        draft_map(&file, &[])
            .unwrap_err()
            .to_string()
            .contains("needs no map")
    );
}

#[test]
fn rows_of_ten_numbers_have_no_rate() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("old.json");
    let text = r#"{"slow-forward": [[1, 12.5, 0.5, 3, 4, 0.25, 0.75, 0, 0, 0.1]], "test": "Drivetrain",
                   "units": "Rotations", "unitsPerRotation": 1}"#;
    std::fs::write(&file, text).unwrap();
    let import = read(&file).unwrap();
    let run = &import.recording.robots[0];
    assert!(
        matches!(&run.command.as_ref().unwrap().values, Command::Voltage { right_v, .. } if right_v == &[4.0])
    );
    assert!(
        matches!(&run.wheels.as_ref().unwrap().values, Wheels::Angle { left_rad, .. } if left_rad == &[0.25 * TAU])
    );
    assert!(run.imu.is_none() && import.on_model.is_empty());
}

#[test]
fn what_is_wrong_is_one_line() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("log.json");
    let cases = [
        (
            LOG.replace("Drivetrain", "Arm"),
            "is of the mechanism \"Arm\"",
        ),
        (
            LOG.replace("unitsPerRotation", "perRotation"),
            "no log of SysId",
        ),
        (
            LOG.replace("[2.0, 7,", "[2.0,"),
            "row 1 of \"fast-forward\" is not a row of nine numbers",
        ),
        (
            LOG.replace("[2.0, 7,", "[2.0, 1e300,"),
            "run fast-forward has voltage_left_v = 1",
        ),
        (LOG.replace("2.02, 7", "2.02 7"), "log.json:3: is not JSON"),
        (
            r#"{"test": "Drivetrain", "units": "Meters", "unitsPerRotation": 1}"#.to_owned(),
            "has no run with rows",
        ),
    ];
    for (text, expected) in cases {
        std::fs::write(&file, text).unwrap();
        let error = read(&file).unwrap_err().to_string();
        assert!(error.contains(expected) && !error.contains('\n'), "{error}");
    }
}
