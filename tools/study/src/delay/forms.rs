//! The desired speed under delay at one outer tick: Eq. 12 to 14, as printed and as they may be meant.

use super::follower_recorder::FollowerTick;

/// A form of the desired speed v_d on a straight line: x is the follower's position, x_r its reference
/// position, v_r the reference speed, τ the delay.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Form {
    /// Eq. 12 without delay: v_r + k_x (x_r − x).
    Undelayed,
    /// The paper's form for the straight line, with its sign: v_r + k_x (x − x_r).
    PrintedSign,
    /// Eq. 13 as printed, the exponentials taken as numbers: v_r e^{−τ} + k_x (x − x_r e^{−τ}).
    Literal,
    /// Eq. 13 with the sign of Eq. 12: v_r e^{−τ} + k_x (x_r e^{−τ} − x).
    LiteralSign,
    /// Eq. 13 with the exponential as the delay operator of the Laplace transform: v_r(t − τ) + k_x (x_r(t − τ) − x).
    Transport,
}

impl Form {
    /// All forms.
    pub const ALL: [Self; 5] = [
        Self::Undelayed,
        Self::PrintedSign,
        Self::Literal,
        Self::LiteralSign,
        Self::Transport,
    ];

    /// Its name in answers and files.
    pub fn name(self) -> &'static str {
        match self {
            Self::Undelayed => "Eq. 12 without delay",
            Self::PrintedSign => "the straight-line form with its printed sign, without delay",
            Self::Literal => "Eq. 13 as printed, numbers for the exponentials",
            Self::LiteralSign => "Eq. 13 with the sign of Eq. 12, numbers for the exponentials",
            Self::Transport => "the transport delay x_r(t − τ), v_r(t − τ)",
        }
    }

    /// v_d (m/s) at a tick; `delayed` holds x_r (m) and v_r (m/s) a delay τ earlier, `decay` is e^{−τ}.
    pub fn desired_m_s(self, tick: &FollowerTick, delayed: [f64; 2], decay: f64, k_x: f64) -> f64 {
        let FollowerTick {
            x_m: x,
            x_r_m: x_r,
            v_r_m_s: v_r,
            ..
        } = *tick;
        match self {
            Self::Undelayed => v_r + k_x * (x_r - x),
            Self::PrintedSign => v_r + k_x * (x - x_r),
            Self::Literal => v_r * decay + k_x * (x - x_r * decay),
            Self::LiteralSign => v_r * decay + k_x * (x_r * decay - x),
            Self::Transport => delayed[1] + k_x * (delayed[0] - x),
        }
    }
}

/// Bound of the desired speed, second line of Eq. 14: |v_r| + k_x |x − x_r| + k_x |x_r| (1 − e^{−τ}) (m/s).
pub(super) fn bound_m_s(tick: &FollowerTick, decay: f64, k_x: f64) -> f64 {
    let error = (tick.x_m - tick.x_r_m).abs();
    tick.v_r_m_s.abs() + k_x * error + k_x * tick.x_r_m.abs() * (1.0 - decay)
}

#[cfg(test)]
mod tests {
    use super::*;

    const TICK: FollowerTick = FollowerTick {
        t_s: 4.0,
        x_m: 2.0,
        desired_m_s: 0.5,
        x_r_m: 2.1,
        v_r_m_s: 0.5,
        age_s: 0.0,
    };

    #[test]
    fn without_delay_the_forms_differ_only_by_sign() {
        let now = [TICK.x_r_m, TICK.v_r_m_s];
        let form = |form: Form| form.desired_m_s(&TICK, now, 1.0, 2.0);
        assert_eq!(form(Form::Undelayed), form(Form::Transport));
        assert_eq!(form(Form::Undelayed), form(Form::LiteralSign));
        assert_eq!(form(Form::PrintedSign), form(Form::Literal));
        assert!((form(Form::Undelayed) - 0.7).abs() < 1e-12);
        assert!((form(Form::PrintedSign) - 0.3).abs() < 1e-12);
    }

    /// Moving the origin by Δ changes the literal form by k_x Δ (1 − e^{−τ}), and no other form.
    #[test]
    fn only_the_literal_forms_depend_on_the_origin() {
        let decay = (-0.3f64).exp();
        let moved = FollowerTick {
            x_m: TICK.x_m + 10.0,
            x_r_m: TICK.x_r_m + 10.0,
            ..TICK
        };
        let change = |form: Form| {
            form.desired_m_s(&moved, [moved.x_r_m, moved.v_r_m_s], decay, 1.0)
                - form.desired_m_s(&TICK, [TICK.x_r_m, TICK.v_r_m_s], decay, 1.0)
        };
        assert!((change(Form::Literal) - 10.0 * (1.0 - decay)).abs() < 1e-12);
        assert!((change(Form::LiteralSign) + 10.0 * (1.0 - decay)).abs() < 1e-12);
        assert!(change(Form::Transport).abs() < 1e-12);
        assert!(change(Form::Undelayed).abs() < 1e-12);
    }
}
