//! Poses composed along a chain of transforms.
//!
//! The first transform that moves is the one that carries a reference: motion capture, or the correction that a
//! localisation makes. Poses stand at its times, and the others are interpolated there: between those times, the
//! composed pose would be the others' alone, such as odometry.

use std::fmt::Write as _;

use slipstream_bag::ros::Encoding;
use slipstream_bag::ros::messages::TransformStamped;
use slipstream_bag::ros::time::s_from_ns;
use slipstream_bag::{ChannelInfo, Undecodable, VisitResult};

use super::chain::{Chain, Link};
use super::clock::Clock;
use super::neighbours::{MOST_GAP_S, Neighbours, known_until, passed, used};
use super::rigid::{Rigid, between, in_plane, of_message};
use crate::decode::StreamBuilder;
use crate::rows::{Disk, Spool, rows_after, sorted_by_time};
use crate::table::Table;

/// A stamp may lie so far (ns) ahead of the reception of its message: a localisation lets its correction hold for
/// some time to come. By more, the clocks differ.
const MOST_AHEAD_NS: i64 = 2_000_000_000;
/// A place as numbers: m, and a rotation as i, j, k, w.
const COLUMNS: [&str; 7] = ["x", "y", "z", "i", "j", "k", "w"];

/// A pose being composed.
pub(super) struct Composed {
    chain: Chain,
    /// The links that move, in the order of the chain.
    moving: Vec<Moving>,
    /// The longest time that a correction's stamp lay ahead of its reception (ns).
    ahead_ns: i64,
    poses: ComposedPoses,
}

/// A link that moves.
struct Moving {
    link: Link,
    rows: Spool,
    last: Option<Rigid>,
}

impl Composed {
    /// Nothing yet.
    pub(super) fn new(chain: Chain, disk: &Disk) -> Self {
        let moving = chain.links.iter().filter(|link| link.fixed.is_none());
        let moving = moving.map(|link| Moving {
            link: link.clone(),
            rows: Spool::new(disk, Table::new(&COLUMNS, Vec::new())),
            last: None,
        });
        Self {
            moving: moving.collect(),
            chain,
            ahead_ns: 0,
            poses: ComposedPoses::default(),
        }
    }

    /// The chain.
    pub(super) fn chain(&self) -> &Chain {
        &self.chain
    }

    /// Takes what a message has of the links that move.
    pub(super) fn push(
        &mut self,
        channel: &ChannelInfo,
        data: &[u8],
        clock: Clock,
        log_ns: i64,
    ) -> VisitResult {
        let mut moving = self.moving.iter();
        if !moving.any(|moving| moving.link.topic == channel.topic) {
            return Ok(());
        }
        let encoding = Encoding::of(&channel.encoding).ok_or(Undecodable)?;
        let transforms = encoding.decode_transforms(data).map_err(|_| Undecodable)?;
        for transform in &transforms {
            self.push_transform(&channel.topic, transform, clock, log_ns);
        }
        Ok(())
    }

    fn push_transform(
        &mut self,
        topic: &str,
        transform: &TransformStamped<String>,
        clock: Clock,
        log_ns: i64,
    ) {
        let is_it = |moving: &Moving| {
            let [parent, child] = &moving.link.frames;
            moving.link.topic == topic
                && *parent == transform.header.frame_id
                && *child == transform.child_frame_id
        };
        let Some(index) = self.moving.iter().position(is_it) else {
            return;
        };
        let Some(place) = of_message(transform) else {
            return;
        };
        let mut stamp_ns = Some(transform.header.stamp.ns());
        let is_correction = index == 0 && self.moving.len() > 1;
        let Some(moving) = self.moving.get_mut(index) else {
            return;
        };
        if is_correction {
            // Sent again without a new measurement.
            if moving.last == Some(place) {
                return;
            }
            let ahead_ns = stamp_ns.map_or(0, |stamp_ns| stamp_ns.saturating_sub(log_ns));
            // What was received before its stamp was measured before it, too.
            if (1..MOST_AHEAD_NS).contains(&ahead_ns) {
                self.ahead_ns = self.ahead_ns.max(ahead_ns);
                stamp_ns = Some(log_ns);
            }
        }
        moving.last = Some(place);
        moving.push(s_from_ns(clock.time_ns(stamp_ns, log_ns)), &place);
    }

    /// Puts the poses into a stream. Returns what a person should know about them.
    pub(super) fn finish(mut self, stream: &mut StreamBuilder) -> String {
        self.put(stream, f64::INFINITY);
        let names: Vec<String> = self.moving.iter().map(|own| own.link.name()).collect();
        let stream = format!("{}/{}", stream.robot, stream.kind.name());
        let chain = self.chain.name();
        format!(
            "{stream}: composed of {chain}; {}",
            self.poses.in_words(&names, self.ahead_ns)
        )
    }

    /// Puts those poses into a stream that no later message changes. What is kept goes to another disk.
    pub(super) fn pass_on(&mut self, stream: &mut StreamBuilder, next: &Disk) {
        self.sort();
        let others = self.moving.iter().skip(1).map(|own| &own.rows);
        let known_s = known_until(others);
        self.put(stream, known_s);
        for (index, moving) in self.moving.iter_mut().enumerate() {
            let count = match index {
                0 => used(&moving.rows, known_s),
                _ => passed(&moving.rows, known_s),
            };
            moving.rows = rows_after(&moving.rows, count, next);
        }
    }

    /// Puts all poses into a stream, and forgets the transforms: what follows has other times.
    pub(super) fn break_off(&mut self, stream: &mut StreamBuilder, next: &Disk) {
        self.put(stream, f64::INFINITY);
        for moving in &mut self.moving {
            drop(moving.rows.take(next));
            moving.last = None;
        }
    }

    fn sort(&mut self) {
        for moving in &mut self.moving {
            moving.rows = sorted_by_time(moving.rows.take(&Disk::default()));
        }
    }

    /// Puts the poses up to a time (s) into a stream.
    fn put(&mut self, stream: &mut StreamBuilder, until_s: f64) {
        self.sort();
        let rows = self.moving.iter().map(|own| &own.rows);
        let mut places: Vec<Neighbours<'_, Rigid>> =
            rows.map(|rows| Neighbours::new(rows, place_in)).collect();
        let Some((first, others)) = places.split_first_mut() else {
            return;
        };
        while let Some((t_s, place)) = first.next_until(until_s) {
            let others = others.iter_mut().map(|places| place_at(places, t_s));
            let Some(others) = others.collect::<Option<Vec<Rigid>>>() else {
                self.poses.left_out += 1;
                continue;
            };
            let moving = std::iter::once(place).chain(others);
            stream.push_pose(t_s, in_plane(&self.chain.place(moving)));
            self.poses.add(t_s);
        }
    }
}

/// How many poses were composed.
#[derive(Debug, Default)]
struct ComposedPoses {
    rows: u64,
    /// Those for which not all transforms are known.
    left_out: u64,
    /// First and last time (s).
    span_s: Option<[f64; 2]>,
}

impl ComposedPoses {
    fn add(&mut self, t_s: f64) {
        self.rows += 1;
        self.span_s = Some([self.span_s.map_or(t_s, |[first, _]| first), t_s]);
    }

    /// `moving` are the names of the links that move.
    fn in_words(&self, moving: &[String], ahead_ns: i64) -> String {
        let [first_s, last_s] = self.span_s.unwrap_or_default();
        let rate = self.rows.saturating_sub(1) as f64 / (last_s - first_s).max(f64::MIN_POSITIVE);
        let reference = moving.first().map_or("", String::as_str);
        let rows = self.rows;
        let mut text = format!("{rows} rows, {rate:.1} per second, ");
        text.push_str(&match moving.len() {
            1 => format!("those of {reference}"),
            _ => format!(
                "one where {reference} changes: a localisation, whose error lasts and which jumps"
            ),
        });
        // Writing to a string cannot fail.
        if self.left_out > 0 {
            let _ = write!(
                text,
                "; {} more are left out: the other transforms are not known within {MOST_GAP_S} s",
                self.left_out
            );
        }
        if ahead_ns > 0 {
            let _ = write!(
                text,
                "; its stamps lie up to {:.2} s ahead of reception, whose times stand for them",
                ahead_ns as f64 * 1e-9
            );
        }
        text
    }
}

impl Moving {
    fn push(&mut self, t_s: f64, place: &Rigid) {
        let (offset, rotation) = (place.translation.vector, place.rotation.coords);
        let numbers = offset.iter().chain(rotation.iter());
        self.rows.push_numbers(t_s, numbers.copied());
    }
}

/// The place in a row.
fn place_in(table: &Table, row: usize) -> Rigid {
    let number = |column| table.number(column, row);
    let rotation = nalgebra::Quaternion::new(number(6), number(3), number(4), number(5));
    Rigid::from_parts(
        nalgebra::Translation3::new(number(0), number(1), number(2)),
        nalgebra::Unit::new_unchecked(rotation),
    )
}

/// The place of a link at a time; `None` where it is not known, and in gaps.
fn place_at(places: &mut Neighbours<'_, Rigid>, t_s: f64) -> Option<Rigid> {
    let around = places.around(t_s)?;
    match around.share {
        0.0 => Some(around.after),
        share => {
            (around.gap_s <= MOST_GAP_S).then(|| between(&around.before, &around.after, share))
        }
    }
}
