//! What voltages make of motors: speeds, and what masses, friction and slopes take from them.
//!
//! A motor at voltage V on a wheel that rolls obeys T w' = k V − w − c sign(w) + g, all in speeds without a load: the
//! torque divided by τ_stall / ω_0. T is what the motor moves, c its Coulomb friction, g the pull of a slope along the
//! robot. Without masses T is a lag of the drive and neither c nor g can be told in N m or as a grade.

use slipstream_bus::RobotModel;
use slipstream_recording::recording::{Command, Robot};
use slipstream_sim::GRAVITY_M_S2;

/// Shares of the body that motors may move, of what the model says: a robot held in the air moves its wheels alone.
const SHARES: [f64; 2] = [0.01, 20.0];

/// The motors of a robot that is told voltages.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Volts {
    /// Speed without a load per volt (rad/s/V).
    pub(crate) speed_per_volt: f64,
    /// Where masses are known, what they do.
    pub(crate) load: Option<Load>,
}

/// What one motor moves.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Load {
    /// Speed lost per torque (rad/s per N m): ω_0 / τ_stall.
    pub(crate) speed_per_torque: f64,
    /// Inertia of a wheel, and of half of the robot at its rim (kg m²).
    wheel_kg_m2: f64,
    body_kg_m2: f64,
    /// Speed by which a slope of sine 1 pulls (rad/s): m g r ω_0 / (2 τ_stall).
    pub(crate) speed_per_sine: f64,
}

/// Sine of the angle between a slope and the robot up to which it lies along it.
const ALONG: f64 = 1e-6;

/// Effects that turn up in the closed form. With any other of the plant's, a robot is diagnosed by its plant.
const READ: [&str; 15] = [
    "actuator_delay",
    "actuator_lag",
    "axle_friction",
    "clock_drift",
    "command_dead_zone",
    "command_saturation",
    "encoder_scale",
    "floor_slope",
    "imu_latency",
    "motor_gain",
    "pose_latency",
    "supply_sag",
    "track_width",
    "wheel_radius",
    "wheels_latency",
];

/// Whether a robot follows voltages in closed form: one without masses, or of which no place is known and which has nothing
/// that the plant alone has.
pub(crate) fn applies(model: &RobotModel, has_places: bool) -> bool {
    let Some(volts) = of_model(model) else {
        return false;
    };
    let read = |effect: &str| READ.contains(&effect);
    let known = model.effects.iter().all(|own| read(&own.effect));
    // a slope across the robot does nothing to its wheels while they roll
    let downhill = model.number("floor_slope", "downhill_rad");
    let across = downhill.unwrap_or(0.0).sin();
    volts.load.is_none() || !has_places && known && across.abs() < ALONG
}

/// Whether a robot is told voltages.
pub(crate) fn is_told(robot: &Robot) -> bool {
    let told = robot.command.as_ref();
    told.is_some_and(|own| matches!(own.values, Command::Voltage { .. }))
}

/// The motors of robots that are told voltages.
pub(crate) fn of(robots: &[&Robot], model: &RobotModel) -> Option<Volts> {
    let told = robots.iter().any(|robot| is_told(robot));
    of_model(model).filter(|_| told)
}

/// The motors of a model.
pub(crate) fn of_model(model: &RobotModel) -> Option<Volts> {
    let motor = model.motor.as_ref()?;
    let body = &model.robot;
    let masses = body.body_mass_kg.zip(body.wheel_mass_kg);
    let load = masses.zip(body.wheel_spin_inertia_kg_m2);
    let load = load.map(|((body_kg, wheel_kg), wheel_kg_m2)| {
        let (r, mass_kg) = (body.wheel_radius_m, body_kg + 2.0 * wheel_kg);
        let speed_per_torque = motor.speed_per_torque();
        Load {
            speed_per_torque,
            wheel_kg_m2,
            body_kg_m2: mass_kg * r * r / 2.0,
            speed_per_sine: mass_kg * GRAVITY_M_S2 * r / 2.0 * speed_per_torque,
        }
    });
    Some(Volts {
        speed_per_volt: motor.speed_per_volt(),
        load,
    })
}

impl Load {
    /// Time constant of a wheel under voltage (s).
    pub(crate) fn lag_s(&self) -> f64 {
        (self.wheel_kg_m2 + self.body_kg_m2) * self.speed_per_torque
    }

    /// Share of the body that gives such a time constant.
    pub(crate) fn share(&self, lag_s: f64) -> f64 {
        let body_kg_m2 = lag_s / self.speed_per_torque - self.wheel_kg_m2;
        let [least, most] = SHARES;
        (body_kg_m2 / self.body_kg_m2).clamp(least, most)
    }

    /// Gives `model` this share of its masses.
    pub(crate) fn apply(share: f64, model: &mut RobotModel) {
        let body = &mut model.robot;
        let masses = [
            &mut body.body_mass_kg,
            &mut body.body_yaw_inertia_kg_m2,
            &mut body.wheel_mass_kg,
        ];
        for own in masses {
            *own = own.map(|whole| share * whole);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn load(model: &RobotModel) -> Load {
        of_model(model).and_then(|own| own.load).unwrap()
    }

    #[test]
    fn a_share_of_the_body_gives_its_time_constant() {
        let model = RobotModel::default();
        let mut less = model.clone();
        Load::apply(0.3, &mut less);
        let share = load(&model).share(load(&less).lag_s());
        assert!((share - 0.3).abs() < 1e-12, "{share}");
        assert_eq!(load(&model).share(0.0), SHARES[0]);
    }

    /// I_wy + m r² / 2 over τ_stall / ω_0, by hand for the paper's robot.
    #[test]
    fn the_time_constant_is_that_of_wheel_and_half_of_the_robot() {
        let inertia = 0.001_168 + 1.628 * 0.0365 * 0.0365 / 2.0;
        let lag_s = inertia * 36.65 / 0.78;
        assert!((load(&RobotModel::default()).lag_s() - lag_s).abs() < 1e-12);
    }

    #[test]
    fn what_the_closed_form_does_not_have_is_left_to_the_plant() {
        let plain = RobotModel::default();
        assert!(applies(&plain, false) && !applies(&plain, true));
        let drag = plain.clone().with("viscous_drag", &[("coefficient", 1.0)]);
        assert!(!applies(&drag, false));
        let mut kinematic = plain.clone();
        kinematic.robot.body_mass_kg = None;
        assert!(applies(&kinematic, true));
        let mut unpowered = plain;
        unpowered.motor = None;
        assert!(!applies(&unpowered, false));
    }
}
