//! Tolerances of the solver, one sentence each.

/// Effort spent on event location and on the contact solver.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Tolerances {
    /// Largest number of bisections of a step while an event is located.
    pub(crate) bisections: u32,
    /// Number of events located in one step; further ones are applied where a segment ends
    /// (chattering).
    pub(crate) events: u32,
    /// Largest number of bisections for slow slip before friction is treated implicitly.
    pub(crate) stiff_bisections: u32,
    /// Largest number of Gauss-Seidel sweeps of the contact solver.
    pub(crate) sweeps: usize,
    /// Largest number of fixed-point iterations between normal and lateral forces in the contact
    /// solver.
    pub(crate) normal_iterations: usize,
}

impl Tolerances {
    /// Locates events to 1/8192 of a step.
    pub(crate) const ACCURATE: Self = Self {
        bisections: 13,
        events: 32,
        stiff_bisections: 6,
        sweeps: 4000,
        normal_iterations: 60,
    };
    /// Locates at most two events in a step, to 1/1024 of it.
    pub(crate) const DRAFT: Self = Self {
        bisections: 10,
        events: 2,
        stiff_bisections: 4,
        sweeps: 60,
        normal_iterations: 6,
    };
}

/// Slip speed below which the direction of sliding is not computed from the slip but kept from when
/// sliding began (m/s or rad/s): a tenth of [`AT_REST_MAX`], so that a constraint that has just
/// left rest already has a direction.
pub(crate) const SLIP_DIRECTION_MIN: f64 = 1e-13;

/// Slip speed up to which a constraint counts as at rest when the active set is updated (m/s or
/// rad/s): rounding of a projected velocity stays below it.
pub(crate) const AT_REST_MAX: f64 = 1e-12;

/// Slip speed from which a constraint slides when the velocity is set from outside (m/s or rad/s).
pub(crate) const GIVEN_SLIP_MIN: f64 = 1e-9;

/// Relative excess over a friction limit that still counts as rounding.
pub(crate) const LIMIT_SLACK: f64 = 1e-9;

/// Share of the squared friction limit below which a wheel sticks without closer examination.
pub(crate) const SURELY_STICKS: f64 = 0.98;

/// Square of the sine of the largest turn of a sliding direction within one step.
pub(crate) const TURN_MAX: f64 = 0.002;

/// γ = 1 − 1/√2 of the L-stable two-stage Rosenbrock method of order two (Verwer, Spee, Blom and
/// Hundsdorfer, 1999).
pub(crate) const ROSENBROCK: f64 = 1.0 - std::f64::consts::FRAC_1_SQRT_2;

/// Largest share of a slip velocity that friction may change in one explicit step.
pub(crate) const EXPLICIT_MAX: f64 = 0.2;

/// A Jacobian row counts as linearly dependent when projection on the earlier rows leaves less than
/// this share of its inverse effective mass.
pub(crate) const DEPENDENT_ROW: f64 = 1e-9;

/// Share of the accelerations in play below which the contact solver takes an acceleration for
/// zero.
pub(crate) const ZERO_ACCELERATION: f64 = 1e-8;

/// Share of the accelerations in play below which a Gauss-Seidel sweep has converged.
pub(crate) const SWEEP_CONVERGED: f64 = 1e-5 * ZERO_ACCELERATION;

/// Change of a normal force, as a share of the weight, below which the contact solver's iteration
/// between normal and lateral forces has converged.
pub(crate) const NORMAL_CONVERGED: f64 = 1e-12;

/// Change of the caster's normal force, as a share of the weight, below which caster friction and
/// load transfer agree.
pub(crate) const CASTER_CONVERGED: f64 = 1e-13;

/// Largest number of Newton iterations of one projection on a friction disc; the first already
/// doubles the number of digits.
pub(crate) const DISC_ITERATIONS: usize = 30;

/// Relative excess over the radius at which a force counts as inside the friction disc.
pub(crate) const DISC_SLACK: f64 = 1e-15;

/// Instants closer than this are simultaneous (s): a command acting for so short a time moves
/// nothing.
pub(crate) const SIMULTANEOUS_S: f64 = 1e-12;
