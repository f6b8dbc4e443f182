//! The wheels' rows as they would be without their faults.

use super::scale::fold;
use super::wheels::{Fault, WheelFaults};
use crate::table::Table;

/// Takes the rows of the wheels one after the other and returns them mended.
#[derive(Debug)]
pub(crate) struct MendedWheels<'a> {
    faults: &'a WheelFaults,
    row: usize,
    sides: [WheelKnown; 2],
}

/// What is known of one wheel so far.
#[derive(Debug, Default)]
struct WheelKnown {
    last: Option<f64>,
    /// What is added to the values from here on.
    offset: f64,
    next_glitch: usize,
    next_jump: usize,
}

impl<'a> MendedWheels<'a> {
    /// Before the first row.
    pub(crate) fn new(faults: &'a WheelFaults) -> Self {
        Self {
            faults,
            row: 0,
            sides: Default::default(),
        }
    }

    /// The next row's values, right and left (NaN for an empty cell); `None` for a row that is left out.
    pub(crate) fn next(&mut self, values: [f64; 2]) -> Option<[f64; 2]> {
        let row = self.row;
        self.row += 1;
        let [right, left] = &self.faults.faults;
        let [of_right, of_left] = &mut self.sides;
        let is_glitch = [
            of_right.passes_glitch(right, row),
            of_left.passes_glitch(left, row),
        ];
        if is_glitch.contains(&true) {
            // the jump of a wheel may begin at the row that the other one loses
            return None;
        }
        Some([
            of_right.next(right, row, values[0]),
            of_left.next(left, row, values[1]),
        ])
    }

    /// The rows of a block: times (s), and both wheels.
    pub(crate) fn block(&mut self, block: &Table) -> (Vec<f64>, [Vec<f64>; 2]) {
        let (mut times, mut sides) = (Vec::new(), [Vec::new(), Vec::new()]);
        let [right, left] = self.faults.names;
        for (i, t_s) in block.t_s.iter().enumerate() {
            let cells = [right, left].map(|name| block.number_named(name, i));
            if let Some(values) = self.next(cells) {
                times.push(*t_s);
                sides
                    .iter_mut()
                    .zip(values)
                    .for_each(|(side, v)| side.push(v));
            }
        }
        (times, sides)
    }
}

impl WheelKnown {
    fn passes_glitch(&mut self, fault: &Fault, row: usize) -> bool {
        let next = fault.glitches.get(self.next_glitch);
        let is_glitch = next.is_some_and(|(at, _)| *at == row);
        self.next_glitch += usize::from(is_glitch);
        is_glitch
    }

    fn next(&mut self, fault: &Fault, row: usize, value: f64) -> f64 {
        if value.is_nan() {
            return value;
        }
        let step = self.last.replace(value).map_or(0.0, |last| value - last);
        let folded = fold(step, fault.modulus);
        self.offset += folded - step;
        while let Some(jump) = fault.jumps.get(self.next_jump).filter(|j| j.row <= row) {
            self.offset += jump.expected - jump.step;
            self.next_jump += 1;
        }
        value + self.offset
    }
}
