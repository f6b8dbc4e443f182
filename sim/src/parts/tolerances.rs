//! Tolerances of the solver.

/// Effort of event location and of the contact solver.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Tolerances {
    /// Largest number of halvings of a step while an event is located.
    pub(crate) depth: u32,
    /// Number of events that are located in one step. Further events are not located (chattering).
    pub(crate) events: u32,
    /// Largest number of halvings for slow slip before friction enters implicitly.
    pub(crate) stiff_depth: u32,
    /// Largest number of Gauss-Seidel sweeps of the contact solver.
    pub(crate) sweeps: usize,
    /// Largest number of iterations between normal and lateral forces in the contact solver.
    pub(crate) normal_iterations: usize,
}

impl Tolerances {
    /// Events are located to 1/8192 of a step.
    pub(crate) const ACCURATE: Self = Self {
        depth: 13,
        events: 32,
        stiff_depth: 6,
        sweeps: 4000,
        normal_iterations: 60,
    };
    /// Events are located to 1/1024 of a step, and at most two of them.
    pub(crate) const DRAFT: Self = Self {
        depth: 10,
        events: 2,
        stiff_depth: 4,
        sweeps: 60,
        normal_iterations: 6,
    };
}

/// Slip below which the direction of sliding is not computed from the slip but kept from when sliding began (m/s or
/// rad/s). A tenth of [`AT_REST_MAX`], so that an element that has just left rest has a direction of its own.
pub(crate) const SLIP_DIRECTION_MIN: f64 = 1e-13;

/// Slip up to which an element counts as at rest when the active set is updated (m/s or rad/s). Rounding of a
/// projected velocity stays below it.
pub(crate) const AT_REST_MAX: f64 = 1e-12;

/// Slip from which on an element slides in a motion that is given from outside (m/s or rad/s).
pub(crate) const GIVEN_SLIP_MIN: f64 = 1e-9;

/// Share of I_wy on the motor's side of the gear, where there is play.
pub(crate) const MOTOR_SHARE: f64 = 0.25;

/// Share of a friction limit by which rounding may exceed it.
pub(crate) const LIMIT_SLACK: f64 = 1e-9;

/// Share of the square of the friction limit below which a wheel is surely far from sliding.
pub(crate) const SURELY_STICKS: f64 = 0.98;

/// Square of the sine of the largest turn of a sliding direction in one step.
pub(crate) const TURN_MAX: f64 = 0.002;

/// γ = 1 − 1/√2 of the two-stage Rosenbrock method of order two that is L-stable (Verwer, Spee, Blom and
/// Hundsdorfer, 1999).
pub(crate) const ROSENBROCK: f64 = 1.0 - std::f64::consts::FRAC_1_SQRT_2;

/// Share of a slip velocity that friction may change in one explicit step.
pub(crate) const EXPLICIT_MAX: f64 = 0.2;
