//! Smooth forces on a robot at the midpoint of a step.

use crate::law::Gives;
use crate::physics::Push;
use crate::plant::Plant;
use crate::state::{State, Velocity};

impl Plant {
    /// Smooth forces at the midpoint of a step of `h` (s): inertial forces of Eq. 3 in the body frame,
    /// drag, gravity on a slope, pushes, laws, disturbances and effects outside the vocabulary.
    pub(crate) fn smooth_forces(&self, state: &State, middle: &Velocity, h: f64) -> Velocity {
        let (p, body) = (&self.physics, &self.body);
        let [u, v, w, ..] = *middle;
        let [sx, sy] = body.moment;
        let yaw = state.pose[2] + w * h / 2.0;
        let (sin, cos) = yaw.sin_cos();
        let t_s = state.t_s + h / 2.0;
        let drag = p.drag + p.square_drag * u.hypot(v);
        let mut force = [
            (body.mass * v + sx * w) * w - drag * u + state.disturbance[0],
            (sy * w - body.mass * u) * w - drag * v + state.disturbance[1],
            -(sx * u + sy * v) * w + state.disturbance[2],
            state.wheel_disturbance[0],
            state.wheel_disturbance[1],
            0.0,
            0.0,
        ];
        let mut add = |[x, y]: [f64; 2], lever: [f64; 2], moment: f64| {
            let (along, across) = (x * cos + y * sin, y * cos - x * sin);
            force[0] += along;
            force[1] += across;
            force[2] += moment + lever[0] * across - lever[1] * along;
        };
        let lever = [sx / body.mass, sy / body.mass];
        add(p.grade.map(|grade| body.weight * grade), lever, 0.0);
        for push in &p.pushes {
            if t_s > push.t_s && t_s < push.t_s + Push::DURATION_S {
                add(
                    push.impulse.map(|part| part / Push::DURATION_S),
                    [0.0; 2],
                    0.0,
                );
            }
        }
        let x = state.pose[0] + (u * cos - v * sin) * h / 2.0;
        let y = state.pose[1] + (u * sin + v * cos) * h / 2.0;
        for outside in &p.outside {
            let [fx, fy, moment] = outside.wrench(t_s, [x, y, yaw], w);
            add([fx, fy], [0.0; 2], moment);
        }
        for law in &p.laws {
            let given = law.at(t_s, [x, y, yaw], [u, w]);
            match law.gives {
                Gives::Force => force[0] += given,
                Gives::Moment => force[2] += given,
                Gives::Speed | Gives::TurnRate => {}
            }
        }
        for outside in &p.outside {
            for i in 0..2 {
                force[3 + i] += outside.torque(state.wheel[i] + middle[3 + i] * h / 2.0);
            }
        }
        force
    }
}
