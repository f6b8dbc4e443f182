//! Odometries that have poses, and no speeds or speeds that their drivers leave zero.

use super::reading::Reading;
use super::survey::Topic;
use crate::decode::PoseSpeeds;
use crate::table::StreamKind;

/// Takes the speeds of an odometry from its poses, where it has no others. Returns a note for each.
pub(super) fn idle_twists(streams: &mut [Reading], topics: &[Topic]) -> Vec<String> {
    let idle = topics.iter().filter(|topic| topic.has_idle_twist());
    let mut notes = of_poses(streams, topics);
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

/// As [`idle_twists`], for odometries of a type that has a pose alone.
fn of_poses(streams: &mut [Reading], topics: &[Topic]) -> Vec<String> {
    let has_pose_alone = |name: &String| {
        let topic = topics.iter().find(|topic| topic.channel.topic == *name);
        topic.is_some_and(|topic| {
            let name = topic.type_name().trim_start_matches("struct:");
            name.starts_with("Pose")
        })
    };
    let odometries = streams
        .iter_mut()
        .filter(|own| own.source.kind == StreamKind::Odometry && has_pose_alone(&own.source.topic));
    odometries
        .map(|own| {
            own.stream.speeds = Some(PoseSpeeds::default());
            let name = &own.source.topic;
            format!("{name} has poses alone; the speeds of the odometry are those of its pose")
        })
        .collect()
}
