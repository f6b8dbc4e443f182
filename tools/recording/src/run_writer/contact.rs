//! Contact state of a driven wheel: as plain data, and as its ROS 2 message.

use slipstream_bag::ros::messages as ros;

/// True contact state of a driven wheel.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct WheelContact {
    /// Whether the contact slides; otherwise it sticks.
    pub slips: bool,
    /// Sliding velocity of the contact along the wheel (m/s).
    pub slip_longitudinal_m_s: f64,
    /// Sliding velocity of the contact across the wheel (m/s).
    pub slip_lateral_m_s: f64,
    /// Normal force of the floor on the wheel (N).
    pub normal_force_n: f64,
    /// Torque applied at the wheel (N m).
    pub applied_torque_nm: f64,
}

impl WheelContact {
    /// The ROS 2 message of this state.
    pub(super) fn message(self) -> ros::WheelContact {
        ros::WheelContact {
            state: u8::from(self.slips),
            slip_longitudinal_m_s: self.slip_longitudinal_m_s,
            slip_lateral_m_s: self.slip_lateral_m_s,
            normal_force_n: self.normal_force_n,
            applied_torque_nm: self.applied_torque_nm,
        }
    }
}
