//! Draws a scene for the specification of a case.

use slipstream_bus::{EffectSpec, Parameter, RobotModel};
use slipstream_sim::effects::find;
use slipstream_trial_plant::Physics;

use super::case_spec::{Begin, CaseSpec};
use crate::maker::draw_effect::{Setting, effect, outside_effect};
use crate::maker::manoeuvre::{CommandKind, Style};
use crate::maker::process_noise::draw_noise;
use crate::maker::random::RandomStream;
use crate::maker::scene::{Camera, Control, Recorded, Scene, Start, TrueRobot};
use crate::maker::simulate::simulate;

/// Draws a scene from a seed.
///
/// # Errors
/// A model that cannot be simulated.
pub(super) fn draw_scene(spec: &CaseSpec, seed: u64) -> Result<Scene, String> {
    let mut random = RandomStream::new(seed, 0);
    let slides = spec.needs(&["wheel_slip", "friction_patch", "load_transfer"]);
    let needs_no_masses = |id: &&str| find(id).is_some_and(|info| info.kinematic);
    let kinematic = spec.effects.iter().all(needs_no_masses) && spec.outside.is_none();
    let control = spec.control.unwrap_or_else(|| control(spec, &mut random));
    let command_kind = spec
        .command_kind
        .unwrap_or_else(|| command_kind(control, kinematic && !slides, spec, &mut random));
    let speeds = matches!(command_kind, CommandKind::Twist | CommandKind::WheelSpeed);
    let style = spec
        .style
        .unwrap_or_else(|| style(slides, speeds, spec, &mut random));
    let duration_s = duration_s(slides, spec, &mut random);
    let robots = if control == Control::Platoon { 3 } else { 1 };
    let robot = robot(robots, spec, &mut random);
    let cameras: Vec<Camera> = (0..robots)
        .map(|i| camera(i == robot, spec, &mut random))
        .map(|drawn| spec.streams.map_or(drawn, |streams| streams.camera))
        .collect();
    let mut scene = Scene {
        kind: spec.kind.clone(),
        nominal: nominal(spec, speeds, &mut random),
        robots: cameras
            .iter()
            .map(|&camera| TrueRobot {
                concealed: Vec::new(),
                outside: None,
                camera,
            })
            .collect(),
        control,
        command_kind,
        style,
        duration_s,
        imu: spec.needs(&["imu_latency"]) || random.bernoulli(0.25) && !speeds,
        disturbance_n: if spec.disturbed {
            random.log_uniform(0.003, 0.03)
        } else {
            0.0
        },
        noise: None,
        recorded: Recorded::default(),
        start: Start::Rest,
        step_s: spec.step_s,
        without: if spec.withheld {
            vec![spec.effects[0].to_owned()]
        } else {
            Vec::new()
        },
        seed,
    };
    complete(spec, &mut scene, speeds)?;
    conceal(spec, &mut scene, robot, &mut random)?;
    if let (Begin::Pressing, Some(band)) = (spec.start, dead_band(&scene.robots[robot].concealed)) {
        scene.start = Start::Pressing {
            command: 0.8 * band,
            for_s: 2.0,
        };
    }
    Ok(scene)
}

/// Adds process noise, the streams of a robot without known masses, and how the recording starts. It has
/// random numbers of its own, so that it does not change what else is drawn.
fn complete(spec: &CaseSpec, scene: &mut Scene, speeds: bool) -> Result<(), String> {
    let mut random = RandomStream::new(scene.seed, 4);
    if let Some((kind, size)) = spec.noise {
        let nominal = Physics::new(&scene.nominal)?;
        scene.noise = Some(draw_noise(kind, size, speeds, &nominal, &mut random));
    }
    if let Some(streams) = spec.streams {
        scene.imu = streams.gyro;
        scene.recorded = Recorded {
            wheels: streams.wheels,
            accelerometer: false,
            masses: false,
        };
    }
    scene.start = match spec.start {
        Begin::Rest | Begin::InPatch | Begin::Pressing => Start::Rest,
        Begin::Moving => Start::Moving,
        Begin::Sliding => Start::Sliding {
            sideways_m_s: (random.sign() * random.uniform(0.1, 0.25) * 1e6).round() / 1e6,
        },
    };
    Ok(())
}

/// The size of a concealed dead band (N m or rad/s).
fn dead_band(concealed: &[EffectSpec]) -> Option<f64> {
    let band = concealed
        .iter()
        .find(|effect| effect.effect == "command_dead_band")?;
    band.parameters.iter().find_map(|(_, value)| match value {
        Parameter::Number(number) => Some(*number),
        Parameter::Text(_) | Parameter::List(_) => None,
    })
}

/// Moves a friction patch to where the wheels stand at first.
fn under_the_wheels(effect: &mut EffectSpec, path: &[[f64; 3]], to_axle_m: f64) {
    let [x, y, yaw] = path.first().copied().unwrap_or([0.0; 3]);
    let centre = [x - to_axle_m * yaw.cos(), y - to_axle_m * yaw.sin()];
    for (name, value) in &mut effect.parameters {
        let place = match name.as_str() {
            "x_m" => centre[0],
            "y_m" => centre[1],
            _ => continue,
        };
        *value = Parameter::Number((place * 1e6).round() / 1e6);
    }
}

/// Draws the concealed effects; some depend on the robot's path without them.
fn conceal(
    spec: &CaseSpec,
    scene: &mut Scene,
    robot: usize,
    random: &mut RandomStream,
) -> Result<(), String> {
    let needs_path = spec.needs(&["friction_patch"]) || spec.outside.is_some();
    let path = if needs_path {
        simulate(scene)?.robots.swap_remove(robot).truth.poses
    } else {
        Vec::new()
    };
    let setting = Setting {
        speeds: matches!(
            scene.command_kind,
            CommandKind::Twist | CommandKind::WheelSpeed
        ),
        duration_s: scene.duration_s,
        path: &path,
        imu: scene.imu,
        camera: scene.robots[robot].camera != Camera::Absent,
        wheels: scene.recorded.wheels,
    };
    let mut size = || spec.size.unwrap_or_else(|| random.unit());
    let sizes: Vec<f64> = spec.effects.iter().map(|_| size()).collect();
    let outside_size = size();
    for (id, size) in spec.effects.iter().zip(sizes) {
        let mut effect = effect(id, size, &setting, random);
        if *id == "friction_patch" && spec.start == Begin::InPatch {
            let to_axle_m = scene.nominal.robot.com_to_axle_m.unwrap_or(0.0);
            under_the_wheels(&mut effect, &path, to_axle_m);
        }
        scene.robots[robot].concealed.push(effect);
    }
    scene.robots[robot].outside = spec
        .outside
        .map(|kind| outside_effect(kind, outside_size, &setting, random));
    Ok(())
}

/// Draws the driving style; `slides`: the effects need sliding wheels, `speeds`: commands are speeds.
fn style(slides: bool, speeds: bool, spec: &CaseSpec, random: &mut RandomStream) -> Style {
    match random.unit() {
        _ if slides => Style::Wild,
        ..0.15 if spec.outside.is_none() => Style::Cruise,
        ..0.3 if !speeds => Style::Wild,
        _ => Style::Lively,
    }
}

/// Draws the length of the recording, in steps of half a second (s).
fn duration_s(slides: bool, spec: &CaseSpec, random: &mut RandomStream) -> f64 {
    let short = spec.outside.is_none() && !slides && random.bernoulli(0.1);
    let duration_s = if short {
        random.uniform(9.0, 13.0)
    } else {
        random.uniform(20.0, 40.0)
    };
    (duration_s / 0.5).round() * 0.5
}

/// Draws which of the robots has the concealed effects; only a follower can have a link delay.
fn robot(robots: usize, spec: &CaseSpec, random: &mut RandomStream) -> usize {
    if spec.needs(&["link_delay"]) {
        1 + usize::from(random.bernoulli(0.5))
    } else {
        (random.unit() * robots as f64) as usize
    }
}

/// Draws who decides on the commands.
fn control(spec: &CaseSpec, random: &mut RandomStream) -> Control {
    match random.unit() {
        _ if spec.needs(&["link_delay"]) => Control::Platoon,
        ..0.55 => Control::Open,
        ..0.87 => Control::Closed,
        _ => Control::Platoon,
    }
}

/// Draws the kind of command; `kinematic`: the concealed effects need no masses.
fn command_kind(
    control: Control,
    kinematic: bool,
    spec: &CaseSpec,
    random: &mut RandomStream,
) -> CommandKind {
    let limits = spec.needs(&["command_dead_band", "command_saturation"]);
    match random.unit() {
        _ if control != Control::Open => CommandKind::Torque,
        ..0.25 if kinematic => CommandKind::Twist,
        ..0.4 if kinematic => CommandKind::WheelSpeed,
        ..0.55 if !limits => CommandKind::Voltage,
        _ => CommandKind::Torque,
    }
}

/// Draws the camera's view of a robot; `concealed`: this robot has the concealed effects.
fn camera(concealed: bool, spec: &CaseSpec, random: &mut RandomStream) -> Camera {
    let tracked = spec.needs(&[
        "pose_offset",
        "pose_latency",
        "wheel_radius",
        "track_width",
        "encoder_scale",
    ]);
    match random.unit() {
        _ if concealed && tracked => Camera::Pose,
        ..0.12 => Camera::Absent,
        ..0.2 => Camera::Position,
        _ => Camera::Pose,
    }
}

/// Draws the nominal model: the paper's robot or one like it, with or without wheel slip.
fn nominal(spec: &CaseSpec, speeds: bool, random: &mut RandomStream) -> RobotModel {
    let mut model = RobotModel::default();
    if random.bernoulli(0.3) {
        let body = &mut model.robot;
        let scale = |value: &mut Option<f64>, random: &mut RandomStream| {
            *value = value.map(|value| (value * random.uniform(0.8, 1.25) * 1e6).round() / 1e6);
        };
        for value in [
            &mut body.body_mass_kg,
            &mut body.body_yaw_inertia_kg_m2,
            &mut body.wheel_spin_inertia_kg_m2,
            &mut body.com_to_axle_m,
            &mut body.com_to_caster_m,
        ] {
            scale(value, random);
        }
    }
    let slips = spec.needs(&["load_transfer"]) || random.bernoulli(0.4);
    if slips && !speeds && !spec.needs(&["wheel_slip"]) {
        model = model.with(
            "wheel_slip",
            &[("friction_static", 0.241), ("friction_kinetic", 0.239)],
        );
    }
    model
}
