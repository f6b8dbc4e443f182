//! Streams of a robot: columns of values over a column of times.

/// Rows over time: each row has one time and one value in every column.
#[derive(Debug, Clone, Default)]
pub struct Stream<V> {
    /// Time of each row (s): finite, never decreasing.
    pub t_s: Vec<f64>,
    /// The columns, each as long as `t_s`.
    pub values: V,
    /// Columns that the format does not define, kept as text.
    pub unknown: Vec<UnknownColumn>,
}

impl<V> Stream<V> {
    /// Number of rows.
    pub fn len(&self) -> usize {
        self.t_s.len()
    }

    /// Whether the stream has no rows.
    pub fn is_empty(&self) -> bool {
        self.t_s.is_empty()
    }
}

/// A column that the format does not define.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct UnknownColumn {
    /// Name in the header line.
    pub name: String,
    /// One cell per row.
    pub cells: Vec<String>,
}

impl UnknownColumn {
    /// A column without cells.
    pub(crate) fn named(name: impl Into<String>) -> Self {
        Self {
            name: name.into(),
            cells: Vec::new(),
        }
    }
}

/// Commands to the actuators.
#[derive(Debug, Clone)]
pub enum Command {
    /// Torque at each wheel (N m).
    Torque {
        /// Right wheel (N m).
        right_nm: Vec<f64>,
        /// Left wheel (N m).
        left_nm: Vec<f64>,
    },
    /// Voltage at each motor (V).
    Voltage {
        /// Right motor (V).
        right_v: Vec<f64>,
        /// Left motor (V).
        left_v: Vec<f64>,
    },
    /// Speed of each wheel (rad/s).
    WheelSpeed {
        /// Right wheel (rad/s).
        right_rad_s: Vec<f64>,
        /// Left wheel (rad/s).
        left_rad_s: Vec<f64>,
    },
    /// Forward speed and yaw rate of the robot.
    Twist {
        /// Forward speed (m/s).
        v_m_s: Vec<f64>,
        /// Yaw rate (rad/s).
        w_rad_s: Vec<f64>,
    },
}

/// Measurements of the wheel encoders.
#[derive(Debug, Clone)]
pub enum Wheels {
    /// Signed cumulative counts; `None` if the cell is empty.
    Ticks {
        /// Right wheel (counts).
        right: Vec<Option<i64>>,
        /// Left wheel (counts).
        left: Vec<Option<i64>>,
    },
    /// Angles from an unknown start angle (rad).
    Angle {
        /// Right wheel (rad).
        right_rad: Vec<f64>,
        /// Left wheel (rad).
        left_rad: Vec<f64>,
    },
    /// Speeds (rad/s).
    Speed {
        /// Right wheel (rad/s).
        right_rad_s: Vec<f64>,
        /// Left wheel (rad/s).
        left_rad_s: Vec<f64>,
    },
}

/// The robot's own estimate of its velocity.
#[derive(Debug, Clone, Default)]
pub struct Odometry {
    /// Forward speed (m/s).
    pub v_m_s: Vec<f64>,
    /// Yaw rate (rad/s), if estimated.
    pub w_rad_s: Option<Vec<f64>>,
}

/// Ground truth of the point [`Robot::pose_point`](super::Robot::pose_point), in the world frame.
#[derive(Debug, Clone, Default)]
pub struct Pose {
    /// World x (m).
    pub x_m: Vec<f64>,
    /// World y (m).
    pub y_m: Vec<f64>,
    /// Heading (rad), wrapped or not, as in the file; `None` if the sensor does not measure it.
    pub yaw_rad: Option<Vec<f64>>,
}

/// Inertial measurements at the centre of mass, in the body frame. At least one column is present.
#[derive(Debug, Clone, Default)]
pub struct Imu {
    /// Forward acceleration (m/s²).
    pub ax_m_s2: Option<Vec<f64>>,
    /// Acceleration to the left (m/s²).
    pub ay_m_s2: Option<Vec<f64>>,
    /// Yaw rate (rad/s).
    pub gz_rad_s: Option<Vec<f64>>,
}

/// Electrical measurements of the motors. At least one column is present.
#[derive(Debug, Clone, Default)]
pub struct Motor {
    /// Current of the right motor (A).
    pub current_right_a: Option<Vec<f64>>,
    /// Current of the left motor (A).
    pub current_left_a: Option<Vec<f64>>,
    /// Supply voltage (V).
    pub supply_v: Option<Vec<f64>>,
}
