//! Pieces of a recording as one recording again.

use crate::recording::{Recording, Robot};
use crate::table::{StreamKind, Table, TableView};

/// The rows from `from_s` on of pieces of one recording that follow each other, as one recording; `None` without a piece. A
/// row whose time lies behind one of an earlier row is left out: times of a stream never decrease.
pub fn joined<'a>(
    pieces: impl Iterator<Item = &'a Recording> + Clone,
    from_s: f64,
) -> Option<Recording> {
    let mut whole = pieces.clone().next()?.clone();
    for robot in &mut whole.robots {
        let name = robot.name.clone();
        let parts = pieces.clone().filter_map(|piece| piece.robot(&name));
        for kind in StreamKind::ALL {
            if let Some(table) = column(parts.clone(), kind, from_s) {
                table.store_in(robot, kind);
            }
        }
    }
    if let Some(links) = &mut whole.links {
        let parts = pieces.filter_map(|piece| piece.links.as_ref());
        let all = parts.flat_map(|part| &part.messages);
        links.messages = all.filter(|own| own.t_sent_s >= from_s).cloned().collect();
        links.unknown.clear();
    }
    Some(whole)
}

/// One stream of all pieces.
fn column<'a>(
    parts: impl Iterator<Item = &'a Robot> + Clone,
    kind: StreamKind,
    from_s: f64,
) -> Option<Table> {
    let mut views = parts.filter_map(|robot| TableView::of(robot, kind));
    let first = views.next()?;
    let mut whole = first.empty();
    let mut block = first.empty();
    let mut last_s = from_s;
    for view in std::iter::once(first).chain(views) {
        view.block(0..view.t_s.len(), &mut block);
        for row in 0..block.t_s.len() {
            let t_s = block.t_s[row];
            if t_s >= last_s {
                whole.push_from(&block, row);
                last_s = t_s;
            }
        }
    }
    Some(whole)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::pieces::Pieces;
    use crate::recording::{Odometry, Stream};

    #[test]
    fn pieces_together_are_the_recording() {
        let t_s: Vec<f64> = (0..100).map(|k| f64::from(k) * 0.1).collect();
        let mut robot = Robot::named("r1");
        robot.odometry = Some(Stream {
            values: Odometry {
                v_m_s: t_s.clone(),
                w_rad_s: None,
            },
            t_s: t_s.clone(),
            unknown: Vec::new(),
        });
        let recording = Recording {
            robots: vec![robot],
            ..Recording::default()
        };
        let pieces: Vec<Recording> = Pieces::new(recording, 0.5).map(|own| own.1).collect();
        let speeds = |from_s: f64| {
            let whole = joined(pieces.iter(), from_s).unwrap();
            whole.robots[0].odometry.clone().unwrap().values.v_m_s
        };
        assert_eq!(speeds(f64::NEG_INFINITY), t_s);
        assert_eq!(speeds(5.0), t_s[50..]);
    }
}
