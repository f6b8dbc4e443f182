//! The paper's forms for the desired speed under delay, at one outer tick, and the frequency
//! response behind the gain from robot to robot.

use nalgebra::Complex;
use slipstream_agents::Geometry;
use slipstream_bus::experiment::Control;

use super::watch::Tick;

/// A form of the desired speed v_d on a straight line. x is the follower's place, x_r the one it
/// should have, v_r the reference speed, τ the delay.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Form {
    /// Eq. 12 without delay: v_r + k_x (x_r − x).
    Undelayed,
    /// The paper's form for the straight line, with its sign: v_r + k_x (x − x_r).
    PrintedSign,
    /// Eq. 13 as printed, numbers for the exponentials: v_r e^{−τ} + k_x (x − x_r e^{−τ}).
    Literal,
    /// Eq. 13 with the sign of Eq. 12: v_r e^{−τ} + k_x (x_r e^{−τ} − x).
    LiteralSign,
    /// The exponential read as the operator that it is: v_r(t − τ) + k_x (x_r(t − τ) − x).
    Transport,
}

impl Form {
    /// All of them.
    pub const ALL: [Self; 5] = [
        Self::Undelayed,
        Self::PrintedSign,
        Self::Literal,
        Self::LiteralSign,
        Self::Transport,
    ];

    /// In words.
    pub fn name(self) -> &'static str {
        match self {
            Self::Undelayed => "Eq. 12 without delay",
            Self::PrintedSign => "the straight-line form with its printed sign, without delay",
            Self::Literal => "Eq. 13 as printed, numbers for the exponentials",
            Self::LiteralSign => "Eq. 13 with the sign of Eq. 12, numbers for the exponentials",
            Self::Transport => "the transport delay x_r(t − τ), v_r(t − τ)",
        }
    }

    /// v_d (m/s) at a tick; `before` holds x_r and v_r a delay earlier, `fade` is e^{−τ}.
    pub fn desired_m_s(self, tick: &Tick, before: [f64; 2], fade: f64, k_x: f64) -> f64 {
        let Tick {
            x_m: x,
            x_r_m: x_r,
            v_r_m_s: v_r,
            ..
        } = *tick;
        match self {
            Self::Undelayed => v_r + k_x * (x_r - x),
            Self::PrintedSign => v_r + k_x * (x - x_r),
            Self::Literal => v_r * fade + k_x * (x - x_r * fade),
            Self::LiteralSign => v_r * fade + k_x * (x_r * fade - x),
            Self::Transport => before[1] + k_x * (before[0] - x),
        }
    }
}

/// The second line of Eq. 14: |v_r| + k_x |x − x_r| + k_x |x_r| (1 − e^{−τ}) (m/s).
pub(super) fn bound_m_s(tick: &Tick, fade: f64, k_x: f64) -> f64 {
    let error = (tick.x_m - tick.x_r_m).abs();
    tick.v_r_m_s.abs() + k_x * error + k_x * tick.x_r_m.abs() * (1.0 - fade)
}

/// The largest gain of the spacing error from one follower to the next over all frequencies, from
/// the linear model: PI wheel loops on a rolling robot, speeds measured as means over inner ticks,
/// torques and set-points held for a tick, Eq. 12, and a delay of `delay_s` (s) on every link; v_r
/// travels with the position. No slip, no limit. `None` where the model knows no masses or nobody
/// follows a follower.
///
/// It is about one frequency that goes on for ever, the worst of all; the gain of a run is the ratio
/// of the largest errors on its way through one profile, which excites little of that frequency.
pub fn string_gain(
    control: &Control,
    geometry: &Geometry,
    delay_s: f64,
    robots: u32,
) -> Option<f64> {
    // From far below k_x to the highest frequency that the outer loop can express.
    let (low, high) = (
        0.01f64.ln(),
        (std::f64::consts::PI / control.outer_period_s).ln(),
    );
    let gains = (0..=400).map(|step| {
        let omega_rad_s = (low + (high - low) * f64::from(step) / 400.0).exp();
        string_gain_at(control, geometry, delay_s, omega_rad_s, robots)
    });
    gains.reduce(|a, b| Some(a?.max(b?))).flatten()
}

/// The same at one frequency (rad/s).
pub fn string_gain_at(
    control: &Control,
    geometry: &Geometry,
    delay_s: f64,
    omega_rad_s: f64,
    robots: u32,
) -> Option<f64> {
    let dynamics = geometry.dynamics.as_ref()?;
    let inertia = dynamics.i_wy + dynamics.m_t * geometry.r * geometry.r / 2.0;
    let gain = || largest_ratio(control, inertia, delay_s, omega_rad_s, robots);
    (robots >= 3).then(gain)
}

/// max_i |E_{i+1} / E_i| at one frequency (rad/s), where E_i = X_{i−1} − X_i.
///
/// Each follower: s X_i = W h (V_i + k_x (d X_{i−1} − X_i)) with the wheel loop W, the hold h, the
/// link's delay d and V_i = d V_{i−1}; the front robot follows X = V / s by itself.
fn largest_ratio(control: &Control, inertia: f64, delay_s: f64, omega: f64, robots: u32) -> f64 {
    let s = Complex::new(0.0, omega);
    let late = |seconds: f64| Complex::from_polar(1.0, -omega * seconds);
    // Holding a value for a period, and taking the mean over one, are the same to a frequency.
    let mean = |period_s: f64| (Complex::from(1.0) - late(period_s)) / (s * period_s);
    let inner_s = control.inner_period_s;
    // What the integrator holds at a tick comes from the ticks before.
    let integral = late(inner_s) / (Complex::from(1.0) - late(inner_s)) * inner_s;
    let open = (integral * control.k_i + control.k_p) * mean(inner_s) / (s * inertia);
    let driven = open / (open * mean(inner_s) + 1.0) * mean(control.outer_period_s);
    let closed = |wish: Complex<f64>| driven * wish / (s + driven * control.k_x);
    let mut speed = Complex::new(1.0, 0.0);
    let mut place = closed(speed + s.inv() * control.k_x);
    let mut before: Option<Complex<f64>> = None;
    let mut largest = 0.0f64;
    for _ in 1..robots {
        speed *= late(delay_s);
        let next = closed(speed + place * late(delay_s) * control.k_x);
        let error = place - next;
        if let Some(before) = before {
            largest = largest.max(error.norm() / before.norm());
        }
        before = Some(error);
        place = next;
    }
    largest
}

#[cfg(test)]
mod tests {
    use super::*;

    const TICK: Tick = Tick {
        t_s: 4.0,
        x_m: 2.0,
        desired_m_s: 0.5,
        x_r_m: 2.1,
        v_r_m_s: 0.5,
        age_s: 0.0,
    };

    #[test]
    fn without_delay_the_forms_differ_by_sign_alone() {
        let now = [TICK.x_r_m, TICK.v_r_m_s];
        let form = |form: Form| form.desired_m_s(&TICK, now, 1.0, 2.0);
        assert_eq!(form(Form::Undelayed), form(Form::Transport));
        assert_eq!(form(Form::Undelayed), form(Form::LiteralSign));
        assert_eq!(form(Form::PrintedSign), form(Form::Literal));
        assert!((form(Form::Undelayed) - 0.7).abs() < 1e-12);
        assert!((form(Form::PrintedSign) - 0.3).abs() < 1e-12);
    }

    /// Moving the origin changes the literal form by k_x Δ (1 − e^{−τ}), and no other.
    #[test]
    fn the_literal_form_knows_where_the_origin_is() {
        let fade = (-0.3f64).exp();
        let moved = Tick {
            x_m: TICK.x_m + 10.0,
            x_r_m: TICK.x_r_m + 10.0,
            ..TICK
        };
        let change = |form: Form| {
            form.desired_m_s(&moved, [moved.x_r_m, moved.v_r_m_s], fade, 1.0)
                - form.desired_m_s(&TICK, [TICK.x_r_m, TICK.v_r_m_s], fade, 1.0)
        };
        assert!((change(Form::Literal) - 10.0 * (1.0 - fade)).abs() < 1e-12);
        assert!((change(Form::LiteralSign) + 10.0 * (1.0 - fade)).abs() < 1e-12);
        assert!(change(Form::Transport).abs() < 1e-12);
        assert!(change(Form::Undelayed).abs() < 1e-12);
    }
}
