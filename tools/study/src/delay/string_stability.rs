//! String stability: the frequency response of the spacing error from one follower to the next, by the
//! linear model of the platoon.

use nalgebra::Complex;
use slipstream_agents::Geometry;
use slipstream_bus::experiment::Control;

/// Lowest frequency of the search for the maximum, far below k_x (rad/s).
const LOWEST_RAD_S: f64 = 0.01;
/// Number of steps of that search, on a logarithmic scale.
const FREQUENCY_STEPS: u32 = 400;

/// Peak over all frequencies of the spacing error's gain from one follower to the next.
///
/// The linear model: PI wheel loops on a rolling robot, speeds measured as means over inner ticks,
/// torques and set-points held for a tick, Eq. 12, and a delay of `delay_s` (s) on every link; v_r is
/// sent with the position. Neither slip nor a torque limit. `None` if the model has no masses or
/// there are fewer than three robots.
///
/// The peak belongs to a stationary oscillation at the worst frequency. The gain of a run is the ratio
/// of the largest errors over one velocity profile, which excites little of that frequency.
pub fn string_gain(
    control: &Control,
    geometry: &Geometry,
    delay_s: f64,
    robots: u32,
) -> Option<f64> {
    // Up to the Nyquist frequency of the outer loop.
    let (low, high) = (
        LOWEST_RAD_S.ln(),
        (std::f64::consts::PI / control.outer_period_s).ln(),
    );
    let gains = (0..=FREQUENCY_STEPS).map(|step| {
        let omega_rad_s = (low + (high - low) * f64::from(step) / f64::from(FREQUENCY_STEPS)).exp();
        string_gain_at(control, geometry, delay_s, omega_rad_s, robots)
    });
    gains.reduce(|a, b| Some(a?.max(b?))).flatten()
}

/// The gain at one frequency (rad/s), with the assumptions of [`string_gain`].
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
    let delay = |seconds: f64| Complex::from_polar(1.0, -omega * seconds);
    // A zero-order hold and a mean over one period have the same frequency response.
    let mean = |period_s: f64| (Complex::from(1.0) - delay(period_s)) / (s * period_s);
    let inner_s = control.inner_period_s;
    // At a tick the integrator holds the sum up to the previous tick.
    let integral = delay(inner_s) / (Complex::from(1.0) - delay(inner_s)) * inner_s;
    let open = (integral * control.k_i + control.k_p) * mean(inner_s) / (s * inertia);
    let driven = open / (open * mean(inner_s) + 1.0) * mean(control.outer_period_s);
    let closed = |command: Complex<f64>| driven * command / (s + driven * control.k_x);
    let mut speed = Complex::new(1.0, 0.0);
    let mut position = closed(speed + s.inv() * control.k_x);
    let mut error_ahead: Option<Complex<f64>> = None;
    let mut largest = 0.0f64;
    for _ in 1..robots {
        speed *= delay(delay_s);
        let next = closed(speed + position * delay(delay_s) * control.k_x);
        let error = position - next;
        if let Some(error_ahead) = error_ahead {
            largest = largest.max(error.norm() / error_ahead.norm());
        }
        error_ahead = Some(error);
        position = next;
    }
    largest
}
