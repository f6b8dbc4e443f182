//! One column of the wheels, row by row.

use crate::rows::Rows;

/// A cell that is not empty.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Sample {
    pub(super) row: usize,
    pub(super) t_s: f64,
    /// Counts or rad.
    pub(super) value: f64,
}

/// A column of counts or angles.
#[derive(Debug, Clone, Copy)]
pub(super) struct Column<'a> {
    pub(super) rows: &'a Rows<'a>,
    pub(super) name: &'static str,
}

impl Column<'_> {
    /// Calls `visit` with every cell that is not empty.
    pub(super) fn visit(&self, visit: &mut dyn FnMut(Sample)) {
        let mut cursor = self.rows.clone().cursor();
        let mut first = 0;
        while let Some(block) = cursor.next_block() {
            for (i, t_s) in block.t_s.iter().enumerate() {
                let value = block.number_named(self.name, i);
                if value.is_finite() {
                    let (row, t_s) = (first + i, *t_s);
                    visit(Sample { row, t_s, value });
                }
            }
            first += block.t_s.len();
        }
    }

    /// Calls `visit` with every cell that is not empty and not in one of these rows (ascending).
    pub(super) fn visit_but(&self, left_out: &[usize], visit: &mut dyn FnMut(Sample)) {
        let mut left_out = left_out.iter().peekable();
        self.visit(&mut |sample| {
            while left_out.next_if(|row| **row < sample.row).is_some() {}
            if left_out.peek() != Some(&&sample.row) {
                visit(sample);
            }
        });
    }
}
