//! Masses and normal forces of one robot: Eq. 3 to 6, with payloads.

use crate::constants::GRAVITY_M_S2;
use crate::physics::Physics;
use crate::state::{N, Velocity};

/// The constant masses and inertias of a robot.
#[derive(Debug, Clone)]
pub(crate) struct Body {
    /// Total mass (kg).
    pub(crate) mass: f64,
    /// First moment of mass about c, forward and left (kg m).
    pub(crate) moment: [f64; 2],
    /// Inverse of the mass matrix without constraints.
    pub(crate) inverse: [Velocity; N],
    /// Normal component of the total weight (N).
    pub(crate) weight: f64,
    /// N_ca without acceleration (N).
    pub(crate) caster_n: f64,
    /// N_r − N_l due to payloads (N).
    offset_n: f64,
    /// h / b.
    tilt: f64,
    /// Decrease of N_ca per acceleration (N s²/m).
    transfer: f64,
}

impl Body {
    /// The body of a robot whose wheel speeds are `prescribed` or result from torques.
    pub(crate) fn new(physics: &Physics, prescribed: bool) -> Self {
        let p = physics;
        let own = p.body_mass + 2.0 * p.wheel_mass;
        let load: f64 = p.payloads.iter().map(|[m, ..]| m).sum();
        let load_x: f64 = p.payloads.iter().map(|[m, x, _]| m * x).sum();
        let load_y: f64 = p.payloads.iter().map(|[m, _, y]| m * y).sum();
        let load_i: f64 = p.payloads.iter().map(|[m, x, y]| m * (x * x + y * y)).sum();
        // An effective track moves neither masses nor wheels.
        let [_, half_track] = p.nominal;
        let arm = half_track * half_track + p.to_axle * p.to_axle;
        let mass = own + load;
        let moment = [load_x - 2.0 * p.wheel_mass * p.to_axle, load_y];
        let inertia =
            p.body_inertia + 2.0 * p.wheel_yaw_inertia + 2.0 * p.wheel_mass * arm + load_i;
        let span = p.to_axle + p.to_caster;
        // Component of g along the floor's normal.
        let steep = p.grade[0].hypot(p.grade[1]);
        let g = GRAVITY_M_S2 * steep.atan().cos();
        Self {
            mass,
            moment,
            inverse: inverse(mass, moment, inertia, spin(physics, prescribed)),
            weight: mass * g,
            caster_n: (own * p.to_axle + load * p.to_axle + load_x) * g / span,
            offset_n: -load_y * g / half_track,
            tilt: p.height / half_track,
            transfer: mass * p.transfer_height / span,
        }
    }

    /// N_r, N_l and N_ca (N) at a lateral force of both wheels (N) and an acceleration of c along the
    /// body (m/s²). Eq. 4 to 6.
    pub(crate) fn normal(&self, lateral_n: f64, along_m_s2: f64) -> [f64; 3] {
        let caster = (self.caster_n - self.transfer * along_m_s2).clamp(0.0, self.weight);
        let driven = self.weight - caster;
        let difference = (self.tilt * lateral_n + self.offset_n).clamp(-driven, driven);
        [
            (driven + difference) / 2.0,
            (driven - difference) / 2.0,
            caster,
        ]
    }

    /// Whether the normal forces depend on the acceleration.
    pub(crate) fn has_load_transfer(&self) -> bool {
        self.transfer != 0.0
    }
}

/// 1 / inertia of right wheel, left wheel, right motor and left motor; 0 if its speed is prescribed or
/// there is no separate motor.
fn spin(physics: &Physics, prescribed: bool) -> [f64; 4] {
    let wheel = 1.0 / physics.spin_inertia;
    let [wheel, motor] = if physics.gap > 0.0 {
        [wheel / 0.75, wheel / 0.25]
    } else {
        [wheel, 0.0]
    };
    match (prescribed, physics.gap > 0.0) {
        (false, _) => [wheel, wheel, motor, motor],
        (true, true) => [wheel, wheel, 0.0, 0.0],
        (true, false) => [0.0; 4],
    }
}

fn inverse(mass: f64, [sx, sy]: [f64; 2], inertia: f64, spin: [f64; 4]) -> [Velocity; N] {
    // Inverse of [m 0 −sy; 0 m sx; −sy sx I] by its Schur complement.
    let about_centre = inertia - (sx * sx + sy * sy) / mass;
    let (x, y) = (sx / mass, sy / mass);
    let turn = 1.0 / about_centre;
    let mut inverse = [[0.0; N]; N];
    inverse[0][..3].copy_from_slice(&[1.0 / mass + y * y * turn, -x * y * turn, y * turn]);
    inverse[1][..3].copy_from_slice(&[-x * y * turn, 1.0 / mass + x * x * turn, -x * turn]);
    inverse[2][..3].copy_from_slice(&[y * turn, -x * turn, turn]);
    for (i, value) in spin.into_iter().enumerate() {
        inverse[3 + i][3 + i] = value;
    }
    inverse
}

#[cfg(test)]
mod tests {
    use super::*;
    use slipstream_bus::RobotModel;

    #[test]
    fn the_inverse_times_the_mass_matrix_is_one() {
        let model = RobotModel::default()
            .with("payload", &[("mass_kg", 0.3), ("x_m", 0.02), ("y_m", 0.04)]);
        let physics = Physics::new(&model).unwrap();
        let body = Body::new(&physics, false);
        let [sx, sy] = body.moment;
        let arm = 0.105f64.powi(2) + 0.055f64.powi(2);
        let inertia = 0.009_753 + 2.0 * 0.000_584 + 0.128 * arm + 0.3 * (0.0004 + 0.0016);
        let mass = [
            [body.mass, 0.0, -sy],
            [0.0, body.mass, sx],
            [-sy, sx, inertia],
        ];
        for (i, row) in mass.iter().enumerate() {
            for j in 0..3 {
                let product: f64 = (0..3).map(|k| row[k] * body.inverse[k][j]).sum();
                assert!((product - f64::from(u8::from(i == j))).abs() < 1e-12);
            }
        }
    }

    #[test]
    fn normal_forces_balance() {
        let body = Body::new(&Physics::new(&RobotModel::default()).unwrap(), false);
        let [right, left, caster] = body.normal(2.0, 0.0);
        // Eq. 4, 5 and 6.
        assert!((right + left + caster - 1.628 * 9.81).abs() < 1e-12);
        assert!((2.0 * 0.0216 + left * 0.105 - right * 0.105).abs() < 1e-12);
        assert!((caster * 0.15 - 1.628 * 9.81 * 0.055).abs() < 1e-12);
    }
}
