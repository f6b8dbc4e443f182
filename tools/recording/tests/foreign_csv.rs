//! CSV files of other programs, read with a map of their columns.

#![expect(clippy::unwrap_used, reason = "helpers of tests")]

use std::path::Path;

use slipstream_recording::recording::Wheels;
use slipstream_recording::{ColumnMap, Map, draft_map, read, read_mapped};

/// One log with everything, in other units: milliseconds since 1970, millimetres, degrees; poses in every second row.
const LOG: &str = "time_ms;enc_l;enc_r;X;Y;heading\n\
    1700000000000.5;100;200;;;\n\
    1700000000050.5;110;220;1500;-20;90\n\
    1700000000100.5;120;240;NaN;NaN;NaN\n\
    1700000000150.5;130;260;1600;-20;180\n";

const MAP: &str = "format = 1\n[robots.cart]\nencoder_counts_per_rev = 1024\n[robots.cart.wheels]\nfile = \"log.csv\"\n\
    separator = \";\"\nt_s = { column = \"time_ms\", factor = 0.001 }\nticks_right = \"enc_r\"\nticks_left = \"enc_l\"\n\
    [robots.cart.pose]\nfile = \"log.csv\"\nseparator = \";\"\nt_s = { column = \"time_ms\", factor = 0.001 }\n\
    x_m = { column = \"X\", factor = 0.001 }\ny_m = { column = \"Y\", factor = 0.001, offset = 1 }\n\
    yaw_rad = { column = \"heading\", factor = 0.017453292519943295 }\n";

fn map(text: &str) -> Map {
    Map::Columns(ColumnMap::parse(text, Path::new("map.toml")).unwrap())
}

#[test]
fn names_units_and_streams_are_as_the_map_says() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("log.csv"), LOG).unwrap();
    let import = read_mapped(folder.path(), &map(MAP)).unwrap();
    let robot = import.recording.robot("cart").unwrap();
    assert_eq!(robot.encoder_counts_per_rev, Some(1024.0));
    let wheels = robot.wheels.as_ref().unwrap();
    let expected = [0.0, 0.05, 0.1, 0.15];
    let near = |a: &[f64], b: &[f64]| a.iter().zip(b).all(|(a, b)| (a - b).abs() < 1e-12);
    assert!(near(&wheels.t_s, &expected), "{:?}", wheels.t_s);
    let Wheels::Ticks { right, left } = &wheels.values else {
        unreachable!("the map names ticks");
    };
    assert_eq!((right[3], left[0]), (Some(260), Some(100)));
    let pose = robot.pose.as_ref().unwrap();
    assert!(near(&pose.t_s, &[0.05, 0.15]), "{:?}", pose.t_s);
    assert!(near(&pose.values.x_m, &[1.5, 1.6]));
    assert!(near(&pose.values.y_m, &[0.98, 0.98]));
    let yaw_rad = pose.values.yaw_rad.as_ref().unwrap();
    assert_eq!(yaw_rad[1], std::f64::consts::PI);

    // One file is a recording, too.
    let file = folder.path().join("log.csv");
    assert!(read_mapped(&file, &map(MAP)).is_ok());
}

#[test]
fn a_file_without_header_is_read_by_numbers() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("camera.txt");
    std::fs::write(&file, "5,1,2\n4,3,4\n").unwrap();
    let text = "format = 1\n[robots.r1.pose]\nheader = false\nt_s = 1\nx_m = 2\ny_m = 3\n";
    let import = read_mapped(&file, &map(text)).unwrap();
    let pose = import.recording.robots[0].pose.as_ref().unwrap();
    // Sorted by time, with a warning.
    assert_eq!((pose.t_s[1], pose.values.x_m[0]), (1.0, 3.0));
    assert_eq!(import.warnings.len(), 1);
}

#[test]
fn without_a_map_or_with_a_wrong_one_it_says_what_to_do() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("log.csv");
    std::fs::write(&file, LOG).unwrap();
    std::fs::write(&file, LOG.replace("enc_", "e").replace(";X;", ";P;")).unwrap();
    let error = read(folder.path()).unwrap_err().to_string();
    assert!(error.contains("--write-columns"), "{error}");
    std::fs::write(&file, LOG).unwrap();
    // The draft is a map.
    let draft = draft_map(&file, &[]).unwrap();
    assert!(
        ColumnMap::parse(&draft, Path::new("map.toml")).is_ok(),
        "{draft}"
    );

    let cases = [
        (
            "\"enc_r\"",
            "\"enc\"",
            "has no column enc; name one of: time_ms",
        ),
        ("\"log.csv\"", "\"lag.csv\"", "lag.csv"),
        (
            "separator = \";\"",
            "separator = \",\"",
            "has no column time_ms",
        ),
        (
            "\"enc_r\"",
            "{ column = \"enc_r\", factor = 0.33 }",
            "which is no whole number",
        ),
        (
            "\"heading\", factor = 0.017453292519943295",
            "\"heading\", factor = 1e10",
            "log.csv:3: yaw_rad is",
        ),
    ];
    for (from, to, expected) in cases {
        let text = MAP.replace(from, to);
        let error = read_mapped(folder.path(), &map(&text))
            .unwrap_err()
            .to_string();
        assert!(error.contains(expected) && !error.contains('\n'), "{error}");
    }
    let cases = [
        (
            LOG.replace("1500;-20;90", "12:30;-20;90"),
            "log.csv:3: column X has \"12:30\"",
        ),
        (
            LOG.replace(";1500;-20;90", ""),
            "has no column 4 in this row",
        ),
        (LOG.replace("1700000000050.5", ""), "log.csv:3: has no time"),
        (
            LOG.replace("1500;-20", ";").replace("1600;-20", ";"),
            "has no value for x_m, y_m",
        ),
        (
            "time_ms;enc_l;enc_r;X;Y;heading\n".to_owned(),
            "has no row for cart/wheels",
        ),
    ];
    for (text, expected) in cases {
        std::fs::write(&file, text).unwrap();
        let error = read_mapped(folder.path(), &map(MAP))
            .unwrap_err()
            .to_string();
        assert!(error.contains(expected) && !error.contains('\n'), "{error}");
    }
}
