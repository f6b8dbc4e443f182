//! Position messages and round trips in memory, as tables of columns.

use std::ops::Range;

use super::cells::{Cells, part};
use super::columns::Table;
use crate::recording::{LinkMessage, Links, RoundTrips, UnknownColumn};

/// Replaces the rows of `block`, made by [`Table::of_links`], with these messages. Returns whether
/// there are any.
pub(crate) fn link_block(links: &Links, rows: Range<usize>, block: &mut Table) -> bool {
    block.clear();
    let messages = part(&links.messages, &rows);
    block.t_s.extend(messages.iter().map(|m| m.t_sent_s));
    for (name, cells) in &mut block.columns {
        match cells {
            Cells::Numbers(cells) => cells.extend(messages.iter().map(|m| number_of(m, name))),
            Cells::Texts(cells) => {
                let name_of =
                    |m: &LinkMessage| if *name == "from" { &m.from } else { &m.to }.to_string();
                cells.extend(messages.iter().map(name_of));
            }
            Cells::Counts(_) => {}
        }
    }
    copy_unknown(&links.unknown, &rows, block);
    !block.t_s.is_empty()
}

/// Replaces the rows of `block`, made by [`Table::of_round_trips`], with these round trips. Returns
/// whether there are any.
pub(crate) fn round_trip_block(trips: &RoundTrips, rows: Range<usize>, block: &mut Table) -> bool {
    block.clear();
    let seq = part(&trips.seq, &rows);
    block.t_s.resize(seq.len(), 0.0);
    for (_, cells) in &mut block.columns {
        match cells {
            Cells::Counts(cells) => cells.extend(seq.iter().map(|seq| Some(*seq))),
            Cells::Numbers(cells) => cells.extend_from_slice(part(&trips.rtt_ms, &rows)),
            Cells::Texts(_) => {}
        }
    }
    copy_unknown(&trips.unknown, &rows, block);
    !block.t_s.is_empty()
}

fn copy_unknown(unknown: &[UnknownColumn], rows: &Range<usize>, block: &mut Table) {
    for (column, of) in block.unknown.iter_mut().zip(unknown) {
        column.cells.extend_from_slice(part(&of.cells, rows));
    }
}

fn number_of(message: &LinkMessage, column: &str) -> f64 {
    match column {
        "t_received_s" => message.t_received_s.unwrap_or(f64::NAN),
        "x_m" => message.x_m,
        "y_m" => message.y_m,
        "yaw_rad" => message.yaw_rad,
        "v_m_s" => message.v_m_s,
        "w_rad_s" => message.w_rad_s,
        _ => f64::NAN,
    }
}
