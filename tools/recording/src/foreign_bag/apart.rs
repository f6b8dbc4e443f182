//! Wheels that have a topic, or a transform, each: one row for each value of one wheel, with that of the other at the same time.

use super::clock::Clock;
use super::neighbours::{Around, MOST_GAP_S, Neighbours, known_until, passed, used};
use super::rigid;
use super::source::Quantity;
use super::turn::about;
use crate::decode::{Fields, StreamBuilder, wrapped};
use crate::rows::{Disk, Spool, rows_after, sorted_by_time};
use crate::table::Table;
use nalgebra::Vector3;
use slipstream_bag::ros::Encoding;
use slipstream_bag::ros::time::s_from_ns;
use slipstream_bag::{ChannelInfo, Undecodable, VisitResult};

/// Between counts that differ by more, a counter may have begun again: nothing lies between them.
const MOST_COUNTS: f64 = 8192.0;

/// Two wheels, right and left, being read.
pub(super) struct Apart {
    wheels: [WheelReading; 2],
    quantity: Quantity,
    /// The last row of wheels that turn.
    last: Option<[f64; 2]>,
    /// Rows that lie in gaps of the other.
    left_out: u64,
}

/// A wheel being read.
struct WheelReading {
    topic: String,
    take: Take,
    rows: Spool,
    is_stamped: bool,
}

/// What of a message is the wheel's.
pub(super) enum Take {
    /// A field.
    Field(Box<Fields>),
    /// The turn of a frame about an axis, in its parent.
    Turn {
        parent: String,
        child: String,
        /// In the frame of the parent, forward positive.
        axis: Vector3<f64>,
        first: Option<rigid::Rigid>,
    },
}

impl Apart {
    /// Nothing yet; `wheels` are right and left, with their topics.
    pub(super) fn new(wheels: [(String, Take); 2], quantity: Quantity, disk: &Disk) -> Self {
        let wheels = wheels.map(|(topic, take)| WheelReading {
            topic,
            take,
            rows: Spool::new(disk, Table::new(&["value"], Vec::new())),
            is_stamped: false,
        });
        Self {
            wheels,
            quantity,
            last: None,
            left_out: 0,
        }
    }

    /// The topics of both.
    pub(super) fn topics(&self) -> Vec<String> {
        self.wheels.iter().map(|own| own.topic.clone()).collect()
    }

    /// Takes what a message has of the wheels.
    pub(super) fn push(
        &mut self,
        channel: &ChannelInfo,
        data: &[u8],
        clock: Clock,
        log_ns: i64,
    ) -> VisitResult {
        let own = |wheel: &&mut WheelReading| wheel.topic == channel.topic;
        let pushed = self.wheels.iter_mut().filter(own).map(|wheel| {
            for (stamp_ns, value) in wheel.take.values(channel, data)? {
                wheel.is_stamped |= stamp_ns.is_some_and(|stamp_ns| stamp_ns != 0);
                if value.is_finite() {
                    let t_s = s_from_ns(clock.time_ns(stamp_ns, log_ns));
                    wheel.rows.push_numbers(t_s, [value]);
                }
            }
            Ok(())
        });
        // Both, even after one that fails.
        pushed.fold(Ok(()), VisitResult::and)
    }

    /// Puts the rows into a stream: at the times of the wheel whose messages have stamps, or else of the right one. Returns how
    /// many were left out because they lie in gaps of the other.
    pub(super) fn finish(mut self, stream: &mut StreamBuilder) -> u64 {
        self.put(stream, f64::INFINITY);
        self.left_out
    }

    /// Puts those rows into a stream that no later message changes. What is kept goes to another disk.
    pub(super) fn pass_on(&mut self, stream: &mut StreamBuilder, next: &Disk) {
        let (lead, other) = self.lead_and_other();
        self.sort();
        let [lead, other] = [lead, other].map(|index| &self.wheels[index].rows);
        let known_s = known_until(std::iter::once(other));
        let counts = [used(lead, known_s), passed(other, known_s)];
        self.put(stream, known_s);
        let (lead, other) = self.lead_and_other();
        for (index, count) in [lead, other].into_iter().zip(counts) {
            let wheel = &mut self.wheels[index];
            wheel.rows = rows_after(&wheel.rows, count, next);
        }
    }

    /// Puts all rows into a stream, and forgets the wheels: what follows has other times.
    pub(super) fn break_off(&mut self, stream: &mut StreamBuilder, next: &Disk) {
        self.put(stream, f64::INFINITY);
        self.last = None;
        for wheel in &mut self.wheels {
            drop(wheel.rows.take(next));
        }
    }

    /// The wheel at whose times rows stand, and the other: 0 is right, 1 is left.
    fn lead_and_other(&self) -> (usize, usize) {
        match !self.wheels[0].is_stamped && self.wheels[1].is_stamped {
            true => (1, 0),
            false => (0, 1),
        }
    }

    fn sort(&mut self) {
        for wheel in &mut self.wheels {
            wheel.rows = sorted_by_time(wheel.rows.take(&Disk::default()));
        }
    }

    /// Puts the rows up to a time (s) into a stream.
    fn put(&mut self, stream: &mut StreamBuilder, until_s: f64) {
        let leads_left = self.lead_and_other().0 == 1;
        let quantity = self.quantity;
        let is_turn = self
            .wheels
            .iter()
            .any(|own| matches!(own.take, Take::Turn { .. }));
        self.sort();
        let value = |table: &Table, row| table.number(0, row);
        let sorted = self.wheels.each_ref();
        let [mut right, mut left] = sorted.map(|own| Neighbours::new(&own.rows, value));
        let (lead, other) = match leads_left {
            true => (&mut left, &mut right),
            false => (&mut right, &mut left),
        };
        let mut last = self.last;
        while let Some((t_s, own)) = lead.next_until(until_s) {
            // Before the first and after the last value of the other, there is no row.
            let Some(around) = other.around(t_s) else {
                continue;
            };
            let Some(beside) = between(&around, quantity, is_turn) else {
                self.left_out += 1;
                continue;
            };
            let mut pair = if leads_left {
                [beside, own]
            } else {
                [own, beside]
            };
            if is_turn {
                let before = last.unwrap_or(pair);
                for (value, before) in pair.iter_mut().zip(before) {
                    *value = before + wrapped(*value - before);
                }
                last = Some(pair);
            }
            stream.push_wheels(t_s, pair);
        }
        self.last = last;
    }
}

impl Take {
    /// The values of a message, with their stamps (ns).
    fn values(
        &mut self,
        channel: &ChannelInfo,
        data: &[u8],
    ) -> Result<Vec<(Option<i64>, f64)>, Undecodable> {
        match self {
            Self::Field(fields) => {
                let (stamp_ns, [value, _]) = fields.read(data)?;
                Ok(vec![(stamp_ns, value)])
            }
            Self::Turn {
                parent,
                child,
                axis,
                first,
            } => {
                let encoding = Encoding::of(&channel.encoding).ok_or(Undecodable)?;
                let transforms = encoding.decode_transforms(data).map_err(|_| Undecodable)?;
                let own = transforms
                    .iter()
                    .filter(|own| own.header.frame_id == *parent && own.child_frame_id == *child);
                let values = own.filter_map(|own| {
                    let rotation = rigid::of_message(own)?;
                    let first = first.get_or_insert(rotation);
                    let angle_rad = about(axis, &first.rotation, &rotation.rotation);
                    Some((Some(own.header.stamp.ns()), angle_rad))
                });
                Ok(values.collect())
            }
        }
    }
}

/// The value of a wheel between two of its rows; `None` where they are too far apart to tell.
fn between(around: &Around<f64>, quantity: Quantity, is_turn: bool) -> Option<f64> {
    let Around {
        before,
        after,
        share,
        gap_s,
    } = *around;
    let step = match is_turn {
        true => wrapped(after - before),
        false => after - before,
    };
    if gap_s > MOST_GAP_S && step != 0.0 {
        return None;
    }
    let most = match quantity {
        Quantity::Ticks => MOST_COUNTS,
        Quantity::Angle => std::f64::consts::PI,
        Quantity::Speed | Quantity::Torque | Quantity::Voltage => f64::INFINITY,
    };
    if step.abs() > most {
        return Some(if share < 0.5 { before } else { after });
    }
    Some(before + step * share)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nothing_is_invented_across_gaps_and_jumps_of_counters() {
        let around = |before, after, gap_s| Around {
            before,
            after,
            share: 0.25,
            gap_s,
        };
        let ticks = |around| between(&around, Quantity::Ticks, false);
        assert_eq!(ticks(around(10.0, 20.0, 0.1)), Some(12.5));
        assert_eq!(ticks(around(32760.0, -32770.0, 0.1)), Some(32760.0));
        assert_eq!(ticks(around(10.0, 20.0, 2.0)), None);
        // A driver that sends changes alone: the counter stood still.
        assert_eq!(ticks(around(10.0, 10.0, 2.0)), Some(10.0));
        let turn = between(&around(3.1, -3.1, 0.1), Quantity::Angle, true).unwrap();
        assert!((turn - 3.1 - 0.25 * 0.083_185).abs() < 1e-6, "{turn}");
    }
}
