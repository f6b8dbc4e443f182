//! What may have been otherwise in the paper's experiments than the simulation assumes.

use slipstream_bus::{Experiment, RobotModel};

/// What may differ. Each has one size; 0 is the simulation as assumed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Kind {
    /// Both wheels are larger by this share.
    WheelRadius,
    /// The right wheel is larger by this share.
    RightWheelRadius,
    /// The right motor is stronger and the left one weaker by this share.
    MotorGain,
    /// 0.3 kg of the load lie this far left of the middle (m).
    LoadPlace,
    /// Friction is lower by this on the left half of the floor.
    FloorFriction,
    /// The deceleration begins this much later (s).
    DecelerationStart,
    /// The deceleration lasts this much longer, over the same distance (s).
    DecelerationTime,
    /// A robot starts turned to the left by this (rad).
    StartHeading,
    /// The frame of the tape is turned to the right by this about the start of r2 (rad).
    FrameYaw,
    /// The frame of the tape is shifted backwards by this (m).
    FrameX,
    /// The frame of the tape is shifted to the right by this (m).
    FrameY,
}

/// Where it acts.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Scope {
    /// On all robots in both experiments.
    All,
    /// On one robot in both experiments.
    Robot(usize),
    /// On all robots in one experiment: 0 without, 1 with the limit.
    Experiment(usize),
}

/// A possible cause.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Candidate {
    pub(super) kind: Kind,
    pub(super) scope: Scope,
}

/// Number of kinds.
const KINDS: f64 = 11.0;
/// Mass of the displaced load (kg): a battery pack for robots of this size.
const BATTERY_KG: f64 = 0.3;
/// Radius of a friction patch so large that its edge is nearly straight along the robots' path (m).
const HALF_PLANE_M: f64 = 1000.0;
/// The paper's friction.
const FRICTION: f64 = 0.24;
/// Index of the point of the profile at which the deceleration begins; it ends at the next one.
const DECELERATION: usize = 4;

impl Candidate {
    /// All, in the order in which ties are decided: what is simplest comes first.
    pub(super) fn all() -> Vec<Self> {
        let of = |kinds: &[Kind], scopes: &[Scope]| -> Vec<Self> {
            let pairs = kinds
                .iter()
                .flat_map(|&kind| scopes.iter().map(move |&scope| (kind, scope)));
            pairs.map(|(kind, scope)| Self { kind, scope }).collect()
        };
        let robots = [0, 1, 2].map(Scope::Robot);
        let experiments = [0, 1].map(Scope::Experiment);
        let frame = [Kind::FrameYaw, Kind::FrameX, Kind::FrameY];
        let profile = [Kind::DecelerationStart, Kind::DecelerationTime];
        let machine = [
            Kind::WheelRadius,
            Kind::RightWheelRadius,
            Kind::MotorGain,
            Kind::LoadPlace,
            Kind::FloorFriction,
        ];
        [
            of(&frame, &[Scope::All]),
            of(&profile, &[Scope::All]),
            of(&machine, &[Scope::All]),
            of(&frame, &experiments),
            of(&profile, &experiments),
            of(&machine, &robots),
            of(&[Kind::StartHeading], &robots),
        ]
        .concat()
    }

    /// Number of candidates among which it is one: its kind, then where it acts.
    pub(super) fn choices(&self) -> f64 {
        let places = match self.scope {
            Scope::All => 1.0,
            Scope::Experiment(_) => 2.0,
            Scope::Robot(_) => 3.0,
        };
        KINDS * places
    }

    /// Whether it acts on a robot in an experiment.
    pub(super) fn acts(&self, experiment: usize, robot: usize) -> bool {
        match self.scope {
            Scope::All => true,
            Scope::Robot(own) => own == robot,
            Scope::Experiment(own) => own == experiment,
        }
    }

    /// Changes one of the two experiments by this cause of this size.
    pub(super) fn change(&self, size: f64, number: usize, experiment: &mut Experiment) {
        for (robot, setup) in experiment.robots.iter_mut().enumerate() {
            if self.acts(number, robot) {
                setup.model = self.kind.model(setup.model.clone(), size);
            }
        }
        if self.acts(number, 0) {
            self.kind
                .change_profile(size, &mut experiment.settings.profile.times_s);
        }
    }
}

impl Kind {
    /// Largest size that is considered, of either sign.
    pub(super) fn largest(self) -> f64 {
        match self {
            Self::WheelRadius => 0.03,
            Self::RightWheelRadius => 0.015,
            Self::MotorGain => 0.4,
            Self::LoadPlace => 0.105,
            Self::FloorFriction => 0.12,
            Self::DecelerationStart => 0.8,
            Self::DecelerationTime => 3.6,
            Self::StartHeading => 0.15,
            Self::FrameYaw => 0.1,
            Self::FrameX | Self::FrameY => 0.2,
        }
    }

    /// Whether it moves what the tape says, and nothing of the run.
    pub(super) fn is_of_tape(self) -> bool {
        matches!(
            self,
            Self::StartHeading | Self::FrameYaw | Self::FrameX | Self::FrameY
        )
    }

    /// Name in JSON.
    pub(super) fn id(self) -> &'static str {
        match self {
            Self::WheelRadius => "wheel_radius",
            Self::RightWheelRadius => "right_wheel_radius",
            Self::MotorGain => "motor_gain",
            Self::LoadPlace => "load_place",
            Self::FloorFriction => "floor_friction",
            Self::DecelerationStart => "deceleration_start",
            Self::DecelerationTime => "deceleration_time",
            Self::StartHeading => "start_heading",
            Self::FrameYaw => "frame_yaw",
            Self::FrameX => "frame_x",
            Self::FrameY => "frame_y",
        }
    }

    /// Unit of the size.
    pub(super) fn unit(self) -> &'static str {
        match self {
            Self::WheelRadius | Self::RightWheelRadius | Self::MotorGain | Self::FloorFriction => {
                "1"
            }
            Self::LoadPlace | Self::FrameX | Self::FrameY => "m",
            Self::DecelerationStart | Self::DecelerationTime => "s",
            Self::StartHeading | Self::FrameYaw => "rad",
        }
    }

    /// The robot with it.
    fn model(self, robot: RobotModel, size: f64) -> RobotModel {
        match self {
            Self::WheelRadius => {
                let scale = 1.0 + size;
                robot.with(
                    "wheel_radius",
                    &[("right_scale", scale), ("left_scale", scale)],
                )
            }
            Self::RightWheelRadius => {
                let scales = [("right_scale", 1.0 + size), ("left_scale", 1.0)];
                robot.with("wheel_radius", &scales)
            }
            Self::MotorGain => {
                robot.with("motor_gain", &[("right", 1.0 + size), ("left", 1.0 - size)])
            }
            Self::LoadPlace => {
                let place = [("mass_kg", BATTERY_KG), ("x_m", 0.0), ("y_m", size)];
                robot.with("payload", &place)
            }
            Self::FloorFriction => {
                let half = [
                    ("x_m", 2.5),
                    ("y_m", HALF_PLANE_M.copysign(size)),
                    ("radius_m", HALF_PLANE_M),
                    ("friction", FRICTION - size.abs()),
                ];
                robot.with("friction_patch", &half)
            }
            _ => robot,
        }
    }

    /// Moves the deceleration of a profile.
    fn change_profile(self, size: f64, times_s: &mut [f64]) {
        let Some([begin, end]) = times_s.get_mut(DECELERATION..DECELERATION + 2) else {
            return;
        };
        match self {
            Self::DecelerationStart => {
                *begin += size;
                *end += size;
            }
            Self::DecelerationTime => {
                *begin -= size / 2.0;
                *end += size / 2.0;
            }
            _ => {}
        }
    }

    /// What the tape says of a robot that starts at `start` and ends at `end`: x (m), y (m).
    pub(super) fn taped(self, size: f64, start: [f64; 2], end: [f64; 2]) -> [f64; 2] {
        let turned = |about: [f64; 2]| {
            let (sin, cos) = size.sin_cos();
            let [x, y] = [end[0] - about[0], end[1] - about[1]];
            [about[0] + x * cos - y * sin, about[1] + x * sin + y * cos]
        };
        match self {
            Self::StartHeading => turned(start),
            Self::FrameYaw => turned([0.0; 2]),
            Self::FrameX => [end[0] + size, end[1]],
            Self::FrameY => [end[0], end[1] + size],
            _ => end,
        }
    }
}
