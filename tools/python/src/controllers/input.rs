//! What a controller knows at a tick, for Python.

use std::sync::atomic::{AtomicBool, Ordering};

use pyo3::prelude::*;
use pyo3::types::PyDict;
use slipstream_bus::message::robot_name;
use slipstream_bus::time::s_from_ns;

type Pair = (f64, f64);
type Triple = (f64, f64, f64);

fn pair([one, other]: [f64; 2]) -> Pair {
    (one, other)
}

fn triple([one, two, three]: [f64; 3]) -> Triple {
    (one, two, three)
}

/// What is known at an outer tick.
#[pyclass(module = "slipstream", frozen, get_all)]
pub(crate) struct OuterInput {
    t_s: f64,
    period_s: f64,
    pose: Triple,
    velocity: Pair,
    reference: Triple,
    reference_velocity: Pair,
    error: Triple,
    profile: Triple,
    profile_velocity: Pair,
    coordinates: bool,
    /// The newest message of every robot that was heard, by its name.
    heard: Py<PyDict>,
}

/// The newest message of another robot.
#[pyclass(module = "slipstream", frozen, get_all)]
pub(crate) struct Heard {
    pose: Triple,
    velocity: Pair,
    extra: Vec<f64>,
    sampled_s: f64,
    sent_s: f64,
    taken_s: f64,
    fresh: bool,
}

impl OuterInput {
    pub(crate) fn new(py: Python<'_>, now: &slipstream_agents::OuterInput<'_>) -> PyResult<Self> {
        let heard = PyDict::new(py);
        for own in now.heard {
            heard.set_item(robot_name(own.position.from), Heard::new(own))?;
        }
        Ok(Self {
            t_s: now.t_s,
            period_s: now.period_s,
            pose: triple(now.pose),
            velocity: pair(now.velocity),
            reference: triple(now.reference),
            reference_velocity: pair(now.reference_velocity),
            error: triple(now.error),
            profile: triple(now.profile),
            profile_velocity: pair(now.profile_velocity),
            coordinates: now.coordinates,
            heard: heard.unbind(),
        })
    }
}

impl Heard {
    fn new(heard: &slipstream_agents::Heard) -> Self {
        let position = &heard.position;
        Self {
            pose: (position.x_m, position.y_m, position.yaw_rad),
            velocity: (position.v_m_s, position.w_rad_s),
            extra: position.extra.numbers().to_vec(),
            sampled_s: s_from_ns(position.sampled_ns),
            sent_s: s_from_ns(position.sent_ns),
            taken_s: heard.taken_s,
            fresh: heard.fresh,
        }
    }
}

/// What is known at an inner tick.
#[pyclass(module = "slipstream", frozen)]
pub(crate) struct InnerInput {
    #[pyo3(get)]
    t_s: f64,
    #[pyo3(get)]
    period_s: f64,
    #[pyo3(get)]
    wheel_speed_rad_s: Pair,
    #[pyo3(get)]
    velocity: Pair,
    #[pyo3(get)]
    desired: Pair,
    #[pyo3(get)]
    set_point_rad_s: Pair,
    #[pyo3(get)]
    limit_nm: Pair,
    #[pyo3(get)]
    friction: Option<f64>,
    #[pyo3(get)]
    brakes: bool,
    paper: Pair,
    /// Whether the controller has asked for the paper's torques.
    asked: AtomicBool,
}

#[pymethods]
impl InnerInput {
    /// The torques of the paper's speed loops (N m), right and left.
    fn paper(&self) -> Pair {
        self.asked.store(true, Ordering::Relaxed);
        self.paper
    }
}

impl InnerInput {
    pub(crate) fn new(now: &slipstream_agents::InnerInput<'_>) -> Self {
        Self {
            t_s: now.t_s,
            period_s: now.period_s,
            wheel_speed_rad_s: pair(now.wheel_speed_rad_s),
            velocity: pair(now.velocity),
            desired: pair(now.desired),
            set_point_rad_s: pair(now.set_point_rad_s),
            limit_nm: pair(now.limit_nm),
            friction: now.friction,
            brakes: now.brakes,
            paper: pair(now.paper().torque_nm),
            asked: AtomicBool::new(false),
        }
    }

    /// Whether the controller has asked for the paper's torques, so that the speed loops advance.
    pub(crate) fn has_asked(&self) -> bool {
        self.asked.load(Ordering::Relaxed)
    }
}
