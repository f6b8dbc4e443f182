//! A block of rows as bytes: column after column, the times first.

use crate::table::{Cells, Table};

/// Number of rows of a block.
pub(super) const BLOCK_ROWS: usize = 1024;
/// A block ends earlier if its texts are longer than this (bytes).
pub(super) const BLOCK_TEXT_BYTES: usize = 1 << 20;
/// Size of a number (bytes).
const NUMBER_BYTES: usize = 8;

/// Appends the rows of a table to `bytes`.
pub(super) fn encode(table: &Table, bytes: &mut Vec<u8>) {
    put_numbers(&table.t_s, bytes);
    for (_, cells) in &table.columns {
        match cells {
            Cells::Numbers(cells) => put_numbers(cells, bytes),
            Cells::Counts(cells) => {
                bytes.extend(cells.iter().flat_map(|c| c.unwrap_or(0).to_le_bytes()));
                bytes.extend(cells.iter().map(|c| u8::from(c.is_some())));
            }
            Cells::Texts(cells) => put_texts(cells, bytes),
        }
    }
    for column in &table.unknown {
        put_texts(&column.cells, bytes);
    }
}

/// Replaces the rows of a table with the `rows` rows in `bytes`, which hold the same columns.
pub(super) fn decode(mut bytes: &[u8], rows: usize, table: &mut Table) {
    table.clear();
    take_numbers(&mut bytes, rows, &mut table.t_s);
    for (_, cells) in &mut table.columns {
        match cells {
            Cells::Numbers(cells) => take_numbers(&mut bytes, rows, cells),
            Cells::Counts(cells) => {
                let counts = take(&mut bytes, rows * NUMBER_BYTES);
                let present = take(&mut bytes, rows);
                let counts = numbers_in(counts).map(i64::from_le_bytes);
                cells.extend(counts.zip(present).map(|(c, is)| (*is != 0).then_some(c)));
            }
            Cells::Texts(cells) => take_texts(&mut bytes, rows, cells),
        }
    }
    for column in &mut table.unknown {
        take_texts(&mut bytes, rows, &mut column.cells);
    }
}

/// Number of bytes of the times at the start of a block.
pub(super) fn time_bytes(rows: usize) -> usize {
    rows * NUMBER_BYTES
}

/// Appends the numbers in `bytes` to `numbers`.
pub(super) fn decode_numbers(bytes: &[u8], numbers: &mut Vec<f64>) {
    numbers.extend(numbers_in(bytes).map(f64::from_le_bytes));
}

fn put_numbers(numbers: &[f64], bytes: &mut Vec<u8>) {
    bytes.extend(numbers.iter().flat_map(|number| number.to_le_bytes()));
}

fn put_texts(texts: &[String], bytes: &mut Vec<u8>) {
    for text in texts {
        bytes.extend((text.len() as u64).to_le_bytes());
        bytes.extend(text.as_bytes());
    }
}

fn take<'a>(bytes: &mut &'a [u8], count: usize) -> &'a [u8] {
    let (taken, rest) = bytes.split_at(count.min(bytes.len()));
    *bytes = rest;
    taken
}

fn take_numbers(bytes: &mut &[u8], rows: usize, numbers: &mut Vec<f64>) {
    decode_numbers(take(bytes, rows * NUMBER_BYTES), numbers);
}

fn take_texts(bytes: &mut &[u8], rows: usize, texts: &mut Vec<String>) {
    for _ in 0..rows {
        let length = numbers_in(take(bytes, NUMBER_BYTES)).next();
        let length = length.map_or(0, u64::from_le_bytes);
        let text = take(bytes, usize::try_from(length).unwrap_or(0));
        texts.push(String::from_utf8_lossy(text).into_owned());
    }
}

fn numbers_in(bytes: &[u8]) -> impl Iterator<Item = [u8; NUMBER_BYTES]> {
    bytes.as_chunks::<NUMBER_BYTES>().0.iter().copied()
}
