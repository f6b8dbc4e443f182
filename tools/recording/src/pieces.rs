//! A recording in memory, cut into pieces of time.

use crate::recording::{Links, Recording, Robot, UnknownColumn};
use crate::table::{StreamKind, Table, TableView};

/// Pieces of a recording, one after the other: the time at which a piece ends (s), and its rows. Where nothing was recorded,
/// there is no piece. Every piece has all robots with all of their streams, some without rows; round trips of a network, which
/// have no times, are in the first one.
#[derive(Debug)]
pub struct Pieces {
    recording: Recording,
    /// The recording without rows.
    empty: Recording,
    length_s: f64,
    /// The next row of each stream, robot by robot.
    next: Vec<[usize; StreamKind::ALL.len()]>,
    next_link: usize,
}

impl Pieces {
    /// Cuts a recording into pieces of at most `length_s`.
    pub fn new(recording: Recording, length_s: f64) -> Self {
        let robots = recording.robots.iter().map(without_streams).collect();
        let empty = Recording {
            name: recording.name.clone(),
            origin: recording.origin.clone(),
            read_from: recording.read_from,
            same_robot: recording.same_robot,
            notes: recording.notes.clone(),
            robots,
            links: None,
            rtt: None,
            model: recording.model.clone(),
        };
        Self {
            next: vec![[0; StreamKind::ALL.len()]; recording.robots.len()],
            next_link: 0,
            recording,
            empty,
            length_s,
        }
    }

    /// The time of the first row that no piece has (s).
    fn next_s(&self) -> Option<f64> {
        let rows = self.recording.robots.iter().zip(&self.next);
        let of_robots = rows.flat_map(|(robot, next)| {
            let kinds = StreamKind::ALL.into_iter().zip(next);
            kinds.filter_map(|(kind, row)| TableView::of(robot, kind)?.t_s.get(*row).copied())
        });
        let links = self.recording.links.as_ref();
        let link = links.and_then(|links| links.messages.get(self.next_link));
        of_robots
            .chain(link.map(|own| own.t_sent_s))
            .reduce(f64::min)
    }

    /// The position messages before a time.
    fn links(&mut self, is_in: &dyn Fn(f64) -> bool) -> Option<Links> {
        let links = self.recording.links.as_ref()?;
        let rest = links.messages.get(self.next_link..).unwrap_or_default();
        let count = rest.iter().take_while(|own| is_in(own.t_sent_s)).count();
        let rows = self.next_link..self.next_link + count;
        self.next_link = rows.end;
        let cells = |column: &UnknownColumn| UnknownColumn {
            name: column.name.clone(),
            cells: column.cells.get(rows.clone()).unwrap_or_default().to_vec(),
        };
        Some(Links {
            messages: rest.get(..count).unwrap_or_default().to_vec(),
            with_velocity: links.with_velocity,
            unknown: links.unknown.iter().map(cells).collect(),
        })
    }
}

impl Iterator for Pieces {
    type Item = (f64, Recording);

    fn next(&mut self) -> Option<(f64, Recording)> {
        let begin_s = match (self.next_s(), &self.recording.rtt) {
            (Some(begin_s), _) => begin_s,
            (None, Some(_)) => 0.0,
            (None, None) => return None,
        };
        let end_s = begin_s + self.length_s;
        // The first row always: whatever its time is, no piece but the last is empty.
        let is_in = |t_s: f64| t_s <= begin_s || t_s < end_s || t_s.is_nan();
        let mut piece = self.empty.clone();
        piece.rtt = self.recording.rtt.take();
        piece.links = self.links(&is_in);
        let robots = self.recording.robots.iter().zip(&mut piece.robots);
        for ((robot, own), next) in robots.zip(&mut self.next) {
            for (kind, next) in StreamKind::ALL.into_iter().zip(next) {
                let Some(view) = TableView::of(robot, kind) else {
                    continue;
                };
                let rest = view.t_s.get(*next..).unwrap_or_default();
                let rows = *next..*next + rest.iter().take_while(|t_s| is_in(**t_s)).count();
                *next = rows.end;
                let mut table: Table = view.empty();
                view.block(rows, &mut table);
                table.store_in(own, kind);
            }
        }
        Some((end_s, piece))
    }
}

fn without_streams(robot: &Robot) -> Robot {
    Robot {
        encoder_counts_per_rev: robot.encoder_counts_per_rev,
        pose_point: robot.pose_point,
        imu_kind: robot.imu_kind,
        noise: robot.noise,
        notes: robot.notes.clone(),
        ..Robot::named(&robot.name)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::recording::{Odometry, Stream};

    #[test]
    fn times_that_cannot_be_divided_still_come_to_an_end() {
        for t_s in [f64::NAN, f64::INFINITY, 1e300, -1e300] {
            let odometry = Stream {
                t_s: vec![t_s, t_s, 0.0],
                values: Odometry {
                    v_m_s: vec![1.0, 2.0, 3.0],
                    w_rad_s: None,
                },
                unknown: Vec::new(),
            };
            let mut robot = Robot::named("r1");
            robot.odometry = Some(odometry);
            let recording = Recording {
                robots: vec![robot],
                ..Recording::default()
            };
            let pieces = Pieces::new(recording, 0.5).take(10);
            let rows =
                pieces.filter_map(|(_, own)| Some(own.robots.first()?.odometry.as_ref()?.len()));
            assert_eq!(rows.sum::<usize>(), 3, "{t_s}");
        }
    }
}
