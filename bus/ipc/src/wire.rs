//! Memory layout of the messages in shared memory (`repr(C)`).
//!
//! The type name contains the version of the layout: builds with different layouts do not connect.

use iceoryx2::prelude::ZeroCopySend;
use slipstream_bus::message::{Encoders, Position, TorqueCommand};

/// [`Encoders`] of one robot, plant to agent.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, ZeroCopySend)]
#[type_name("slipstream.Encoders.1")]
#[repr(C)]
pub(crate) struct WireEncoders {
    sampled_ns: i64,
    counts: [i64; 2],
}

/// Header of a sample with the encoders of all robots.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, ZeroCopySend)]
#[type_name("slipstream.WorldHeader.1")]
#[repr(C)]
pub(crate) struct WorldHeader {
    /// The instant of the sample (ns).
    pub(crate) now_ns: i64,
    /// The lockstep round that the sample belongs to; 0 on the wall clock.
    pub(crate) epoch: u32,
    /// Padding.
    pub(crate) reserved: u32,
}

/// [`TorqueCommand`], agent to plant.
#[derive(Debug, Clone, Copy, Default, PartialEq, ZeroCopySend)]
#[type_name("slipstream.Torque.1")]
#[repr(C)]
pub(crate) struct WireTorque {
    robot: u32,
    epoch: u32,
    tick_ns: i64,
    torque_nm: [f64; 2],
}

/// [`Position`], robot to its successor.
#[derive(Debug, Clone, Copy, Default, PartialEq, ZeroCopySend)]
#[type_name("slipstream.Position.1")]
#[repr(C)]
pub struct WirePosition {
    /// The sender.
    pub(crate) from: u32,
    seq: u32,
    token_round: u32,
    reserved: u32,
    sampled_ns: i64,
    tick_ns: i64,
    sent_ns: i64,
    x_m: f64,
    y_m: f64,
    yaw_rad: f64,
    v_m_s: f64,
    w_rad_s: f64,
}

/// Implements the conversions in both directions from one list of the fields.
macro_rules! same_fields {
    ($message:ident, $wire:ident { $($field:ident),* } $(, $padding:ident)?) => {
        impl From<$message> for $wire {
            fn from(message: $message) -> Self {
                Self { $($field: message.$field,)* $($padding: 0)? }
            }
        }

        impl From<$wire> for $message {
            fn from(wire: $wire) -> Self {
                Self { $($field: wire.$field),* }
            }
        }
    };
}

same_fields!(Encoders, WireEncoders { sampled_ns, counts });
same_fields!(
    TorqueCommand,
    WireTorque {
        robot,
        epoch,
        tick_ns,
        torque_nm
    }
);
same_fields!(
    Position,
    WirePosition {
        from,
        seq,
        token_round,
        sampled_ns,
        tick_ns,
        sent_ns,
        x_m,
        y_m,
        yaw_rad,
        v_m_s,
        w_rad_s
    },
    reserved
);

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_position_survives_both_conversions() {
        let position = Position {
            from: 1,
            seq: 2,
            token_round: 3,
            sampled_ns: 4,
            tick_ns: 5,
            sent_ns: 6,
            x_m: 7.0,
            y_m: 8.0,
            yaw_rad: 9.0,
            v_m_s: 10.0,
            w_rad_s: 11.0,
        };
        assert_eq!(Position::from(WirePosition::from(position)), position);
    }
}
