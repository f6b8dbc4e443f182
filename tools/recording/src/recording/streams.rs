//! Streams: columns of numbers over time.

/// Rows over time: one time and one value of every column each.
#[derive(Debug, Clone, Default)]
pub struct Stream<V> {
    /// The time of each row (s), never decreasing, always finite.
    pub t_s: Vec<f64>,
    /// The columns, each as long as `t_s`.
    pub values: V,
    /// Columns that the format does not know, kept as text.
    pub unknown: Vec<UnknownColumn>,
}

/// A column that the format does not know.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct UnknownColumn {
    /// Its head.
    pub name: String,
    /// Its cells, one a row.
    pub cells: Vec<String>,
}

/// What the actuators were told.
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

/// What the wheel encoders said.
#[derive(Debug, Clone)]
pub enum Wheels {
    /// Signed cumulative counts; an empty cell is `None`.
    Ticks {
        /// Right wheel (counts).
        right: Vec<Option<i64>>,
        /// Left wheel (counts).
        left: Vec<Option<i64>>,
    },
    /// Angles from an unknown start (rad).
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

/// The robot's own velocity estimate.
#[derive(Debug, Clone, Default)]
pub struct Odometry {
    /// Forward speed (m/s).
    pub v_m_s: Vec<f64>,
    /// Yaw rate (rad/s), where there is one.
    pub w_rad_s: Option<Vec<f64>>,
}

/// Ground truth of the declared point.
#[derive(Debug, Clone, Default)]
pub struct Pose {
    /// World x (m).
    pub x_m: Vec<f64>,
    /// World y (m).
    pub y_m: Vec<f64>,
    /// Heading (rad), wrapped or not as the file has it; `None` where the sensor sees none.
    pub yaw_rad: Option<Vec<f64>>,
}

/// Body-frame inertial measurements at the centre of mass; at least one axis is there.
#[derive(Debug, Clone, Default)]
pub struct Imu {
    /// Forward (m/s²).
    pub ax_m_s2: Option<Vec<f64>>,
    /// To the left (m/s²).
    pub ay_m_s2: Option<Vec<f64>>,
    /// Yaw rate (rad/s).
    pub gz_rad_s: Option<Vec<f64>>,
}

/// Electrical measurements of the motors; at least one column is there.
#[derive(Debug, Clone, Default)]
pub struct Motor {
    /// Right motor (A).
    pub current_right_a: Option<Vec<f64>>,
    /// Left motor (A).
    pub current_left_a: Option<Vec<f64>>,
    /// Supply (V).
    pub supply_v: Option<Vec<f64>>,
}

impl<V> Stream<V> {
    /// Number of rows.
    pub fn len(&self) -> usize {
        self.t_s.len()
    }

    /// Whether there is no row.
    pub fn is_empty(&self) -> bool {
        self.t_s.is_empty()
    }
}
