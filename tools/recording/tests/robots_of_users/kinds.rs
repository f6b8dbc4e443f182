//! The structures, and what is right of each.
#![expect(clippy::too_many_lines, reason = "tables")]

use std::sync::LazyLock;

use super::urdf::{MESH, castor, cylinder, joint, link, mass, robot, steered, wheel, wheel_at};

/// A structure.
pub(crate) struct Kind {
    pub(crate) name: &'static str,
    /// Names and texts of the files.
    pub(crate) files: Vec<(&'static str, String)>,
    /// What is right.
    pub(crate) expected: &'static str,
    /// Words that notes must have.
    pub(crate) said: Vec<&'static str>,
}

fn urdf(
    name: &'static str,
    parts: &[String],
    expected: &'static str,
    said: &[&'static str],
) -> Kind {
    Kind {
        name,
        files: vec![("robot.urdf", robot(parts))],
        expected,
        said: said.to_vec(),
    }
}

/// Two driven wheels of radius 0.05 m at y = ±0.15 m.
fn pair(shape: &str) -> String {
    wheel("left_wheel", "0 0.15 0", shape) + &wheel("right_wheel", "0 -0.15 0", shape)
}

fn plugin(file: &str, parameters: &str) -> String {
    format!("<gazebo><plugin filename=\"{file}\" name=\"drive\">{parameters}</plugin></gazebo>\n")
}

pub(crate) static KINDS: LazyLock<Vec<Kind>> = LazyLock::new(|| {
    [
        wheels(),
        many(),
        others(),
        plugins(),
        masses(),
        with_controllers(),
    ]
    .into_iter()
    .flatten()
    .collect()
});

/// The wheels of [`pair`].
const PAIR: &str = "r = 0.05 m, b = 0.15 m, right: right_wheel, left: left_wheel";

fn wheels() -> Vec<Kind> {
    let round = cylinder(0.05, 0.0);
    let small = cylinder(0.02, 0.0);
    let sideways = round.replace("1.5708 0 0", "0 1.5708 0");
    let turned = |side: &str, name: &str| {
        // The frame of each wheel is turned so that its z points outward.
        let rpy = if side == "-" {
            "1.5708 0 0"
        } else {
            "-1.5708 0 0"
        };
        link(
            &format!("{name}_link"),
            "<collision><geometry><cylinder radius=\"0.05\" length=\"0.04\"/></geometry></collision>",
        ) + &joint(
            name,
            "continuous",
            ["base_link", &format!("{name}_link")],
            &format!("xyz=\"0 {side}0.15 0\" rpy=\"{rpy}\""),
            "0 0 1",
        )
    };
    vec![
        urdf(
            "two wheels and a ball",
            &[
                pair(&round),
                link("ball", ""),
                joint(
                    "b",
                    "fixed",
                    ["base_link", "ball"],
                    "xyz=\"-0.1 0 -0.03\"",
                    "0 0 1",
                ),
            ],
            PAIR,
            &[],
        ),
        urdf(
            "two wheels and two castors, whose wheels are called wheels",
            &[
                pair(&round),
                castor("front_left_fork", "front_left_wheel", "0.2 0.1 0"),
                castor("front_right_fork", "front_right_wheel", "0.2 -0.1 0"),
            ],
            PAIR,
            &[],
        ),
        urdf(
            "mirrored frames: the axes of both wheels point outward",
            &[turned("", "left_wheel"), turned("-", "right_wheel")],
            PAIR,
            &[],
        ),
        urdf(
            "wheels beside their joints",
            &[
                wheel("left_wheel", "0 0.12 0", &cylinder(0.05, 0.03)),
                wheel("right_wheel", "0 -0.12 0", &cylinder(0.05, -0.03)),
            ],
            PAIR,
            &["beside their joints"],
        ),
        urdf(
            "twin tyres on each side",
            &[
                wheel(
                    "left_wheel",
                    "0 0.1 0",
                    &(cylinder(0.05, 0.03) + &cylinder(0.05, 0.07)),
                ),
                wheel(
                    "right_wheel",
                    "0 -0.1 0",
                    &(cylinder(0.05, -0.03) + &cylinder(0.05, -0.07)),
                ),
            ],
            PAIR,
            &["beside their joints"],
        ),
        urdf(
            "a base that looks along y",
            &[
                link("left_wheel_link", &sideways),
                joint(
                    "left_wheel",
                    "continuous",
                    ["base_link", "left_wheel_link"],
                    "xyz=\"-0.15 0 0\"",
                    "1 0 0",
                ),
                link("right_wheel_link", &sideways),
                joint(
                    "right_wheel",
                    "continuous",
                    ["base_link", "right_wheel_link"],
                    "xyz=\"0.15 0 0\"",
                    "1 0 0",
                ),
            ],
            PAIR,
            &["its y counts as forward"],
        ),
        urdf(
            "hubs with tyres fixed to them",
            &[
                wheel("left_wheel", "0 0.15 0", &small),
                wheel("right_wheel", "0 -0.15 0", &small),
                link("lt", &round),
                joint(
                    "lf",
                    "fixed",
                    ["left_wheel_link", "lt"],
                    "xyz=\"0 0 0\"",
                    "0 0 1",
                ),
                link("rt", &round),
                joint(
                    "rf",
                    "fixed",
                    ["right_wheel_link", "rt"],
                    "xyz=\"0 0 0\"",
                    "0 0 1",
                ),
            ],
            PAIR,
            &[],
        ),
        urdf(
            "joints without names of wheels",
            &[
                wheel("j1", "0 0.15 0", &round),
                wheel("j2", "0 -0.15 0", &round),
            ],
            "r = 0.05 m, b = 0.15 m, right: j2, left: j1",
            &["No joint is called a wheel"],
        ),
        urdf(
            "wheels fixed to the base",
            &[pair(&round).replace("continuous", "fixed")],
            PAIR,
            &["fixed in the file"],
        ),
        urdf(
            "a cleaner: a roller in the middle, a brush that turns about the vertical",
            &[
                pair(&round),
                wheel("roller", "0.1 0 0", &small),
                link("brush", ""),
                joint(
                    "brush_joint",
                    "continuous",
                    ["base_link", "brush"],
                    "xyz=\"0.1 0.1 0\"",
                    "0 0 1",
                ),
            ],
            PAIR,
            &[],
        ),
        urdf(
            "two arms whose joints turn without end about the lateral axis",
            &[
                pair(&round),
                wheel("left_shoulder", "0.1 0.2 0.5", &small),
                wheel("right_shoulder", "0.1 -0.2 0.5", &small),
            ],
            PAIR,
            &[],
        ),
        urdf(
            "wheels of meshes alone",
            &[pair(MESH)],
            "r = none, b = 0.15 m, right: right_wheel, left: left_wheel",
            &[],
        ),
        urdf(
            "xacro macros",
            &["<xacro:wheel side=\"left\"/>".to_owned()],
            "robot.urdf:3: has xacro macros, which are not expanded; run `xacro FILE > robot.urdf` first, and give robot.urdf",
            &[],
        ),
    ]
}

fn many() -> Vec<Kind> {
    let round = cylinder(0.1, 0.0);
    let at = |name: &str, x: f64, y: f64, shape: &str| wheel(name, &format!("{x} {y} 0"), shape);
    let rover = |side: &str, y: f64| {
        let rocker = format!("{side}_rocker");
        link(&rocker, "")
            + &joint(
                &format!("{rocker}_joint"),
                "revolute",
                ["base_link", &rocker],
                &format!("xyz=\"0 {y} 0.2\""),
                "0 1 0",
            )
            + &wheel_at(
                &rocker,
                &format!("{side}_front_wheel"),
                "0.3 0 -0.2",
                &round,
            )
            + &wheel_at(&rocker, &format!("{side}_middle_wheel"), "0 0 -0.2", &round)
            + &wheel_at(
                &rocker,
                &format!("{side}_rear_wheel"),
                "-0.3 0 -0.2",
                &round,
            )
    };
    let rollers = |name: &str, x: f64, y: f64| {
        let hub = format!("{name}_link");
        let roller = |i: usize| {
            let own = format!("{name}_roller_{i}");
            link(&own, "")
                + &joint(
                    &format!("{own}_joint"),
                    "continuous",
                    [&hub, &own],
                    "xyz=\"0 0 0.09\"",
                    "0.7 0.7 0",
                )
        };
        at(name, x, y, &round) + &(0..8).map(roller).collect::<String>()
    };
    let four = [
        at("front_left_wheel", 0.2, 0.3, &round),
        at("front_right_wheel", 0.2, -0.3, &round),
        at("rear_left_wheel", -0.2, 0.3, &round),
        at("rear_right_wheel", -0.2, -0.3, &round),
    ];
    const FOUR: &str = "r = 0.1 m, b = 0.3 m, right: front_right_wheel rear_right_wheel, left: front_left_wheel rear_left_wheel";
    vec![
        urdf(
            "four wheels (skid steering)",
            &four,
            FOUR,
            &["4 wheels: the model has one pair"],
        ),
        urdf(
            "six wheels on rockers",
            &[rover("left", 0.3), rover("right", -0.3)],
            "r = 0.1 m, b = 0.3 m, right: right_front_wheel right_middle_wheel right_rear_wheel, left: left_front_wheel \
             left_middle_wheel left_rear_wheel",
            &["6 wheels: the model has one pair"],
        ),
        urdf(
            "two large wheels, two small ones in front that do not swivel",
            &[
                at("rear_left_wheel", 0.0, 0.3, &round),
                at("rear_right_wheel", 0.0, -0.3, &round),
                at("front_left_wheel", 0.4, 0.3, &cylinder(0.04, 0.0)),
                at("front_right_wheel", 0.4, -0.3, &cylinder(0.04, 0.0)),
            ],
            "r = 0.1 m, b = 0.3 m, right: rear_right_wheel, left: rear_left_wheel",
            &["Smaller than the largest wheels"],
        ),
        urdf(
            "three wheels: one behind in the middle",
            &[
                at("left_wheel", 0.0, 0.3, &round),
                at("right_wheel", 0.0, -0.3, &round),
                at("rear_wheel", -0.3, 0.0, &round),
            ],
            "r = 0.1 m, b = 0.3 m, right: right_wheel, left: left_wheel",
            &["rear_wheel lies in the middle"],
        ),
        urdf(
            "tracks of sprockets and rollers",
            &[
                at("left_track_sprocket", 0.3, 0.3, &round),
                at("right_track_sprocket", 0.3, -0.3, &round),
                at("left_track_roller_wheel", 0.0, 0.3, &cylinder(0.04, 0.0)),
                at("right_track_roller_wheel", 0.0, -0.3, &cylinder(0.04, 0.0)),
            ],
            "r = 0.1 m, b = 0.3 m, right: right_track_sprocket, left: left_track_sprocket",
            &["Tracks: the model has one pair"],
        ),
        urdf(
            "tracks that are fixed links",
            &[
                link("left_track", MESH),
                joint(
                    "left_track_joint",
                    "fixed",
                    ["base_link", "left_track"],
                    "xyz=\"0 0.3 0\"",
                    "0 0 1",
                ),
                link("right_track", MESH),
                joint(
                    "right_track_joint",
                    "fixed",
                    ["base_link", "right_track"],
                    "xyz=\"0 -0.3 0\"",
                    "0 0 1",
                ),
            ],
            "r = none, b = 0.3 m, right: right_track_joint, left: left_track_joint",
            &["Tracks: the model has one pair", "fixed in the file"],
        ),
        urdf(
            "mecanum wheels with rollers",
            &[
                rollers("front_left_wheel", 0.2, 0.3),
                rollers("front_right_wheel", 0.2, -0.3),
                rollers("rear_left_wheel", -0.2, 0.3),
                rollers("rear_right_wheel", -0.2, -0.3),
            ],
            FOUR,
            &["Mecanum wheels are no differential drive"],
        ),
        urdf(
            "mecanum wheels by their mesh",
            &four.clone().map(|own| {
                own.replace(
                    "<collision>",
                    &format!("{}<collision>", MESH.replace("part", "mecanum_wheel")),
                )
            }),
            FOUR,
            &["Mecanum wheels are no differential drive"],
        ),
    ]
}

fn others() -> Vec<Kind> {
    let rear = wheel("left_rear", "-0.3 0.3 0", &cylinder(0.1, 0.0))
        + &wheel("right_rear", "-0.3 -0.3 0", &cylinder(0.1, 0.0));
    let omni = |name: &str, yaw: f64| {
        let own = format!("{name}_link");
        link(&own, &cylinder(0.05, 0.0))
            + &joint(
                name,
                "continuous",
                ["base_link", &own],
                &format!(
                    "xyz=\"{} {} 0\" rpy=\"0 0 {yaw}\"",
                    0.2 * yaw.cos(),
                    0.2 * yaw.sin()
                ),
                "1 0 0",
            )
    };
    vec![
        urdf(
            "a car: front wheels below steering",
            &[
                steered("front_left_wheel", "0.3 0.3 0"),
                steered("front_right_wheel", "0.3 -0.3 0"),
                rear,
            ],
            "r = 0.1 m, b = 0.3 m, right: right_rear, left: left_rear",
            &["A robot with steered wheels is no differential drive"],
        ),
        urdf(
            "four wheels that all steer",
            &[
                steered("front_left_wheel", "0.3 0.3 0"),
                steered("front_right_wheel", "0.3 -0.3 0"),
                steered("rear_left_wheel", "-0.3 0.3 0"),
                steered("rear_right_wheel", "-0.3 -0.3 0"),
            ],
            "r = none, b = none, right: , left: ",
            &["A robot with steered wheels is no differential drive"],
        ),
        urdf(
            "three omni wheels at 120 degrees",
            &[
                omni("wheel_1", 0.0),
                omni("wheel_2", 2.0944),
                omni("wheel_3", 4.1888),
            ],
            "r = none, b = none, right: , left: ",
            &["its axis does not lie across the robot"],
        ),
    ]
}

fn plugins() -> Vec<Kind> {
    let meshes = pair(MESH);
    let told = "<left_joint>left_wheel</left_joint><right_joint>right_wheel</right_joint>";
    const PLUGIN: &str = "r = 0.04 m, b = 0.14 m, right: right_wheel, left: left_wheel";
    vec![
        urdf("meshes and the drive plugin of Gazebo classic", &[meshes.clone(), plugin("libgazebo_ros_diff_drive.so",
            "<leftJoint>left_wheel</leftJoint><rightJoint>right_wheel</rightJoint><wheelSeparation>0.28</wheelSeparation><wheelDiameter>0.08</wheelDiameter>")],
            PLUGIN, &[]),
        urdf("the same for ROS 2", &[meshes.clone(), plugin("libgazebo_ros_diff_drive.so",
            &format!("<num_wheel_pairs>1</num_wheel_pairs>{told}<wheel_separation>0.28</wheel_separation><wheel_diameter>0.08</wheel_diameter>"))],
            PLUGIN, &[]),
        urdf("the plugin of new Gazebo", &[meshes.clone(), plugin("gz-sim-diff-drive-system",
            &format!("{told}<wheel_separation>0.28</wheel_separation><wheel_radius>0.04</wheel_radius>"))],
            PLUGIN, &[]),
        urdf(
            "meshes, and a file with the controller's parameters",
            &[
                meshes.clone(),
                "<gazebo><plugin filename=\"libgz_ros2_control-system.so\"><parameters>/r/control.yaml</parameters></plugin></gazebo>"
                    .to_owned(),
            ],
            "r = none, b = 0.15 m, right: right_wheel, left: left_wheel",
            &["/r/control.yaml: give that file, too"],
        ),
        urdf("a plugin against the shapes", &[pair(&cylinder(0.05, 0.0)), plugin("gz-sim-diff-drive-system",
            &format!("{told}<wheel_separation>0.28</wheel_separation><wheel_radius>0.04</wheel_radius>"))],
            PAIR, &["contradict each other about the wheel radius: 0.05 m", "contradict each other about half of the track"]),
        urdf("a plugin that names two of four wheels", &[
            meshes.clone(), wheel("front_left_wheel", "0.2 0.15 0", MESH), wheel("front_right_wheel", "0.2 -0.15 0", MESH),
            plugin("gz-sim-diff-drive-system", &format!("{told}<wheel_separation>0.28</wheel_separation><wheel_radius>0.04</wheel_radius>")),
        ], PLUGIN, &[]),
        urdf("the skid steering plugin", &[
            meshes.clone(), wheel("front_left_wheel", "0.2 0.15 0", MESH), wheel("front_right_wheel", "0.2 -0.15 0", MESH),
            plugin("libgazebo_ros_skid_steer_drive.so", "<leftFrontJoint>front_left_wheel</leftFrontJoint><rightFrontJoint>front_right_wheel</rightFrontJoint>\
                <leftRearJoint>left_wheel</leftRearJoint><rightRearJoint>right_wheel</rightRearJoint><wheelSeparation>0.28</wheelSeparation><wheelDiameter>0.08</wheelDiameter>"),
        ], "r = 0.04 m, b = 0.14 m, right: front_right_wheel right_wheel, left: front_left_wheel left_wheel", &["4 wheels"]),
        urdf("a plugin that moves the body in any direction", &[pair(&cylinder(0.05, 0.0)), plugin("libgazebo_ros_planar_move.so", "<odometryFrame>odom</odometryFrame>")],
            PAIR, &["moves sideways"]),
        urdf("motors of ros2_control for two of four wheels", &[
            pair(&cylinder(0.05, 0.0)), wheel("front_left_wheel", "0.2 0.15 0", &cylinder(0.05, 0.0)), wheel("front_right_wheel", "0.2 -0.15 0", &cylinder(0.05, 0.0)),
            "<ros2_control name=\"c\" type=\"system\"><joint name=\"left_wheel\"><command_interface name=\"velocity\"/></joint><joint name=\"right_wheel\">\
             <command_interface name=\"velocity\"/></joint></ros2_control>".to_owned(),
        ], PAIR, &["Not driven by a motor of the file"]),
    ]
}

fn masses() -> Vec<Kind> {
    let wheels = |inside: &str| pair(&(cylinder(0.05, 0.0) + inside));
    let heavy = mass(0.2, 0.0002);
    let caster = link("caster", &mass(0.1, 0.00001))
        + &joint(
            "caster_joint",
            "fixed",
            ["base_link", "caster"],
            "xyz=\"0.2 0 -0.03\"",
            "0 0 1",
        );
    let chassis = link("chassis", &(mass(5.0, 0.05) + MESH))
        + &joint(
            "chassis_joint",
            "fixed",
            ["base_link", "chassis"],
            "xyz=\"0.1 0 0.05\"",
            "0 0 1",
        );
    let part = |inside: &str| {
        link("imu", inside)
            + &joint(
                "imu_joint",
                "fixed",
                ["base_link", "imu"],
                "xyz=\"0 0 0.1\"",
                "0 0 1",
            )
    };
    const DYNAMIC: &str = "r = 0.05 m, b = 0.15 m, right: right_wheel, left: left_wheel, masses";
    vec![
        urdf(
            "the mass of the body in a link fixed to the base",
            &[wheels(&heavy), caster.clone(), chassis.clone()],
            DYNAMIC,
            &[],
        ),
        urdf(
            "a part of a gram with inertias of no body",
            &[
                wheels(&heavy),
                caster.clone(),
                chassis.clone(),
                part(&mass(0.001, 1e-9)),
            ],
            DYNAMIC,
            &["counts as a point"],
        ),
        urdf(
            "a sensor with a shape and no mass",
            &[wheels(&heavy), caster.clone(), chassis.clone(), part(MESH)],
            DYNAMIC,
            &[],
        ),
        urdf(
            "a large part with inertias of no body",
            &[
                wheels(&heavy),
                caster.clone(),
                chassis.clone(),
                part(&mass(2.0, 1e-9)),
            ],
            PAIR,
            &["Masses and inertias are left out: link imu has inertias"],
        ),
        urdf(
            "wheels without masses",
            &[wheels(""), caster, chassis],
            PAIR,
            &["left out: link left_wheel_link has a shape and no mass"],
        ),
    ]
}

fn with_controllers() -> Vec<Kind> {
    let meshes = robot(&[pair(MESH)]);
    let round = robot(&[pair(&cylinder(0.05, 0.0))]);
    let both = |name, urdf: &str, yaml: &str, expected, said: &[&'static str]| Kind {
        name,
        files: vec![
            ("robot.urdf", urdf.to_owned()),
            ("control.yaml", yaml.to_owned()),
        ],
        expected,
        said: said.to_vec(),
    };
    let ros_1 = "base_controller:\n  type: diff_drive_controller/DiffDriveController\n  left_wheel: left_wheel\n  right_wheel: right_wheel\n  \
                 wheel_separation_multiplier: 1.5\n  wheel_radius_multiplier: 0.9\n";
    let ros_2 = "diff_cont:\n  ros__parameters:\n    left_wheel_names: [left_wheel]\n    right_wheel_names: [right_wheel]\n    \
                 wheel_separation: 0.32\n    wheel_radius: 0.04\n";
    vec![
        both(
            "a controller of ROS 1 with multipliers of the URDF's lengths",
            &round,
            ros_1,
            "r = 0.045 m, b = 0.225 m, right: right_wheel, left: left_wheel",
            &[],
        ),
        both(
            "meshes, and a controller with lengths",
            &meshes,
            ros_2,
            "r = 0.04 m, b = 0.16 m, right: right_wheel, left: left_wheel",
            &[],
        ),
        both(
            "a controller against the shapes",
            &round,
            ros_2,
            "r = 0.04 m, b = 0.16 m, right: right_wheel, left: left_wheel",
            &[
                "contradict each other about the wheel radius: 0.04 m (wheel_radius of diff_cont) is taken",
            ],
        ),
        both(
            "a controller of other joints",
            &round,
            &ros_2.replace("[left_wheel]", "[wheel_l]"),
            "r = 0.04 m, b = 0.16 m, right: right_wheel, left: left_wheel",
            &["names joints that the URDF does not have: wheel_l"],
        ),
        both(
            "a controller with the sides exchanged",
            &round,
            &ros_1.replace(
                "left_wheel: left_wheel\n  right_wheel: right_wheel",
                "left_wheel: right_wheel\n  right_wheel: left_wheel",
            ),
            "r = 0.045 m, b = 0.225 m, right: right_wheel, left: left_wheel",
            &["against base_controller"],
        ),
    ]
}
