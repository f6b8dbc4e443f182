//! Wheels among transforms: frames that turn about an axle across the robot, while their place in the base stays.

use nalgebra::Vector3;

use super::apart::Take;
use super::candidate::{Candidate, robot_of_topic};
use super::frames::{Frames, Link};
use super::joints::is_driven;
use super::places::{are_mirrored, side_of_place, turns_across};
use super::source::{Quantity, Source};
use crate::decode::MessageSelector;
use crate::sides::{Side, words_of};
use crate::table::StreamKind;

/// A wheel of another name turns at least by so much (rad) in a recording; arms do not.
const ONE_TURN_RAD: f64 = std::f64::consts::TAU;
/// A frame that is called a wheel turns at least by so much (rad).
const LEAST_TURN_RAD: f64 = 0.2;

/// So many frames that turn are looked at.
const MOST: usize = 100;

/// A frame that turns as a wheel does.
struct RollingFrame<'a> {
    link: Link<'a>,
    base: &'a str,
    /// Its middle in the base (m).
    place: Vector3<f64>,
}

/// The wheels of robots, two each, as streams.
pub(super) fn wheels(frames: &Frames<'_>) -> Vec<Candidate> {
    let rolling: Vec<RollingFrame<'_>> = frames
        .links()
        .filter_map(|own| of(frames, own))
        .take(MOST)
        .collect();
    let of_side = |side| {
        let own = move |own: &&RollingFrame<'_>| side_of_place(&own.place) == Some(side);
        rolling.iter().filter(own)
    };
    let mut wheels = Vec::new();
    for right in of_side(Side::Right) {
        let left = of_side(Side::Left)
            .find(|left| left.base == right.base && are_mirrored(&left.place, &right.place));
        wheels.extend(left.map(|left| candidate(right.link, left.link)));
    }
    wheels
}

fn of<'a>(frames: &Frames<'a>, link: Link<'a>) -> Option<RollingFrame<'a>> {
    let is_wheel = words_of(link.child)
        .iter()
        .any(|word| word.contains("wheel"));
    let least_rad = if is_wheel {
        LEAST_TURN_RAD
    } else {
        ONE_TURN_RAD
    };
    if !is_driven(link.child) || !turns_across(frames, link, least_rad) {
        return None;
    }
    let own = frames.in_base(link)?;
    Some(RollingFrame {
        link,
        base: own.base,
        place: own.place.translation.vector,
    })
}

fn candidate(right: Link<'_>, left: Link<'_>) -> Candidate {
    let frame = right.child.trim_start_matches('/');
    let robot = robot_of_topic(&format!("/{frame}"));
    let parent = (right.parent == left.parent).then(|| right.parent.to_owned());
    Candidate {
        source: Source {
            selector: MessageSelector {
                joints: [right, left].map(|own| vec![own.child.to_owned()]),
                parent,
                frame: None,
            },
            quantity: Some(Quantity::Angle),
            ..Source::of(&robot, StreamKind::Wheels, &right.topic.channel.topic)
        },
        rank: 1,
        messages: right.seen.count.min(left.seen.count),
    }
}

/// How to read the turn of a frame, with its topic. The angle is that about its axle to the left: forward is positive.
///
/// # Errors
/// Problem and remedy, if there is no such frame or it does not turn about one axis.
pub(super) fn take(
    frames: &Frames<'_>,
    child: &str,
    parent: Option<&str>,
) -> Result<(String, Take), (String, String)> {
    let link = frames.link(child);
    let Some(link) = link.filter(|own| parent.is_none_or(|parent| own.parent == parent)) else {
        let known: Vec<&str> = frames.links().map(|own| own.child).take(20).collect();
        let remedy = format!("name one of: {}", known.join(", "));
        return Err((format!("has no transform to {child}"), remedy));
    };
    let axis = link.seen.turned.axis(0.0).zip(frames.in_base(link));
    let Some((axis, own)) = axis else {
        let problem = format!(
            "the frame {child} does not turn about one axis in {}",
            link.parent
        );
        let remedy = "name the frames of two wheels, or leave the stream out".to_owned();
        return Err((problem, remedy));
    };
    let is_forward = (own.parent.rotation * axis).y >= 0.0;
    let take = Take::Turn {
        parent: link.parent.to_owned(),
        child: child.to_owned(),
        axis: if is_forward { axis } else { -axis },
        first: None,
    };
    Ok((link.topic.channel.topic.clone(), take))
}
