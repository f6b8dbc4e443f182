//! The torque limit τ_max (Eq. 11) and the acceleration at that torque, from the paper's own numbers.

use slipstream_agents::{Geometry, normal_forces_n, torque_limit_nm};
use slipstream_bus::Experiment;
use slipstream_launch::RunError;

use super::printed::{ACCELERATION_RAD_S2, TORQUE_LIMIT_NM};
use super::row::PaperRow;
use crate::StudyError;

const TORQUE: &str = "Eq. 11, section 3";
const ACCELERATION: &str = "section 3";

/// Torque limit and acceleration as printed, and with the load transfer that Eq. 6 leaves out.
pub(super) fn rows(experiment: &Experiment) -> Result<Vec<PaperRow>, StudyError> {
    let geometry = Geometry::new(&experiment.robots[0].model).map_err(RunError::Input)?;
    let Some(dynamics) = geometry.dynamics else {
        return Ok(Vec::new());
    };
    let friction = experiment.settings.control.friction;
    let driven_n: f64 = normal_forces_n(&dynamics, &geometry, [0.0; 2]).iter().sum();
    let limit_nm = |load_n: f64| torque_limit_nm(&dynamics, &geometry, friction, load_n / 2.0);
    let acceleration = |load_n: f64| friction * load_n / dynamics.m_t / geometry.r;
    // Friction accelerates the robot by a = μ load / m_t, and m_t a h tilts it back onto the wheels.
    let base = geometry.d + dynamics.e;
    let transferred_n = driven_n / (1.0 - friction * dynamics.h / base);
    // The reaction of the wheels' spin-up, 2 I_wy a / r, adds to it.
    let spin_m = 2.0 * dynamics.i_wy / (geometry.r * dynamics.m_t);
    let reacting_n = driven_n / (1.0 - friction * (dynamics.h + spin_m) / base);
    Ok(vec![
        PaperRow::printed("torque_limit_nm", TORQUE, TORQUE_LIMIT_NM, limit_nm(driven_n))
            .note("below the printed value: Eq. 6 leaves out what acceleration adds to N"),
        PaperRow::printed(
            "torque_limit_with_load_transfer_nm",
            TORQUE,
            TORQUE_LIMIT_NM,
            limit_nm(transferred_n),
        )
        .note("with the load that acceleration shifts through h: the printed value may hold it"),
        PaperRow::printed(
            "wheel_acceleration_rad_s2",
            ACCELERATION,
            ACCELERATION_RAD_S2,
            acceleration(driven_n),
        )
        .note("μ N / m_t / r with N of Eq. 4 to 6: the printed pair of numbers does not follow from them"),
        PaperRow::printed(
            "wheel_acceleration_with_load_transfer_rad_s2",
            ACCELERATION,
            ACCELERATION_RAD_S2,
            acceleration(transferred_n),
        )
        .note("with the load shifted through h"),
        PaperRow::printed(
            "wheel_acceleration_with_load_transfer_and_spin_rad_s2",
            ACCELERATION,
            ACCELERATION_RAD_S2,
            acceleration(reacting_n),
        )
        .note(format!(
            "with the reaction of the wheels' spin too; but then the torque limit would be {:.3} N m",
            limit_nm(reacting_n)
        )),
    ])
}
