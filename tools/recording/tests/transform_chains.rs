//! Poses along several transforms, against motions that are known in closed form.

#![expect(clippy::unwrap_used, clippy::panic, reason = "helpers of tests")]

#[path = "external/python.rs"]
mod python;

use std::path::{Path, PathBuf};

use slipstream_recording::recording::{Pose, Stream};
use slipstream_recording::{Import, Map, TopicMap, draft_map, read, read_mapped};

/// The bags, if there is a Python environment.
fn bags() -> Option<(tempfile::TempDir, PathBuf)> {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("bags");
    python::script("write_chains.py", &[&out])?;
    Some((folder, out))
}

/// Reads a bag with this pose in a map.
fn with_pose(bag: &Path, pose: &str) -> slipstream_recording::Result<Import> {
    let text = format!("format = 1\n[robots.r1]\npose = {pose}\n");
    let map = TopicMap::parse(&text, Path::new("map.toml")).unwrap();
    read_mapped(bag, &Map::Topics(map))
}

fn pose(import: &Import) -> &Stream<Pose> {
    import.recording.robots[0].pose.as_ref().unwrap()
}

/// x, y and yaw within the frame `outer`, given in an inner one.
fn placed(outer: [f64; 3], inner: [f64; 3]) -> [f64; 3] {
    let (sine, cosine) = outer[2].sin_cos();
    [
        outer[0] + cosine * inner[0] - sine * inner[1],
        outer[1] + sine * inner[0] + cosine * inner[1],
        outer[2] + inner[2],
    ]
}

/// The circle of the writer.
fn on_circle(t_s: f64) -> [f64; 3] {
    let (sine, cosine) = (t_s / 2.0).sin_cos();
    [2.0 * sine, 2.0 - 2.0 * cosine, t_s / 2.0]
}

fn assert_pose(import: &Import, row: usize, [x_m, y_m, yaw_rad]: [f64; 3]) {
    let pose = &pose(import).values;
    let yaw = pose.yaw_rad.as_ref().unwrap()[row];
    let turn = (yaw - yaw_rad) / std::f64::consts::TAU;
    let errors = [
        pose.x_m[row] - x_m,
        pose.y_m[row] - y_m,
        turn - turn.round(),
    ];
    assert!(
        errors.iter().all(|error| error.abs() < 1e-7),
        "{row}: {errors:?}"
    );
}

#[test]
fn a_localisation_is_composed_where_it_changes() {
    let Some((_folder, out)) = bags() else { return };
    let map = "{ topic = \"/tf\", parent = \"map\", frame = \"base_link\" }";
    for import in [
        with_pose(&out.join("localised"), map).unwrap(),
        read(&out.join("localised")).unwrap(),
        read(&out.join("with_world")).unwrap(),
    ] {
        let times = &pose(&import).t_s;
        assert_eq!(times.len(), 10, "{:?}", import.warnings);
        for k in 0..10 {
            let t_s = k as f64 + 0.007;
            assert!((times[k] - t_s).abs() < 1e-9, "{times:?}");
            let correction = [1.0 + 0.1 * k as f64, -0.5, 0.02 * k as f64];
            assert_pose(&import, k, placed(correction, on_circle(t_s)));
        }
        let warnings = import.warnings.join("\n");
        let note = "/pose: composed of map to odom and odom to base_link; 10 rows, 1.0 per second, one where map to odom \
                    changes: a localisation";
        assert!(warnings.contains(note), "{warnings}");
    }
    let draft = draft_map(&out.join("localised"), &[]).unwrap();
    assert!(
        draft.contains("# robot/pose: composed of map to odom and odom to base_link\n"),
        "{draft}"
    );
}

/// A correction holds for some time to come, but its measurement is not later than its reception.
#[test]
fn a_stamp_ahead_of_its_reception_is_that_of_the_reception() {
    let Some((_folder, out)) = bags() else { return };
    let import = read(&out.join("ahead")).unwrap();
    let warnings = import.warnings.join("\n");
    assert!(
        warnings.contains("its stamps lie up to 0.90 s ahead"),
        "{warnings}"
    );
    assert_eq!(pose(&import).t_s.len(), 10);
    assert!((pose(&import).t_s[3] - 3.007).abs() < 1e-9);
    let correction = [1.3, -0.5, 0.06];
    assert_pose(&import, 3, placed(correction, on_circle(3.007)));
}

#[test]
fn a_marker_is_moved_to_the_base_by_a_static_transform() {
    let Some((_folder, out)) = bags() else { return };
    let map = "{ topic = \"/tf\", parent = \"world\", frame = \"base_link\" }";
    for import in [
        with_pose(&out.join("captured"), map).unwrap(),
        read(&out.join("captured")).unwrap(),
    ] {
        let times = &pose(&import).t_s;
        assert_eq!(times.len(), 1001, "{:?}", import.warnings);
        for row in [0, 333, 1000] {
            let t_s = row as f64 * 0.01 + 0.003;
            let base = [-0.2, 0.1, std::f64::consts::FRAC_PI_2];
            assert_pose(&import, row, placed(on_circle(t_s), base));
        }
        let warnings = import.warnings.join("\n");
        assert!(
            warnings.contains("marker to base_link (which never moves)"),
            "{warnings}"
        );
        // The stamp of 0 belongs to no measurement.
        assert!(!warnings.contains("stamps are 0"), "{warnings}");
        assert!(!import.left_out.contains_key("/tf_static"));
    }
}

#[test]
fn the_inverse_of_a_transform_leads_back() {
    let Some((_folder, out)) = bags() else { return };
    let map = "{ topic = \"/tf\", parent = \"base_link\", frame = \"world\" }";
    let import = with_pose(&out.join("captured"), map).unwrap();
    let world = pose(&import).values.clone();
    let yaw_rad = world.yaw_rad.unwrap()[500];
    let world = [world.x_m[500], world.y_m[500], yaw_rad];
    let base = [-0.2, 0.1, std::f64::consts::FRAC_PI_2];
    let there = placed(placed(on_circle(5.003), base), world);
    assert!(there[0].hypot(there[1]) < 1e-7, "{there:?}");
}

#[test]
fn odometry_alone_is_no_reference() {
    let Some((_folder, out)) = bags() else { return };
    for name in ["odometry", "constant"] {
        let import = read(&out.join(name)).unwrap();
        assert!(import.recording.robots[0].pose.is_none(), "{name}");
    }
}

#[test]
fn frames_without_a_way_between_them_are_an_error_with_those_there_are() {
    let Some((_folder, out)) = bags() else { return };
    let error = |name: &str, parent: &str| {
        let map = format!("{{ topic = \"/tf\", parent = \"{parent}\", frame = \"base_link\" }}");
        match with_pose(&out.join(name), &map) {
            Ok(_) => panic!("{name} has a pose"),
            Err(error) => error.to_string(),
        }
    };
    let missing = error("localised", "world");
    assert!(
        missing.ends_with(
            "/tf has no transforms that lead from world to base_link for pose; name a parent and a frame between which \
             these lead: map to odom, odom to base_link"
        ),
        "{missing}"
    );
    let fixed = error("captured", "marker");
    assert!(
        fixed.contains("nothing moves between marker and base_link"),
        "{fixed}"
    );
}
