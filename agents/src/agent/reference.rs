//! Reference generation: the velocity profile for a robot by itself, the predecessor's path for a
//! follower (q_ref = q_{i−1} − δ_i, section 4 of the paper).

use slipstream_bus::experiment::{Feedforward, Settings};
use slipstream_bus::message::Position;
use slipstream_bus::time::{ns_from_s, s_from_ns};

use crate::pose::Pose;
use crate::predecessor_path::PredecessorPath;

/// Largest step of the integration of the profile (ns).
const PROFILE_STEP_NS: i64 = 5_000_000;

/// The reference at an outer tick, and what it would be by the profile alone.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct References {
    pub(super) reference: Reference,
    pub(super) profile: Reference,
}

/// A reference.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Reference {
    /// Pose of c.
    pub(super) pose: Pose,
    /// v_r (m/s) and w_r (rad/s).
    pub(super) velocity: [f64; 2],
    /// Sequence number of the message that it is based on.
    pub(super) message: Option<u32>,
}

/// Generates the references of one robot.
#[derive(Debug, Clone)]
pub(super) struct ReferenceGenerator {
    /// The path of the predecessor, if the robot follows one.
    path: Option<PredecessorPath>,
    /// Number and v_r (m/s) of the newest position.
    newest: Option<(u32, f64)>,
    /// Pose of the midpoint of the axle if the robot had followed the profile exactly.
    profile_axle: Pose,
    profile_ns: i64,
    /// d: distance from c backwards to the axle (m).
    d: f64,
}

impl ReferenceGenerator {
    /// The generator of a robot with c at `start`, whose predecessor, if it follows one, starts at
    /// `predecessor`.
    pub(super) fn new(start: Pose, predecessor: Option<Pose>, d: f64) -> Self {
        Self {
            path: predecessor.map(PredecessorPath::new),
            newest: None,
            profile_axle: start.ahead(-d),
            profile_ns: 0,
            d,
        }
    }

    /// Appends a position of the predecessor, newer than all before.
    pub(super) fn receive(&mut self, position: &Position) {
        if let Some(path) = &mut self.path {
            let pose = Pose::new([position.x_m, position.y_m, position.yaw_rad]);
            path.extend(pose, [position.v_m_s, position.w_rad_s]);
            self.newest = Some((position.seq, position.v_m_s));
        }
    }

    /// The reference at `now_ns`, not before the last call.
    pub(super) fn at(&mut self, now_ns: i64, settings: &Settings) -> References {
        self.integrate_profile(now_ns, settings);
        let (v_profile, w_profile) = settings.profile.at(s_from_ns(now_ns));
        let profile = Reference {
            pose: self.profile_axle.ahead(self.d),
            velocity: [v_profile, w_profile],
            message: None,
        };
        let formation = &settings.formation;
        let coordinates = now_ns >= ns_from_s(formation.start_s);
        let Some(path) = self.path.as_mut().filter(|_| coordinates) else {
            let reference = profile;
            return References { reference, profile };
        };
        let point = path.behind(formation.spacing_m);
        let v_r = match formation.feedforward {
            Feedforward::Profile => v_profile,
            Feedforward::Message => self.newest.map_or(0.0, |(_, v_m_s)| v_m_s),
        };
        let reference = Reference {
            pose: point.pose,
            velocity: [v_r, v_r * point.curvature],
            message: self.newest.map(|(seq, _)| seq),
        };
        References { reference, profile }
    }

    fn integrate_profile(&mut self, now_ns: i64, settings: &Settings) {
        let mut t_ns = self.profile_ns;
        while t_ns < now_ns {
            let step_ns = PROFILE_STEP_NS.min(now_ns - t_ns);
            let middle_s = s_from_ns(t_ns) + 0.5 * s_from_ns(step_ns);
            let (v, w) = settings.profile.at(middle_s);
            let step_s = s_from_ns(step_ns);
            self.profile_axle = self.profile_axle.along_arc(v * step_s, w * step_s);
            t_ns += step_ns;
        }
        self.profile_ns = now_ns;
    }
}
