//! One example of every effect: its size, what is commanded and what is shown.

use slipstream_sim::Command;

/// An effect at work.
pub(crate) struct Example {
    pub(crate) effect: &'static str,
    pub(crate) parameters: &'static [(&'static str, Value)],
    /// Whether both robots drive on the floor of the paper instead of rolling without slip.
    pub(crate) slips: bool,
    pub(crate) course: &'static Course,
    pub(crate) shown: Shown,
}

/// Value of a parameter.
pub(crate) enum Value {
    Number(f64),
    Text(&'static str),
    List(&'static [f64]),
}
use Value::{List, Number as N, Text};

/// Commands over time.
pub(crate) struct Course {
    pub(crate) length_s: f64,
    /// Command at a time (s).
    pub(crate) command: fn(f64) -> Command,
    words: &'static str,
}

/// What a picture shows.
#[derive(Clone, Copy)]
pub(crate) enum Shown {
    Speed,
    TurnRate,
    EncoderSpeed,
    Path,
    SeenPath,
    OdometryPath,
    SeenX,
    EncoderAngle,
    Gyro,
    MessageX,
}

impl Shown {
    /// Names of the axes, with units.
    pub(crate) fn axes(self) -> [&'static str; 2] {
        let t = "time (s)";
        let stamp = "time stamp (s)";
        match self {
            Self::Speed => [t, "speed (m/s)"],
            Self::TurnRate => [t, "turn rate (rad/s)"],
            Self::EncoderSpeed => [t, "speed of the right encoder (rad/s)"],
            Self::Path => ["x (m)", "y (m)"],
            Self::SeenPath => ["x in pose.csv (m)", "y in pose.csv (m)"],
            Self::OdometryPath => ["x by odometry (m)", "y by odometry (m)"],
            Self::SeenX => [stamp, "x in pose.csv (m)"],
            Self::EncoderAngle => [stamp, "angle of the right encoder (rad)"],
            Self::Gyro => [stamp, "turn rate in imu.csv (rad/s)"],
            Self::MessageX => ["time of sending (s)", "x in the message (m)"],
        }
    }

    fn words(self) -> &'static str {
        match self {
            Self::Speed => "speed along the body",
            Self::TurnRate => "turn rate",
            Self::EncoderSpeed => "speed of the right wheel by its encoder",
            Self::Path => "path of the centre of mass",
            Self::SeenPath => "path by the pose sensor",
            Self::OdometryPath => "path by the encoders",
            Self::SeenX => "position by the pose sensor",
            Self::EncoderAngle => "angle of the right wheel by its encoder",
            Self::Gyro => "turn rate by the gyro",
            Self::MessageX => "position of the robot in front by its messages",
        }
    }
}

impl Example {
    /// What the picture shows, in words.
    pub(crate) fn caption(&self) -> String {
        format!("{}, {}", self.shown.words(), self.course.words)
    }
}

/// The example of an effect.
pub(crate) fn of(effect: &str) -> &'static Example {
    let found = EXAMPLES.iter().find(|example| example.effect == effect);
    found.unwrap_or_else(|| panic!("{effect} has no example"))
}

/// The value of the last entry that has begun; entries are (begin in s, value).
fn held(t_s: f64, entries: &[(f64, f64)]) -> f64 {
    let begun = entries.iter().take_while(|(begin_s, _)| *begin_s <= t_s);
    begun.last().map_or(0.0, |(_, value)| *value)
}

fn torque(right_nm: f64, left_nm: f64) -> Command {
    Command::Torque { right_nm, left_nm }
}

fn twist(v_m_s: f64, w_rad_s: f64) -> Command {
    Command::Twist { v_m_s, w_rad_s }
}

const COAST_DOWN: Course = Course {
    length_s: 6.0,
    command: |t_s| {
        let torque_nm = held(t_s, &[(0.0, 0.05), (1.0, 0.0)]);
        torque(torque_nm, torque_nm)
    },
    words: "in a coast-down: 0.05 N m at each wheel for 1 s, then none",
};
const PUSH_ON: Course = Course {
    length_s: 4.0,
    command: |_| torque(0.05, 0.05),
    words: "under a constant torque of 0.05 N m at each wheel",
};
const SPIN: Course = Course {
    length_s: 4.0,
    command: |t_s| {
        let torque_nm = held(t_s, &[(0.0, 0.01), (0.6, 0.0), (2.0, -0.01), (2.6, 0.0)]);
        torque(torque_nm, -torque_nm)
    },
    words: "spinning in place: ±0.01 N m at the wheels for 0.6 s, left, then right, with nothing in between",
};
const TORQUE_STEPS: Course = Course {
    length_s: 4.0,
    command: |t_s| {
        let size = 0.04 * (1.0 + (t_s + 1e-9).floor());
        let torque_nm = if (t_s + 1e-9).fract() < 0.5 {
            size
        } else {
            -size
        };
        torque(torque_nm, torque_nm)
    },
    words: "in stop-and-go: torques of ±0.04, ±0.08, ±0.12 and ±0.16 N m at each wheel, half a second each",
};
const FAST_STEPS: Course = Course {
    length_s: 0.4,
    command: |t_s| {
        let torque_nm = if (t_s * 5.0 + 1e-9).fract() < 0.5 {
            0.02
        } else {
            -0.02
        };
        torque(torque_nm, torque_nm)
    },
    words: "under torques of ±0.02 N m at each wheel, a tenth of a second each",
};
const STEPS: Course = Course {
    length_s: 5.0,
    command: |t_s| {
        let steps = [
            (0.0, 0.05),
            (0.8, 0.0),
            (1.0, 0.2),
            (1.8, 0.0),
            (2.0, -0.1),
            (2.8, 0.0),
            (3.0, 0.4),
            (3.8, 0.0),
            (4.0, -0.3),
            (4.8, 0.0),
        ];
        twist(held(t_s, &steps), 0.0)
    },
    words: "under steps of the commanded speed: 0.05, 0.2, −0.1, 0.4 and −0.3 m/s",
};
const STOP_AND_GO: Course = Course {
    length_s: 40.0,
    command: |t_s| {
        twist(
            if (t_s / 5.0 + 1e-9).fract() < 0.5 {
                0.3
            } else {
                0.0
            },
            0.0,
        )
    },
    words: "in stop-and-go: the same speed of 0.3 m/s commanded again and again",
};
const SHARP_STARTS: Course = Course {
    length_s: 6.0,
    command: |t_s| {
        let steps = [
            (0.0, 0.0),
            (0.5, 0.4),
            (1.5, 0.0),
            (2.5, -0.4),
            (3.5, 0.0),
            (4.5, 0.4),
            (5.5, 0.0),
        ];
        twist(held(t_s, &steps), 0.0)
    },
    words: "in sharp starts: 0.4 m/s forwards, then backwards, then forwards",
};
const STRAIGHT: Course = Course {
    length_s: 6.0,
    command: |_| twist(0.5, 0.0),
    words: "on a straight line: 0.5 m/s commanded for 6 s",
};
const TURNS: Course = Course {
    length_s: 4.0,
    command: |t_s| {
        twist(
            0.0,
            held(t_s, &[(0.0, 2.0), (1.8, 0.0), (2.2, -2.0), (3.8, 0.0)]),
        )
    },
    words: "spinning in place: 2 rad/s commanded to the left, then to the right",
};
const LINE_BY_TORQUE: Course = Course {
    length_s: 1.6,
    command: |_| torque(0.08, 0.08),
    words: "under a constant torque of 0.08 N m at each wheel, on the floor of the paper",
};
const SNAKE: Course = Course {
    length_s: 4.0,
    command: |t_s| {
        let turn = held(
            t_s,
            &[(0.0, 0.0), (1.0, 0.004), (1.6, -0.004), (2.8, 0.004)],
        );
        let drive = held(t_s, &[(0.0, 0.02), (2.0, 0.0)]);
        torque(drive + turn, drive - turn)
    },
    words: "under torques that turn it left, right and left again",
};

/// An example on the floor where wheels roll without slip.
const fn rolling(
    effect: &'static str,
    parameters: &'static [(&'static str, Value)],
    course: &'static Course,
    shown: Shown,
) -> Example {
    Example {
        effect,
        parameters,
        slips: false,
        course,
        shown,
    }
}

/// An example on the floor of the paper.
const fn slipping(
    effect: &'static str,
    parameters: &'static [(&'static str, Value)],
    course: &'static Course,
    shown: Shown,
) -> Example {
    Example {
        slips: true,
        ..rolling(effect, parameters, course, shown)
    }
}

pub(crate) const EXAMPLES: &[Example] = &[
    rolling(
        "wheel_slip",
        &[
            ("friction_static", N(0.241)),
            ("friction_kinetic", N(0.239)),
        ],
        &TORQUE_STEPS,
        Shown::Speed,
    ),
    slipping(
        "friction_patch",
        &[
            ("x_m", N(0.5)),
            ("y_m", N(0.2)),
            ("radius_m", N(0.15)),
            ("friction", N(0.02)),
        ],
        &LINE_BY_TORQUE,
        Shown::Path,
    ),
    rolling(
        "rolling_resistance",
        &[("coefficient", N(0.02))],
        &COAST_DOWN,
        Shown::Speed,
    ),
    rolling(
        "viscous_drag",
        &[("coefficient", N(0.4))],
        &COAST_DOWN,
        Shown::Speed,
    ),
    rolling(
        "quadratic_drag",
        &[("coefficient", N(0.5))],
        &COAST_DOWN,
        Shown::Speed,
    ),
    rolling(
        "caster_drag",
        &[("friction", N(0.03))],
        &SPIN,
        Shown::TurnRate,
    ),
    rolling(
        "yaw_scrub",
        &[("moment_nm", N(0.015))],
        &SPIN,
        Shown::TurnRate,
    ),
    rolling(
        "actuator_delay",
        &[("delay_s", N(0.15))],
        &STEPS,
        Shown::Speed,
    ),
    rolling(
        "command_dead_band",
        &[("speed_rad_s", N(3.0))],
        &STEPS,
        Shown::Speed,
    ),
    rolling(
        "command_dead_zone",
        &[("speed_rad_s", N(2.0))],
        &STEPS,
        Shown::Speed,
    ),
    rolling(
        "command_saturation",
        &[("speed_rad_s", N(6.0))],
        &STEPS,
        Shown::Speed,
    ),
    rolling(
        "actuator_lag",
        &[("time_constant_s", N(0.15))],
        &STEPS,
        Shown::Speed,
    ),
    rolling(
        "motor_gain",
        &[("right", N(1.05)), ("left", N(0.98))],
        &STRAIGHT,
        Shown::Path,
    ),
    rolling(
        "supply_sag",
        &[("rate_per_s", N(0.008))],
        &STOP_AND_GO,
        Shown::Speed,
    ),
    rolling(
        "torque_speed_droop",
        &[("coefficient", N(0.001))],
        &PUSH_ON,
        Shown::Speed,
    ),
    rolling(
        "backlash",
        &[("gap_rad", N(0.08))],
        &FAST_STEPS,
        Shown::EncoderSpeed,
    ),
    rolling(
        "axle_friction",
        &[("torque_nm", N(0.006))],
        &COAST_DOWN,
        Shown::Speed,
    ),
    slipping(
        "load_transfer",
        &[("com_height_m", N(0.08))],
        &TORQUE_STEPS,
        Shown::Speed,
    ),
    rolling(
        "wheel_radius",
        &[("right_scale", N(1.03)), ("left_scale", N(0.98))],
        &STRAIGHT,
        Shown::Path,
    ),
    rolling(
        "slip_ratio",
        &[("ratio", N(0.1)), ("asymmetry", N(0.04))],
        &STRAIGHT,
        Shown::Path,
    ),
    rolling("track_width", &[("scale", N(1.2))], &TURNS, Shown::TurnRate),
    rolling(
        "payload",
        &[("mass_kg", N(0.4)), ("x_m", N(-0.04)), ("y_m", N(0.04))],
        &SNAKE,
        Shown::Path,
    ),
    rolling(
        "floor_slope",
        &[("grade", N(0.02)), ("downhill_rad", N(3.1))],
        &COAST_DOWN,
        Shown::Speed,
    ),
    rolling(
        "push",
        &[
            ("t_s", N(2.0)),
            ("impulse_n_s", N(0.4)),
            ("direction_rad", N(0.0)),
        ],
        &COAST_DOWN,
        Shown::Speed,
    ),
    rolling(
        "force_law",
        &[
            ("acts_on", Text("surge_force")),
            ("driver", Text("v")),
            ("knots", List(&[0.0, 0.6, 1.2])),
            ("values", List(&[0.0, -0.5, -0.2])),
        ],
        &COAST_DOWN,
        Shown::Speed,
    ),
    rolling(
        "motion_law",
        &[
            ("acts_on", Text("turn_rate")),
            ("driver", Text("v")),
            ("knots", List(&[0.0, 0.5])),
            ("values", List(&[0.0, 0.15])),
        ],
        &STRAIGHT,
        Shown::Path,
    ),
    rolling(
        "pose_offset",
        &[("x_m", N(0.05)), ("y_m", N(0.03)), ("yaw_rad", N(0.05))],
        &TURNS,
        Shown::SeenPath,
    ),
    rolling(
        "pose_latency",
        &[("latency_s", N(0.15))],
        &SHARP_STARTS,
        Shown::SeenX,
    ),
    rolling(
        "wheels_latency",
        &[("latency_s", N(0.15))],
        &SHARP_STARTS,
        Shown::EncoderAngle,
    ),
    rolling(
        "imu_latency",
        &[("latency_s", N(0.15))],
        &TURNS,
        Shown::Gyro,
    ),
    rolling(
        "encoder_scale",
        &[("right_scale", N(1.03)), ("left_scale", N(0.99))],
        &STRAIGHT,
        Shown::OdometryPath,
    ),
    rolling(
        "clock_drift",
        &[("rate", N(0.05)), ("stream", Text("pose"))],
        &SHARP_STARTS,
        Shown::SeenX,
    ),
    rolling(
        "link_delay",
        &[("delay_s", N(0.15))],
        &SHARP_STARTS,
        Shown::MessageX,
    ),
];
