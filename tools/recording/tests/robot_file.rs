//! Robots of other files: URDFs as people write them, controllers, and what cannot be read.
#![allow(clippy::unwrap_used, clippy::panic, reason = "a test may panic")]

use std::path::Path;

use slipstream_bus::RobotModel;
use slipstream_recording::robot_file::{self, Described, Kind};
use slipstream_recording::robot_toml;

const TURTLE: &str = include_str!("robot_file/turtle.urdf");
const TERRAIN: &str = include_str!("robot_file/terrain.urdf");
const COMPLETE: &str = include_str!("robot_file/complete.urdf");

fn described(text: &str) -> Described {
    let described = robot_file::parse(text, Path::new("r.urdf")).unwrap();
    assert_eq!(described.kind, Kind::Urdf);
    described
}

fn kinematic(wheel_radius_m: f64, half_track_m: f64) -> RobotModel {
    let text = format!(
        "format = 1\n[robot]\nwheel_radius_m = {wheel_radius_m}\nhalf_track_m = {half_track_m}\n"
    );
    robot_toml::parse(&text, Path::new("robot.toml")).unwrap()
}

/// Where a value is from.
fn from<'a>(described: &'a Described, key: &str) -> &'a str {
    let taken = described.taken.iter().find(|taken| taken.key == key);
    &taken.unwrap_or_else(|| panic!("no {key}")).from
}

/// Whether a note has all these words.
fn notes(described: &Described, words: &[&str]) -> bool {
    let mut notes = described.notes.iter();
    notes.any(|note| words.iter().all(|word| note.contains(word)))
}

/// A robot of two wheels with these origins, and this inside each of their links.
fn two_wheels(right: &str, left: &str, inside: &str) -> String {
    let wheel = |side: &str, origin: &str| {
        format!(
            "<link name=\"{side}_wheel_link\">{inside}</link>\n<joint name=\"{side}_wheel\" type=\"continuous\">\
             <parent link=\"base_link\"/><child link=\"{side}_wheel_link\"/><origin {origin}/><axis xyz=\"0 1 0\"/></joint>\n"
        )
    };
    let wheels = wheel("right", right) + &wheel("left", left);
    format!("<robot name=\"r\">\n<link name=\"base_link\"/>\n{wheels}</robot>\n")
}

/// A round wheel of this radius.
fn round(radius_m: &str) -> String {
    format!(
        "<collision><origin rpy=\"1.5708 0 0\"/><geometry><cylinder radius=\"{radius_m}\" length=\"0.1\"/></geometry></collision>"
    )
}

#[test]
fn two_wheels_and_a_ball_behind() {
    let own = described(TURTLE);
    assert_eq!(own.model().unwrap(), kinematic(0.033, 0.08));
    assert_eq!(
        from(&own, "wheel_radius_m"),
        "cylinder of link wheel_right_link, collision"
    );
    assert_eq!(
        from(&own, "half_track_m"),
        "y of the origins of wheel_right_joint and wheel_left_joint"
    );
    assert_eq!(
        own.wheel_joints,
        [vec!["wheel_right_joint"], vec!["wheel_left_joint"]]
    );
    // The model's caster lies ahead of the centre of mass, and the axle behind it.
    assert!(
        notes(&own, &["left out", "com_to_axle_m is -0.03"]),
        "{:?}",
        own.notes
    );
    let mass = own
        .left_out
        .iter()
        .find(|taken| taken.key == "body_mass_kg");
    assert_eq!(mass.map(|taken| taken.value), Some(0.805));
    assert!(
        own.to_robot_toml()
            .contains("# body_mass_kg = 0.805  # left out; mass of all")
    );
}

#[test]
fn four_wheels_are_one_pair() {
    let own = described(TERRAIN);
    assert_eq!(own.model().unwrap(), kinematic(0.165, 0.29));
    assert_eq!(
        own.wheel_joints[0],
        ["front_right_wheel", "rear_right_wheel"]
    );
    assert!(notes(&own, &["4 wheels", "track_width"]));
    assert!(notes(&own, &["left out", "those of two driven wheels"]));
    assert!(!notes(&own, &["The axle lies"]));
    let narrow = TERRAIN
        .replace("0.256 0.29 ", "0.256 0.19 ")
        .replace("-0.256 0.19", "-0.256 0.29");
    let own = described(&narrow);
    assert_eq!(own.model().unwrap(), kinematic(0.165, 0.29));
    assert!(
        notes(&own, &["that of the rear pair", "0.24 m"]),
        "{:?}",
        own.notes
    );
}

#[test]
fn a_wheel_that_is_a_mesh_has_no_radius() {
    let mesh = "<collision><geometry><mesh filename=\"file:///dev/zero\"/></geometry></collision>";
    let own = described(&two_wheels("xyz=\"0 -0.2 0\"", "xyz=\"0 0.2 0\"", mesh));
    assert_eq!(own.missing.len(), 1);
    let error = own.model().unwrap_err().to_string();
    assert!(error.starts_with(
        "r.urdf: gives no wheel_radius_m: the wheel of right_wheel is a mesh; write a robot.toml"
    ));
    assert!(error.contains("`slipstream robot r.urdf --out robot.toml`"));
    let text = own.to_robot_toml();
    assert!(text.contains("\n# wheel_radius_m =   # to fill in: the wheel of right_wheel is a mesh; measure the radius"));
    assert!(text.contains("\nhalf_track_m = 0.2  # y of the origins"));
    let filled = text.replace("# wheel_radius_m =  ", "wheel_radius_m = 0.1");
    let model = robot_toml::parse(&filled, Path::new("robot.toml")).unwrap();
    assert_eq!(model, kinematic(0.1, 0.2));
}

#[test]
fn the_height_over_the_floor_is_a_hint_for_a_mesh() {
    let mesh = "<visual><geometry><mesh filename=\"a.stl\"/></geometry></visual>";
    let text = two_wheels("xyz=\"0 -0.2 0\"", "xyz=\"0 0.2 0\"", mesh);
    let footprint = "<link name=\"base_footprint\"/><joint name=\"f\" type=\"fixed\"><parent link=\"base_footprint\"/>\
                     <child link=\"base_link\"/><origin xyz=\"0 0 0.0752\"/></joint></robot>";
    let own = described(&text.replace("</robot>", footprint));
    assert!(
        own.missing[0]
            .remedy
            .contains("0.0752 m if base_footprint lies on the floor")
    );
}

#[test]
fn wheels_below_a_turned_suspension() {
    // The suspension is turned by a quarter about z: its x is the robot's y.
    let text = "<robot name='r'><link name='base_link'/>
        <link name='lf_arm'/><link name='rf_arm'/><link name='lf'/><link name='rr'/>
        <joint name='l_arm' type='fixed'><parent link='base_link'/><child link='lf_arm'/><origin xyz='0.1 0.05 0' rpy='0 0 1.5708'/></joint>
        <joint name='r_arm' type='fixed'><parent link='base_link'/><child link='rf_arm'/><origin xyz='0.1 -0.05 0' rpy='0 0 1.5708'/></joint>
        <joint name='lf' type='continuous'><parent link='lf_arm'/><child link='lf'/><origin xyz='0.25 0 0'/><axis xyz='1 0 0'/></joint>
        <joint name='rr' type='continuous'><parent link='rf_arm'/><child link='rr'/><origin xyz='-0.25 0 0'/></joint></robot>";
    let sphere = "<collision><geometry><sphere radius='0.1'/></geometry></collision>";
    let own = described(
        &text
            .replace(
                "<link name='lf'/>",
                &format!("<link name='lf'>{sphere}</link>"),
            )
            .replace(
                "<link name='rr'/>",
                &format!("<link name='rr'>{sphere}</link>"),
            ),
    );
    assert_eq!(own.model().unwrap(), kinematic(0.1, 0.3));
    assert_eq!(own.wheel_joints, [vec!["rr"], vec!["lf"]]);
    assert!(notes(&own, &["No joint is called a wheel", "rr"]));
    assert!(notes(&own, &["axle lies at x = 0.1 m"]));
    assert!(!notes(&own, &["against its name"]));
}

#[test]
fn what_is_odd_is_said() {
    let turned = described(&two_wheels(
        "xyz=\"0 0.2 0\"",
        "xyz=\"0 -0.2 0\"",
        &round("0.1"),
    ));
    assert!(
        notes(&turned, &["right_wheel lies left", "against its name"]),
        "{:?}",
        turned.notes
    );
    assert_eq!(turned.model().unwrap(), kinematic(0.1, 0.2));
    let uneven = described(&two_wheels(
        "xyz=\"0 -0.1 0\"",
        "xyz=\"0.05 0.3 0\"",
        &round("0.1"),
    ));
    assert!(notes(
        &uneven,
        &["0.3 m to the left and 0.1 m to the right"]
    ));
    assert!(notes(&uneven, &["left_wheel lies 0.05 m ahead"]));
    assert_eq!(uneven.model().unwrap(), kinematic(0.1, 0.2));
    let text = two_wheels("xyz=\"0 -0.2 0\"", "xyz=\"0 0.2 0\"", &round("0.125"));
    let unequal = described(&text.replacen("0.125", "0.25", 1));
    assert!(notes(&unequal, &["right 0.25 m, left 0.125 m", "mean"]));
    assert_eq!(unequal.model().unwrap(), kinematic(0.1875, 0.2));
    let none = described("<robot name=\"r\"><link name=\"base_link\"/></robot>");
    assert_eq!(none.missing.len(), 2);
    let message = none.model().unwrap_err().problem;
    assert_eq!(
        message,
        "gives no wheel_radius_m and no half_track_m: no joint turns a wheel about an axis across the robot"
    );
}

#[test]
fn of_several_wheels_those_with_motors_count() {
    let control = "<ros2_control name=\"c\" type=\"system\"><joint name=\"rear_left_wheel\"><command_interface \
                   name=\"velocity\"/></joint><joint name=\"rear_right_wheel\"><command_interface name=\"velocity\"/></joint>\
                   <joint name=\"front_right_wheel\"><state_interface name=\"velocity\"/></joint></ros2_control></robot>";
    let own = described(&TERRAIN.replace("</robot>", control));
    assert_eq!(
        own.wheel_joints,
        [vec!["rear_right_wheel"], vec!["rear_left_wheel"]]
    );
    assert!(notes(
        &own,
        &[
            "Not driven by a motor",
            "front_left_wheel, front_right_wheel"
        ]
    ));
}

#[test]
fn complete_masses_make_a_dynamic_model() {
    let own = described(COMPLETE);
    assert_eq!(own.left_out, []);
    let body = own.model().unwrap().robot;
    let near = |value: Option<f64>, expected: f64| {
        let value = value.unwrap();
        assert!(
            (value - expected).abs() < 1e-12,
            "{value} where {expected} is right"
        );
    };
    near(body.body_mass_kg, 2.0);
    // Two plates of 0.004 kg m², each 0.1 m from the centre.
    near(body.body_yaw_inertia_kg_m2, 0.008 + 2.0 * 0.01);
    near(body.wheel_mass_kg, 0.5);
    near(body.wheel_spin_inertia_kg_m2, 0.0025);
    near(body.wheel_yaw_inertia_kg_m2, 0.00125);
    near(body.com_to_axle_m, 0.05);
    near(body.com_to_caster_m, 0.25);
    near(body.com_height_m, 0.15);
    assert_eq!((body.wheel_radius_m, body.half_track_m), (0.1, 0.2));
}

#[test]
fn masses_that_stand_for_none_are_left_out() {
    let cases = [
        (
            "<mass value=\"1\"/>",
            "<mass value=\"0.00001\"/>",
            "has a mass of 0.00001 kg",
        ),
        ("izz=\"0.004\"", "izz=\"1e-6\"", "which no body has"),
        (
            "ixx=\"0.002\" ixy=\"0\" ixz=\"0\" iyy=\"0.003\" iyz=\"0\" izz=\"0.004\"",
            "ixx=\"1e-6\" ixy=\"0\" ixz=\"0\" iyy=\"1e-6\" iyz=\"0\" izz=\"1e-6\"",
            "which no body has",
        ),
        (
            "ixx=\"0.002\" ixy=\"0\" ixz=\"0\" iyy=\"0.003\" iyz=\"0\" izz=\"0.004\"",
            "ixx=\"20\" ixy=\"0\" ixz=\"0\" iyy=\"20\" iyz=\"0\" izz=\"20\"",
            "which no body has",
        ),
        ("caster", "ball", "com_to_caster_m is not known"),
        (
            "<origin xyz=\"0.25 0 -0.02\"/>",
            "<origin xyz=\"-0.25 0 -0.02\"/>",
            "com_to_caster_m is -0.25",
        ),
    ];
    for (old, new, words) in cases {
        let changed = COMPLETE.replace(old, new);
        assert_ne!(changed, COMPLETE, "{old}");
        let own = described(&changed);
        assert_eq!(own.model().unwrap(), kinematic(0.1, 0.2), "{new}");
        assert!(
            notes(&own, &["left out", words]),
            "{words}: {:?}",
            own.notes
        );
    }
}

#[test]
fn what_is_written_is_the_model() {
    let controller = "c:\n  ros__parameters:\n    wheel_separation: 0.3\n    wheel_radius: 0.1\n    \
                      left_wheel_radius_multiplier: 0.97\n    right_wheel_names: ['a\\n# b']\n";
    let paper = robot_toml::to_text(&RobotModel::paper_with_slip());
    for text in [TURTLE, TERRAIN, COMPLETE, controller, &paper] {
        let own = robot_file::parse(text, Path::new("a\nb.urdf")).unwrap();
        let written = own.to_robot_toml();
        let again = robot_toml::parse(&written, Path::new("robot.toml")).unwrap();
        assert_eq!(again, own.model().unwrap(), "{written}");
        for taken in &own.taken {
            assert!(taken.value.is_finite() && !taken.from.is_empty());
        }
    }
}

#[test]
fn faults_are_one_line_with_place_and_remedy() {
    let ok = two_wheels("xyz=\"0 -0.2 0\"", "xyz=\"0 0.2 0\"", &round("0.1"));
    let changed = |old: &str, new: &str| {
        assert!(ok.contains(old), "{old}");
        ok.replacen(old, new, 1)
    };
    let cases = [
        (
            changed("xyz=\"0 -0.2 0\"", "xyz=\"0 -0.2\""),
            "r.urdf:4: xyz of <origin> has 2 numbers; give 3",
        ),
        (
            changed("-0.2", "-0,2"),
            "r.urdf:4: xyz of <origin> is \"-0,2\"; give 3 numbers",
        ),
        (
            changed("-0.2", "${-track/2}"),
            "r.urdf:4: xyz of <origin> is \"${-track/2}\"; run `xacro FILE",
        ),
        (
            changed("<link name=\"base_link\"/>", "<xacro:wheel/>"),
            "r.urdf:2: has xacro macros, which are not expanded; run `xacro",
        ),
        (
            changed(
                "<robot name=\"r\">",
                "<robot name=\"r\" xmlns:xacro=\"http://ros.org/wiki/xacro\">\n<xacro:wheel/>",
            ),
            "r.urdf:2: has xacro macros, which are not expanded; run `xacro FILE > robot.urdf` first",
        ),
        (
            changed("child link=\"right", "child link=\"write"),
            "r.urdf:4: joint right_wheel has the child write_wheel_link",
        ),
        (
            changed("joint name=\"right_wheel\"", "joint name=\"left_wheel\""),
            "r.urdf:6: joint left_wheel is there twice; rename",
        ),
        (
            changed(" type=\"continuous\"", ""),
            "r.urdf:4: <joint> has no type; add type=",
        ),
        (
            changed("axis xyz=\"0 1 0\"", "axis xyz=\"0 0 0\""),
            "r.urdf:4: the axis of right_wheel is 0 0 0; give",
        ),
        (changed("</robot>", ""), "r.urdf:"),
        (
            changed("child link=\"left", "child link=\"right"),
            "r.urdf:6: link right_wheel_link is the child of right_wheel and of",
        ),
        (
            ok.replace("radius=\"0.1\"", "radius=\"-0.1\""),
            "r.urdf: wheel_radius_m is -0.1 (cylinder of link right",
        ),
        (
            ok.replace("radius=\"0.1\"", "radius=\"1e-7\""),
            "r.urdf: wheel_radius_m is 1e-7 (cylinder",
        ),
        (
            "<sdf version=\"1.6\"><model/></sdf>".to_owned(),
            "r.urdf:1: has <sdf> where a URDF has <robot>; give",
        ),
        (
            "<robot name=\"r\"/>".to_owned(),
            "r.urdf:1: has no <link>; give the URDF",
        ),
        (
            "<!DOCTYPE robot [<!ENTITY a \"b\">]><robot/>".to_owned(),
            "r.urdf:1: has a document type; remove",
        ),
    ];
    for (text, message) in cases {
        let error = robot_file::parse(&text, Path::new("r.urdf"))
            .unwrap_err()
            .to_string();
        assert!(error.starts_with(message), "{error}\n wanted {message}");
        assert!(!error.contains('\n') && error.contains("; "), "{error}");
    }
}

/// Files that would take an unwary reader hours or all of the memory.
#[test]
fn hostile_files_are_read_in_a_moment() {
    let begin = std::time::Instant::now();
    let chain = |count: usize| {
        let link = |i: usize| format!("<link name=\"caster_wheel{i}\"/>");
        let joint = |i: usize| {
            format!(
                "<joint name=\"wheel{i}\" type=\"continuous\"><parent link=\"caster_wheel{i}\"/><child \
                 link=\"caster_wheel{}\"/><axis xyz=\"0 1 0\"/></joint>",
                i + 1
            )
        };
        let links: String = (0..=count).map(link).collect();
        let joints: String = (0..count).map(joint).collect();
        format!("<robot>{links}{joints}</robot>")
    };
    let texts = [
        chain(4000),
        chain(4000).replace("caster_", "x_"),
        chain(20_000),
        format!("<robot>{}", "<link>".repeat(600_000)),
        format!("<robot a=\"{}\"/>", "&lt;".repeat(900_000)),
        format!("a: {}", "{a: ".repeat(900_000)),
        format!("a: {}", "[".repeat(4_000_000)),
        "- ".repeat(2_000_000),
        (0..400_000).map(|i| format!("k{i}: 1\n")).collect(),
        format!("a: &a [{}]\n", "*a, ".repeat(900_000)),
        "? ".repeat(2_000_000) + ": a",
        "a: |\n".to_owned() + &"\n".repeat(4_000_000),
        "!".repeat(4_000_000),
        "a: \"".to_owned() + &"\\n".repeat(2_000_000),
    ];
    for text in texts {
        let head: String = text.chars().take(40).collect();
        let one = std::time::Instant::now();
        for name in ["r.urdf", "r.yaml"] {
            if let Err(error) = robot_file::parse(&text, Path::new(name)) {
                assert!(!error.to_string().contains('\n'));
            }
        }
        eprintln!("{head}: {:?}", one.elapsed());
    }
    // Minutes would be a fault; a busy machine takes seconds.
    assert!(begin.elapsed().as_secs() < 60, "{:?}", begin.elapsed());
}
