//! Laws: a quantity as a table over one driver, listed by knots and values.

use super::{Motion, Values};
use crate::parts::scalar::Scalar;
use crate::parts::table::Table;

/// Variables over which a law can be a table. Of the drivers of an unknown effect, those that are one
/// number at every instant; there are two wheel angles and torques, and a position has two coordinates.
pub(super) const DRIVERS: &[&str] = &["t", "v", "w", "heading", "x", "y"];

/// A law: which quantity, over which driver, and its table.
#[derive(Debug, Clone)]
pub(super) struct Law<S> {
    /// The quantity.
    pub(super) acts_on: &'static str,
    driver: &'static str,
    table: Table<S>,
}

impl<S: Scalar> Law<S> {
    pub(super) fn new(values: &Values<S>) -> Self {
        Self {
            acts_on: values.text("acts_on"),
            driver: values.text("driver"),
            table: Table::new(values.list("knots"), values.list("values")),
        }
    }

    /// The quantity in this motion, at the middle of the time over which it is averaged.
    pub(super) fn at(&self, motion: &Motion<S>) -> S {
        let [x, y, heading] = motion.pose;
        self.table.at(match self.driver {
            "t" => S::constant(motion.t_s + motion.over_s / 2.0),
            "w" => motion.yaw_rate,
            "heading" => first_turn(heading),
            "x" => x,
            "y" => y,
            _ => motion.velocity[0],
        })
    }
}

/// The angle less whole turns, from -pi to pi.
fn first_turn<S: Scalar>(angle: S) -> S {
    use std::f64::consts::TAU;
    angle - (angle.value() / TAU).round() * TAU
}
