use slipstream_sim::effects::CATALOGUE;

use super::*;
use crate::ParameterEstimate;
use crate::fixture::finding;
use crate::setup::Told;

/// The actions of a finding on a robot of ROS with these commands, its poses those of the axle.
fn told(told: Told, finding: &Finding) -> Vec<String> {
    of_robot(told, true, finding)
}

fn of_robot(told: Told, has_ros: bool, finding: &Finding) -> Vec<String> {
    let model = RobotModel::default();
    let setup = Setup {
        model: &model,
        told,
        has_ros,
        has_wheels: true,
        counts_per_turn: Some(1856.0),
        declared_ahead_m: 0.0,
    };
    actions(finding, &setup)
}

#[test]
fn every_effect_of_the_catalogue_has_an_action_of_its_own() {
    let model = RobotModel::default();
    for info in CATALOGUE {
        let numbers = info.parameters.iter().filter(|own| own.unit != "text");
        let numbers: Vec<_> = numbers.map(|own| (own.name, 0.9, 0.02)).collect();
        let own = finding(info.id, &numbers);
        let kinds = [
            Told::Nothing,
            Told::Twist,
            Told::WheelSpeed,
            Told::Torque,
            Told::Voltage,
        ];
        for told in kinds {
            let setup = Setup {
                model: &model,
                told,
                has_ros: true,
                has_wheels: true,
                counts_per_turn: None,
                declared_ahead_m: 0.0,
            };
            let actions = of_effect(&own, &setup);
            let actions = actions.unwrap_or_else(|| panic!("{} has no action", info.id));
            assert!(!actions.is_empty(), "{}", info.id);
            for action in actions {
                let is_whole =
                    action.is_ascii() && !action.contains("NaN") && !action.ends_with('.');
                assert!(is_whole, "{}: {action}", info.id);
                assert!(action.starts_with(char::is_lowercase), "{action}");
            }
        }
    }
}

#[test]
fn radii_are_multipliers_where_a_controller_computes_wheel_speeds() {
    let own = finding(
        "wheel_radius",
        &[("right_scale", 0.9571, 0.002), ("left_scale", 0.951, 0.002)],
    );
    let multipliers = "set left_wheel_radius_multiplier to 0.9510 and right_wheel_radius_multiplier to 0.9571 \
                       in diff_drive_controller";
    assert_eq!(told(Told::Twist, &own), [multipliers]);
    assert_eq!(told(Told::Nothing, &own), [multipliers]);
    let lengths = "0.03471 m (left) and 0.03493 m (right)";
    assert_eq!(
        told(Told::WheelSpeed, &own),
        [
            multipliers.to_owned(),
            format!("use wheel radii of {lengths} where speeds of the body become wheel speeds")
        ]
    );
    assert_eq!(
        told(Told::Torque, &own)[0],
        format!("use wheel radii of {lengths} in odometry and simulator")
    );
}

#[test]
fn a_track_is_a_multiplier() {
    let own = finding("track_width", &[("scale", 1.45, 0.02)]);
    assert_eq!(
        told(Told::Twist, &own),
        ["set wheel_separation_multiplier to 1.450 in diff_drive_controller"]
    );
    assert_eq!(
        told(Told::WheelSpeed, &own)[1],
        "use 0.3045 m between the wheels where turn rates become wheel speeds"
    );
}

#[test]
fn slip_keeps_the_radius() {
    let own = finding(
        "slip_ratio",
        &[("ratio", 0.07, 0.004), ("asymmetry", 0.01, 0.004)],
    );
    let [keep, travel] = told(Told::Twist, &own).try_into().unwrap();
    assert_eq!(
        keep,
        "keep the wheel radii: the floor takes this, not the wheels"
    );
    assert_eq!(
        travel,
        "multiply the measured travel of the wheels by 0.9350 (left) and 0.9250 (right) on this floor"
    );
}

#[test]
fn what_changed_is_set_to_what_it_is_today() {
    let mut own = finding(
        "wheel_radius",
        &[("right_scale", 0.957, 0.002), ("left_scale", 0.99, 0.002)],
    );
    own.parameters[0].nominal = Some(0.99);
    own.parameters[1].nominal = Some(0.99);
    assert_eq!(
        told(Told::Twist, &own),
        [
            "set left_wheel_radius_multiplier to 0.9900 and right_wheel_radius_multiplier to 0.9570 (was 0.9900) \
          in diff_drive_controller"
        ]
    );
    let mut late = finding("pose_latency", &[("latency_s", 0.08, 0.004)]);
    late.parameters[0].nominal = Some(-0.02);
    assert_eq!(
        told(Told::Twist, &late),
        ["stamp the poses 0.0800 s earlier (was 0.0200 s later)"]
    );
}

#[test]
fn a_pose_sensor_is_placed_from_the_axle() {
    let offset = [
        ("x_m", 0.12, 0.02),
        ("y_m", 0.03, 0.02),
        ("yaw_rad", -0.0001, 0.02),
    ];
    let own = finding("pose_offset", &offset);
    let model = RobotModel::default();
    let setup = Setup {
        model: &model,
        told: Told::Twist,
        has_ros: true,
        has_wheels: true,
        counts_per_turn: None,
        declared_ahead_m: 0.055,
    };
    assert_eq!(
        actions(&own, &setup),
        [
            "set x to 0.175 m and y to 0.030 m in the transform of the camera or laser, from the middle of the axle; keep \
             its other numbers"
        ]
    );
    let turned = finding("pose_offset", &[("yaw_rad", 0.05, 0.002)]);
    assert_eq!(
        actions(&turned, &setup),
        ["set yaw to 0.0500 rad in the transform of the camera or laser; keep its other numbers"]
    );
}

/// A robot without ROS has no parameters of its packages.
#[test]
fn a_robot_without_ros_is_told_no_parameter_of_ros() {
    for info in CATALOGUE {
        let numbers = info.parameters.iter().filter(|own| own.unit != "text");
        let numbers: Vec<_> = numbers.map(|own| (own.name, 0.9, 0.02)).collect();
        let own = finding(info.id, &numbers);
        for told in [Told::Nothing, Told::Twist, Told::Torque] {
            let actions = of_robot(told, false, &own).join("; ");
            for word in [
                "diff_drive_controller",
                "multiplier",
                "<dynamics>",
                "hardware interface",
            ] {
                assert!(!actions.contains(word), "{}: {actions}", info.id);
            }
        }
    }
    let track = finding("track_width", &[("scale", 1.1, 0.002)]);
    assert_eq!(
        of_robot(Told::Twist, false, &track),
        ["use 0.23100 m between the wheels where turn rates become wheel speeds"]
    );
}

#[test]
fn encoders_are_told_in_counts() {
    let own = finding(
        "encoder_scale",
        &[
            ("right_scale", 1.0001, 0.0003),
            ("left_scale", 0.98, 0.0003),
        ],
    );
    assert_eq!(
        told(Told::Twist, &own)[0],
        "set counts per turn to 1818.9 (left) and 1856.2 (right) in the hardware interface"
    );
}

#[test]
fn stamps_and_messages_say_how_much() {
    let mut drift = finding("clock_drift", &[("rate", 1.2e-4, 1e-5)]);
    drift
        .parameters
        .push(ParameterEstimate::word("stream", "imu"));
    assert_eq!(
        told(Told::Twist, &drift)[1],
        "divide the stamps of the imu stream by 1.000120 in recordings made so far"
    );
    let link = finding("link_delay", &[("delay_s", 0.12, 0.001)]);
    assert_eq!(
        told(Told::Twist, &link)[1],
        "move each received position 0.1200 s ahead along its velocity"
    );
}

#[test]
fn a_drive_is_corrected_in_the_quantity_that_is_commanded() {
    let gain = finding("motor_gain", &[("right", 0.95, 0.01), ("left", 1.02, 0.01)]);
    let numbers = "command of the left wheel by 1.020 and that of the right by 0.950";
    assert_eq!(
        told(Told::Torque, &gain),
        [format!("divide the torque {numbers}")]
    );
    let [divide, keep] = told(Told::Twist, &gain).try_into().unwrap();
    assert_eq!(
        divide,
        format!("divide the speed {numbers} in the hardware interface")
    );
    assert!(keep.starts_with("keep the wheel radii"), "{keep}");
    let delay = finding("actuator_delay", &[("delay_s", 0.12, 0.002)]);
    assert_eq!(
        told(Told::Twist, &delay)[0],
        "apply commands 0.1200 s late in the simulator"
    );
    let most = finding("command_saturation", &[("speed_rad_s", 12.3, 0.2)]);
    assert_eq!(
        told(Told::Twist, &most)[1],
        "set linear.x.max_velocity to 0.449 or less in diff_drive_controller, and plan |v| + 0.105 |w| below that"
    );
    let zone = finding("command_dead_zone", &[("voltage_v", 0.21, 0.02)]);
    assert!(told(Told::Voltage, &zone)[0].starts_with("add 0.210 V to the voltage command"));
}

#[test]
fn forces_go_into_the_model() {
    let slip = finding(
        "wheel_slip",
        &[
            ("friction_static", 0.24, 0.004),
            ("friction_kinetic", 0.236, 0.004),
        ],
    );
    assert_eq!(
        told(Told::Torque, &slip),
        [
            "clean the wheels and the floor",
            "command each wheel less than 0.0920 N m",
            "set wheel_slip = { friction_static = 0.2400, friction_kinetic = 0.2360 } in [effects] of robot.toml",
        ]
    );
    let patch = finding(
        "friction_patch",
        &[
            ("x_m", 1.2, 0.02),
            ("y_m", -0.4, 0.02),
            ("radius_m", 0.3, 0.02),
            ("friction", 0.1, 0.02),
        ],
    );
    assert_eq!(
        told(Told::Torque, &patch)[1],
        "set friction_patch = [{ x_m = 1.200, y_m = -0.400, radius_m = 0.300, friction = 0.100 }] in [effects] of \
         robot.toml"
    );
    let axle = finding("axle_friction", &[("torque_nm", 0.0031, 0.0002)]);
    assert_eq!(
        told(Told::Torque, &axle)[0],
        "set friction=\"0.00310\" in <dynamics> of both wheel joints (N m)"
    );
}

#[test]
fn a_push_is_left_out() {
    let own = finding("push", &[("t_s", 12.5, 0.004), ("impulse_n_s", 0.1, 0.01)]);
    assert_eq!(
        told(Told::Torque, &own),
        ["leave this moment out: --exclude-time 12.44:12.62"]
    );
}

#[test]
fn the_unknown_points_to_a_law_only_where_there_is_one() {
    let mut own = finding("unknown", &[]);
    own.driver = Some("w".to_owned());
    let without = told(Told::Twist, &own);
    assert_eq!(
        without[0],
        "look on the robot and the floor for what depends on the turn rate"
    );
    assert!(without[1].starts_with("record this to see more of it: stop-and-go"));
    let mut model = RobotModel::default().with("motion_law", &[]);
    let driver = slipstream_bus::Parameter::Text("w".to_owned());
    model.effects[0]
        .parameters
        .push(("driver".to_owned(), driver));
    let setup = Setup {
        model: &model,
        told: Told::Twist,
        has_ros: true,
        has_wheels: true,
        counts_per_turn: None,
        declared_ahead_m: 0.0,
    };
    assert_eq!(
        actions(&own, &setup)[0],
        "use the law over w that --improved writes"
    );
}

#[test]
fn runs_and_look_alikes_are_named() {
    let mut own = finding("track_width", &[("scale", 1.45, 0.02)]);
    own.runs = Some(vec!["ice".to_owned(), "sand".to_owned()]);
    own.confused_with = vec!["yaw_scrub".to_owned()];
    let [set, record] = told(Told::Twist, &own).try_into().unwrap();
    assert_eq!(
        set,
        "for ice, sand: set wheel_separation_multiplier to 1.450 in diff_drive_controller"
    );
    assert!(
        record.starts_with("record this to tell it from yaw_scrub: spin in place"),
        "{record}"
    );
}

#[test]
fn a_model_gets_three_digits_at_least() {
    let own = finding(
        "wheel_slip",
        &[
            ("friction_static", 0.224, 0.05),
            ("friction_kinetic", 0.2236, 0.004),
        ],
    );
    assert_eq!(
        told(Told::Torque, &own)[2],
        "set wheel_slip = { friction_static = 0.224, friction_kinetic = 0.2236 } in [effects] of robot.toml"
    );
    let load = [
        ("mass_kg", 0.3, 0.02),
        ("x_m", 0.02, 0.02),
        ("y_m", -0.03, 0.02),
    ];
    assert_eq!(
        told(Told::Torque, &finding("payload", &load))[0],
        "add a point mass of 0.300 kg to the model at x = 0.020 m, y = -0.030 m from the centre of mass"
    );
}

#[test]
fn an_experiment_that_the_statement_names_is_not_said_twice() {
    let mut own = finding("track_width", &[("scale", 1.45, 0.02)]);
    own.confused_with = vec!["yaw_scrub".to_owned()];
    own.actions = told(Told::Twist, &own);
    assert_eq!(own.actions_beside_statement().count(), 2);
    let which = manoeuvre(&["track_width", "yaw_scrub"]);
    own.statement = format!("This recording cannot tell it from yaw_scrub; what would: {which}.");
    assert_eq!(own.actions_beside_statement().count(), 1);
}
