//! Effects outside the vocabulary, to test whether a diagnosis reports an unknown effect.

use crate::state::State;

/// An effect that the vocabulary does not contain.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum OutsideEffect {
    /// A strip of carpet: a force of constant size against the motion between two values of x.
    Carpet {
        /// Where it begins and ends (m).
        x_m: [f64; 2],
        /// Its size (N).
        force_n: f64,
    },
    /// Cogging: a torque on each wheel that varies sinusoidally with its angle.
    Cogging {
        /// Its size (N m).
        torque_nm: f64,
        /// Periods per revolution.
        per_turn: f64,
    },
    /// A gust of wind in a fixed direction: half a sine over time.
    Gust {
        /// Its largest force (N).
        force_n: f64,
        /// Direction of the force in the world frame (rad).
        direction_rad: f64,
        /// When it begins and ends (s).
        t_s: [f64; 2],
    },
    /// A cable that pulls the robot towards a heading.
    Tether {
        /// Its largest moment (N m).
        moment_nm: f64,
        /// The heading (rad).
        heading_rad: f64,
    },
    /// Stribeck friction: a drag that is largest at rest and decays with speed.
    Stribeck {
        /// At rest (N).
        force_n: f64,
        /// Speed at which it has decayed to 1/e (m/s).
        speed_m_s: f64,
    },
    /// A soft floor that the robot sinks into at rest and leaves in motion.
    Sticking {
        /// Its final size (N).
        force_n: f64,
        /// Time constant of sinking in (s).
        time_s: f64,
    },
    /// A moment against turning, proportional to the square of the yaw rate.
    Paddle {
        /// Its size (N m s²/rad²).
        moment_nm_s2: f64,
    },
    /// A floor undulating along x.
    Waves {
        /// Largest force (N).
        force_n: f64,
        /// Wavelength (m).
        length_m: f64,
    },
}

/// Time constant in which a moving robot leaves a soft floor (s).
const RELEASE_S: f64 = 0.15;

impl OutsideEffect {
    /// Its name in labels, the drivers it depends on and the channels it shows in.
    pub fn describe(
        &self,
    ) -> (
        &'static str,
        &'static [&'static str],
        &'static [&'static str],
    ) {
        const ALONG: &[&str] = &["longitudinal", "wheel_right", "wheel_left"];
        const PLANE: &[&str] = &[
            "longitudinal",
            "lateral",
            "yaw",
            "wheel_right",
            "wheel_left",
        ];
        const TURN: &[&str] = &["yaw", "wheel_right", "wheel_left"];
        const WHEELS: &[&str] = &["wheel_right", "wheel_left", "longitudinal", "yaw"];
        match self {
            Self::Carpet { .. } => ("carpet_strip", &["x", "position"], ALONG),
            Self::Cogging { .. } => ("cogging", &["wheel_angle"], WHEELS),
            Self::Gust { .. } => ("gust", &["t"], PLANE),
            Self::Tether { .. } => ("tether", &["heading"], TURN),
            Self::Stribeck { .. } => ("stribeck", &["v"], ALONG),
            Self::Sticking { .. } => ("sticking", &["time_at_rest", "v"], ALONG),
            Self::Paddle { .. } => ("paddle", &["w"], TURN),
            Self::Waves { .. } => ("waves", &["x", "position"], PLANE),
        }
    }

    /// Its parameters by name.
    pub fn parameters(&self) -> Vec<(&'static str, f64)> {
        match *self {
            Self::Carpet {
                x_m: [from, to],
                force_n,
            } => {
                vec![("x_min_m", from), ("x_max_m", to), ("force_n", force_n)]
            }
            Self::Cogging {
                torque_nm,
                per_turn,
            } => {
                vec![("torque_nm", torque_nm), ("per_turn", per_turn)]
            }
            Self::Gust {
                force_n,
                direction_rad,
                t_s: [from, to],
            } => vec![
                ("force_n", force_n),
                ("direction_rad", direction_rad),
                ("from_s", from),
                ("to_s", to),
            ],
            Self::Tether {
                moment_nm,
                heading_rad,
            } => {
                vec![("moment_nm", moment_nm), ("heading_rad", heading_rad)]
            }
            Self::Stribeck { force_n, speed_m_s } => {
                vec![("force_n", force_n), ("speed_m_s", speed_m_s)]
            }
            Self::Sticking { force_n, time_s } => vec![("force_n", force_n), ("time_s", time_s)],
            Self::Paddle { moment_nm_s2 } => vec![("moment_nm_s2", moment_nm_s2)],
            Self::Waves { force_n, length_m } => {
                vec![("force_n", force_n), ("length_m", length_m)]
            }
        }
    }

    /// Whether it acts in this state; `None` if it always acts.
    pub fn acts(&self, state: &State) -> Option<bool> {
        match *self {
            Self::Carpet {
                x_m: [from, to], ..
            } => Some((from..to).contains(&state.pose[0])),
            Self::Gust {
                t_s: [from, to], ..
            } => Some((from..to).contains(&state.t_s)),
            _ => None,
        }
    }

    /// Force in the world frame (N) and moment (N m) on c at a time, pose and yaw rate.
    pub(crate) fn wrench(&self, t_s: f64, pose: [f64; 3], rate: f64) -> [f64; 3] {
        match *self {
            Self::Gust {
                force_n,
                direction_rad,
                t_s: [from, to],
            } if t_s > from && t_s < to => {
                let size = force_n * (std::f64::consts::PI * (t_s - from) / (to - from)).sin();
                [size * direction_rad.cos(), size * direction_rad.sin(), 0.0]
            }
            Self::Tether {
                moment_nm,
                heading_rad,
            } => [0.0, 0.0, -moment_nm * (pose[2] - heading_rad).sin()],
            Self::Paddle { moment_nm_s2 } => [0.0, 0.0, -moment_nm_s2 * rate * rate.abs()],
            Self::Waves { force_n, length_m } => [
                force_n * (std::f64::consts::TAU * pose[0] / length_m).sin(),
                0.0,
                0.0,
            ],
            _ => [0.0; 3],
        }
    }

    /// Torque on a wheel at an angle (N m).
    pub(crate) fn torque(&self, angle: f64) -> f64 {
        match *self {
            Self::Cogging {
                torque_nm,
                per_turn,
            } => torque_nm * (per_turn * angle).sin(),
            _ => 0.0,
        }
    }

    /// How far the robot has settled after another `h` (s) at rest or in motion.
    pub(crate) fn settled(&self, before: f64, moves: bool, h: f64) -> f64 {
        match *self {
            Self::Sticking { .. } if moves => before * (-h / RELEASE_S).exp(),
            Self::Sticking { time_s, .. } => 1.0 - (1.0 - before) * (-h / time_s).exp(),
            _ => before,
        }
    }

    /// Limit of its dry force along the body (N); `None` if it has none.
    pub(crate) fn dry_limit(&self, state: &State) -> Option<f64> {
        match *self {
            Self::Carpet { force_n, .. } => Some(if self.acts(state) == Some(true) {
                force_n
            } else {
                0.0
            }),
            Self::Stribeck { force_n, speed_m_s } => {
                Some(force_n * (-(state.velocity[0] / speed_m_s).powi(2)).exp())
            }
            Self::Sticking { force_n, .. } => Some(force_n * state.settled),
            _ => None,
        }
    }
}
