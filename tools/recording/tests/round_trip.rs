//! Round trips through the in-memory form, a folder and an MCAP file: nothing changes, bit for bit.
//!
//! Uses the example recording of the repository and, if they exist, the recordings in `../shared`.

#![expect(clippy::unwrap_used, reason = "helpers of tests")]

use std::path::{Path, PathBuf};

use slipstream_recording::{read, read_folder, write_folder, write_mcap};

/// Folders with a `recording.toml`, sorted.
fn recordings() -> Vec<PathBuf> {
    let repository = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
    let shared = repository.join("../shared");
    let mut folders: Vec<PathBuf> = ["recordings", "practice"]
        .iter()
        .filter_map(|kind| std::fs::read_dir(shared.join(kind)).ok())
        .flatten()
        .filter_map(|entry| Some(entry.ok()?.path()))
        .filter(|path| path.join("recording.toml").exists())
        .collect();
    folders.push(repository.join("tests/example/recording"));
    folders.sort();
    folders
}

/// All files under a folder with their relative names, sorted.
fn files(folder: &Path) -> Vec<(String, Vec<u8>)> {
    let mut found = Vec::new();
    let mut pending = vec![folder.to_owned()];
    while let Some(folder) = pending.pop() {
        for entry in std::fs::read_dir(&folder).unwrap() {
            let path = entry.unwrap().path();
            if path.is_dir() {
                pending.push(path);
            } else {
                found.push(path);
            }
        }
    }
    found.sort();
    let name = |path: &Path| path.strip_prefix(folder).unwrap().display().to_string();
    let read = |path: &Path| std::fs::read(path).unwrap();
    found.iter().map(|p| (name(p), read(p))).collect()
}

/// Asserts that all cells of two CSV files are equal: numbers bit for bit, others as text. Returns
/// the number of cells.
fn assert_same_cells(name: &str, original: &[u8], exported: &[u8]) -> usize {
    let rows = |bytes: &[u8]| -> Vec<csv::StringRecord> {
        csv::ReaderBuilder::new()
            .has_headers(false)
            .trim(csv::Trim::All)
            .from_reader(bytes)
            .records()
            .map(Result::unwrap)
            .collect()
    };
    let (original, exported) = (rows(original), rows(exported));
    assert_eq!(original.len(), exported.len(), "{name}: rows");
    let mut cells = 0;
    for (line, (a, b)) in original.iter().zip(&exported).enumerate() {
        assert_eq!(a.len(), b.len(), "{name}:{}: cells", line + 1);
        for (a, b) in a.iter().zip(b) {
            cells += 1;
            if let (Ok(x), Ok(y)) = (a.parse::<i64>(), b.parse::<i64>()) {
                assert_eq!(x, y, "{name}:{}", line + 1);
            }
            match (a.parse::<f64>(), b.parse::<f64>()) {
                (Ok(x), Ok(y)) => assert_eq!(x.to_bits(), y.to_bits(), "{name}:{}", line + 1),
                _ => assert_eq!(a, b, "{name}:{}", line + 1),
            }
        }
    }
    cells
}

#[test]
fn recordings_survive_folder_and_mcap() {
    for folder in recordings() {
        let name = folder.file_name().unwrap().to_string_lossy().into_owned();
        let scratch = tempfile::tempdir().unwrap();
        let at = |name: &str| scratch.path().join(name);

        let imported = read_folder(&folder).unwrap();
        // Columns that the format does not know are kept as text.
        let expected = |warning: &String| warning.contains("unknown column");
        assert!(
            imported.warnings.iter().all(expected),
            "{name}: {:?}",
            imported.warnings
        );
        write_folder(&imported.recording, &at("first")).unwrap();
        let first = files(&at("first"));
        let mut cells = 0;
        for (file, original) in files(&folder) {
            if file.ends_with(".csv") {
                let exported = first.iter().find(|(name, _)| *name == file).unwrap();
                cells += assert_same_cells(&format!("{name}/{file}"), &original, &exported.1);
            }
        }

        write_mcap(&imported.recording, &at("bag.mcap")).unwrap();
        let back = read(&at("bag.mcap")).unwrap();
        assert_eq!(back.warnings, Vec::<String>::new(), "{name}");
        write_folder(&back.recording, &at("second")).unwrap();
        let second = files(&at("second"));
        let names = |files: &[(String, Vec<u8>)]| -> Vec<String> {
            files.iter().map(|(name, _)| name.clone()).collect()
        };
        assert_eq!(names(&first), names(&second), "{name}");
        for ((file, a), (_, b)) in first.iter().zip(&second) {
            assert!(a == b, "{name}/{file} differs after MCAP");
        }
        let again = read(&at("second")).unwrap();
        write_mcap(&again.recording, &at("again.mcap")).unwrap();
        let bytes = |name: &str| std::fs::read(at(name)).unwrap();
        assert!(
            bytes("bag.mcap") == bytes("again.mcap"),
            "{name}: MCAP differs after export"
        );
        let size = bytes("bag.mcap").len();
        eprintln!("{name}: {cells} cells, {size} bytes of MCAP");
    }
}

/// Writes a recording with everything that standard messages cannot represent.
fn write_lossy_cases(folder: &Path) {
    let files = [
        (
            "recording.toml",
            "format = 1\nname = \"awkward\"\norigin = \"by hand\"\nsame_robot = true\n\
             weather = \"rain\"\n[robots.z]\nencoder_counts_per_rev = 1856\npose_point = \"axle\"\n\
             surface = \"ice\"\n[robots.z.noise]\npose_m = 0.1\n[robots.a]\nimu = \"acceleration\"\n\
             [robots.empty]\n",
        ),
        (
            "robot.toml",
            "format = 1\n[robot]\nbody_mass_kg = 1\nbody_yaw_inertia_kg_m2 = 1e-2\nwheel_mass_kg = 0\n\
             wheel_spin_inertia_kg_m2 = 1e-3\nwheel_yaw_inertia_kg_m2 = 0\nwheel_radius_m = 0.1\n\
             half_track_m = 0.30000000000000004\ncom_to_axle_m = 0\ncom_to_caster_m = 0.1\n\
             com_height_m = 0\n\
             [effects]\npush = [{ t_s = 1, impulse_n_s = 0.1, direction_rad = 0 }, \
              { t_s = 2.5, impulse_n_s = 0.2, direction_rad = 3 }]\n",
        ),
        (
            "z/command.csv",
            "t_s,voltage_right_v,voltage_left_v\n-1.5,-0,1e-300\n0.30000000000000004,,1\n",
        ),
        (
            "z/wheels.csv",
            "t_s,ticks_right,ticks_left\n0,-5,9007199254740993\n0,,7\n5e9,1,\n",
        ),
        (
            "z/pose.csv",
            "t_s,x_m,y_m,yaw_rad,quality\n0.1,1,2,7.3,\"good, \"\"very\"\"\"\n0.1,,,,\n0.2,1,2,,bad\n",
        ),
        ("z/motor.csv", "t_s,supply_v\n0,12.1\n1,\n"),
        ("a/pose.csv", "t_s,x_m,y_m\n0,1,2\n"),
        ("a/imu.csv", "t_s,gz_rad_s\n1e-9,0.1\n2e-9,\n"),
        ("a/odometry.csv", "t_s,v_m_s\n1248272272.841,1e-22\n"),
        ("a/command.csv", "t_s,v_m_s,w_rad_s\n"),
        (
            "a/wheels.csv",
            "t_s,speed_right_rad_s,speed_left_rad_s\n0,1,2\n",
        ),
        (
            "links.csv",
            "t_sent_s,t_received_s,from,to,x_m,y_m,yaw_rad,v_m_s,w_rad_s,note\n\
             0.1,0.30000000000000004,z,a,1,2,3,,0.5,x\n0.1,,a,z,,,,,,\n",
        ),
        ("rtt.csv", "seq,rtt_ms\n7,0.1\n3,\n"),
    ];
    for (name, text) in files {
        let path = folder.join(name);
        std::fs::create_dir_all(path.parent().unwrap()).unwrap();
        std::fs::write(path, text).unwrap();
    }
}

#[test]
fn what_standard_messages_cannot_represent_survives() {
    let scratch = tempfile::tempdir().unwrap();
    let at = |name: &str| scratch.path().join(name);
    write_lossy_cases(&at("given"));
    let imported = read_folder(&at("given")).unwrap();
    assert_eq!(imported.warnings.len(), 2, "{:?}", imported.warnings);
    write_folder(&imported.recording, &at("first")).unwrap();
    write_mcap(&imported.recording, &at("bag.mcap")).unwrap();
    let back = read(&at("bag.mcap")).unwrap();
    assert_eq!(back.warnings, Vec::<String>::new());
    write_folder(&back.recording, &at("second")).unwrap();
    let (first, second) = (files(&at("first")), files(&at("second")));
    for ((name_a, a), (name_b, b)) in first.iter().zip(&second) {
        let (a, b) = (String::from_utf8_lossy(a), String::from_utf8_lossy(b));
        assert_eq!((name_a, a), (name_b, b));
    }
    assert_eq!(first.len(), second.len());
    for (name, given) in files(&at("given")) {
        let exported = first.iter().find(|(file, _)| *file == name).unwrap();
        if name.ends_with(".csv") {
            assert_same_cells(&name, &given, &exported.1);
        }
    }
    let order: Vec<&str> = back
        .recording
        .robots
        .iter()
        .map(|r| r.name.as_str())
        .collect();
    assert_eq!(order, ["z", "a", "empty"]);
}
