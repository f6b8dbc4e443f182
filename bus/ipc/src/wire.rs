//! Memory layout of the messages in shared memory (`repr(C)`).
//!
//! The type name contains the version of the layout: builds with different layouts do not connect.

use iceoryx2::prelude::ZeroCopySend;
use slipstream_bus::message::{Actuation, DriveCommand, Encoders, Extra, MAX_EXTRA, Position};

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

/// [`DriveCommand`], agent to plant.
#[derive(Debug, Clone, Copy, Default, PartialEq, ZeroCopySend)]
#[type_name("slipstream.Drive.2")]
#[repr(C)]
pub(crate) struct WireDrive {
    robot: u32,
    epoch: u32,
    tick_ns: i64,
    /// 0: torques, 1: a twist.
    kind: u32,
    /// Padding.
    reserved: u32,
    values: [f64; 2],
}

/// [`Position`], robot to those that hear it.
#[derive(Debug, Clone, Copy, Default, PartialEq, ZeroCopySend)]
#[type_name("slipstream.Position.2")]
#[repr(C)]
pub struct WirePosition {
    /// The sender.
    pub(crate) from: u32,
    seq: u32,
    token_round: u32,
    /// How many of `extra` there are.
    extra_len: u32,
    sampled_ns: i64,
    tick_ns: i64,
    sent_ns: i64,
    x_m: f64,
    y_m: f64,
    yaw_rad: f64,
    v_m_s: f64,
    w_rad_s: f64,
    extra: [f64; MAX_EXTRA],
}

impl From<Encoders> for WireEncoders {
    fn from(Encoders { sampled_ns, counts }: Encoders) -> Self {
        Self { sampled_ns, counts }
    }
}

impl From<WireEncoders> for Encoders {
    fn from(WireEncoders { sampled_ns, counts }: WireEncoders) -> Self {
        Self { sampled_ns, counts }
    }
}

impl From<DriveCommand> for WireDrive {
    fn from(command: DriveCommand) -> Self {
        let (kind, values) = match command.actuation {
            Actuation::Torque(values) => (0, values),
            Actuation::Twist(values) => (1, values),
        };
        Self {
            robot: command.robot,
            epoch: command.epoch,
            tick_ns: command.tick_ns,
            kind,
            reserved: 0,
            values,
        }
    }
}

impl From<WireDrive> for DriveCommand {
    fn from(wire: WireDrive) -> Self {
        Self {
            robot: wire.robot,
            epoch: wire.epoch,
            tick_ns: wire.tick_ns,
            actuation: match wire.kind {
                0 => Actuation::Torque(wire.values),
                _ => Actuation::Twist(wire.values),
            },
        }
    }
}

impl From<Position> for WirePosition {
    fn from(position: Position) -> Self {
        let extra_len = position.extra.numbers().len();
        Self {
            from: position.from,
            seq: position.seq,
            token_round: position.token_round,
            extra_len: u32::try_from(extra_len).unwrap_or_default(),
            sampled_ns: position.sampled_ns,
            tick_ns: position.tick_ns,
            sent_ns: position.sent_ns,
            x_m: position.x_m,
            y_m: position.y_m,
            yaw_rad: position.yaw_rad,
            v_m_s: position.v_m_s,
            w_rad_s: position.w_rad_s,
            extra: position.extra.places(),
        }
    }
}

impl From<WirePosition> for Position {
    fn from(wire: WirePosition) -> Self {
        Self {
            from: wire.from,
            seq: wire.seq,
            token_round: wire.token_round,
            sampled_ns: wire.sampled_ns,
            tick_ns: wire.tick_ns,
            sent_ns: wire.sent_ns,
            x_m: wire.x_m,
            y_m: wire.y_m,
            yaw_rad: wire.yaw_rad,
            v_m_s: wire.v_m_s,
            w_rad_s: wire.w_rad_s,
            extra: Extra::from_parts(wire.extra_len, wire.extra),
        }
    }
}

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
            extra: Extra::new(&[12.0, 13.0]).unwrap(),
        };
        assert_eq!(Position::from(WirePosition::from(position)), position);
    }
}
