//! Odometries whose drivers fill the pose and leave the speeds zero.

use super::reading::Reading;
use super::survey::Topic;
use crate::decode::PoseSpeeds;
use crate::table::StreamKind;

/// Takes the speeds of an odometry from its poses, where its driver leaves them zero. Returns a note for each.
pub(super) fn idle_twists(streams: &mut [Reading], topics: &[Topic]) -> Vec<String> {
    let idle = topics.iter().filter(|topic| topic.has_idle_twist());
    let mut notes = Vec::new();
    for name in idle.map(|topic| &topic.channel.topic) {
        let is_own = |own: &Reading, kind| own.source.topic == *name && own.source.kind == kind;
        // its pose cannot be compared with itself
        let is_pose = streams.iter().any(|own| is_own(own, StreamKind::Pose));
        let odometry = streams
            .iter_mut()
            .find(|own| is_own(own, StreamKind::Odometry));
        let Some(odometry) = odometry else {
            continue;
        };
        let statement = format!("the twist of {name} is zero throughout although its pose moves");
        notes.push(if is_pose {
            format!("{statement}; let the driver fill it")
        } else {
            odometry.stream.speeds = Some(PoseSpeeds::default());
            format!("{statement}; the speeds of the odometry are those of its pose")
        });
    }
    notes
}
