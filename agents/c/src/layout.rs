//! The structs of `slipstream.h` that a controller gets.

use slipstream_agents::{Heard, InnerInput, OuterInput};
use slipstream_bus::message::MAX_EXTRA;
use slipstream_bus::time::s_from_ns;

/// `slipstream_heard`.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub(crate) struct CHeard {
    robot: u32,
    extra_count: u32,
    pose: [f64; 3],
    velocity: [f64; 2],
    extra: [f64; MAX_EXTRA],
    sampled_s: f64,
    sent_s: f64,
    taken_s: f64,
    fresh: bool,
}

impl CHeard {
    pub(crate) fn new(heard: &Heard) -> Self {
        let position = &heard.position;
        Self {
            robot: position.from,
            extra_count: u32::try_from(position.extra.numbers().len()).unwrap_or_default(),
            pose: [position.x_m, position.y_m, position.yaw_rad],
            velocity: [position.v_m_s, position.w_rad_s],
            extra: position.extra.places(),
            sampled_s: s_from_ns(position.sampled_ns),
            sent_s: s_from_ns(position.sent_ns),
            taken_s: heard.taken_s,
            fresh: heard.fresh,
        }
    }
}

/// `slipstream_outer_input`.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub(crate) struct COuterInput {
    t_s: f64,
    period_s: f64,
    pose: [f64; 3],
    velocity: [f64; 2],
    reference: [f64; 3],
    reference_velocity: [f64; 2],
    error: [f64; 3],
    profile: [f64; 3],
    profile_velocity: [f64; 2],
    heard: *const CHeard,
    heard_count: u32,
    coordinates: bool,
}

impl COuterInput {
    /// `heard` has to live as long as what is returned is used.
    pub(crate) fn new(now: &OuterInput<'_>, heard: &[CHeard]) -> Self {
        Self {
            t_s: now.t_s,
            period_s: now.period_s,
            pose: now.pose,
            velocity: now.velocity,
            reference: now.reference,
            reference_velocity: now.reference_velocity,
            error: now.error,
            profile: now.profile,
            profile_velocity: now.profile_velocity,
            heard: heard.as_ptr(),
            heard_count: u32::try_from(heard.len()).unwrap_or_default(),
            coordinates: now.coordinates,
        }
    }
}

/// `slipstream_inner_input`.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub(crate) struct CInnerInput {
    t_s: f64,
    period_s: f64,
    wheel_speed_rad_s: [f64; 2],
    velocity: [f64; 2],
    desired: [f64; 2],
    set_point_rad_s: [f64; 2],
    limit_nm: [f64; 2],
    friction: f64,
    brakes: bool,
}

impl CInnerInput {
    pub(crate) fn new(now: &InnerInput<'_>) -> Self {
        Self {
            t_s: now.t_s,
            period_s: now.period_s,
            wheel_speed_rad_s: now.wheel_speed_rad_s,
            velocity: now.velocity,
            desired: now.desired,
            set_point_rad_s: now.set_point_rad_s,
            limit_nm: now.limit_nm,
            friction: now.friction.unwrap_or(0.0),
            brakes: now.brakes,
        }
    }
}
