//! Where the frames of a bag's transforms are in the robot's base.

use std::collections::BTreeMap;

use super::rigid::Rigid;
use super::survey::{Seen, Topic};

/// Longest way from a frame to its base.
const MOST_LINKS: usize = 100;

/// All transforms, by their child.
pub(super) struct Frames<'a>(BTreeMap<&'a str, Link<'a>>);

/// The transform from a frame's parent to it.
#[derive(Clone, Copy)]
pub(super) struct Link<'a> {
    pub(super) topic: &'a Topic,
    pub(super) parent: &'a str,
    pub(super) child: &'a str,
    pub(super) seen: &'a Seen,
}

/// Where a frame is in the base.
pub(super) struct InBase<'a> {
    pub(super) base: &'a str,
    /// The parent of the frame.
    pub(super) parent: Rigid,
    /// The frame, at its last place.
    pub(super) place: Rigid,
}

impl<'a> Frames<'a> {
    /// The transforms of all topics.
    pub(super) fn of(topics: &'a [Topic]) -> Self {
        let mut links = BTreeMap::new();
        for topic in topics {
            for ([parent, child], seen) in &topic.frames {
                let link = Link {
                    topic,
                    parent,
                    child,
                    seen,
                };
                links.entry(child.as_str()).or_insert(link);
            }
        }
        Self(links)
    }

    /// All transforms, sorted by their child.
    pub(super) fn links(&self) -> impl Iterator<Item = Link<'a>> {
        self.0.values().copied()
    }

    /// The transform to this frame.
    pub(super) fn link(&self, child: &str) -> Option<Link<'a>> {
        self.0.get(child).copied()
    }

    /// Where a frame is in the base: the frame of that name, or else the one farthest up in which the parent never moves.
    pub(super) fn in_base(&self, link: Link<'a>) -> Option<InBase<'a>> {
        let mut base = link.parent;
        let mut parent = Rigid::identity();
        for _ in 0..MOST_LINKS {
            let up = self.0.get(base).filter(|up| !up.seen.varies);
            let Some((up, place)) = up.and_then(|up| Some((up, up.seen.place?))) else {
                break;
            };
            if is_base(base) {
                break;
            }
            parent = place * parent;
            base = up.parent;
        }
        let place = parent * link.seen.place?;
        Some(InBase {
            base,
            parent,
            place,
        })
    }
}

/// Whether a frame is named as the base of a robot.
pub(super) fn is_base(frame: &str) -> bool {
    let name = frame.rsplit('/').next().unwrap_or_default();
    matches!(name, "base_link" | "base_footprint" | "base")
}
