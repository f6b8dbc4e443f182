//! Quadratic drag: a force in proportion to the square of speed.

use super::parameter::size;
use super::{Effect, Info, Motion, Wrench, numbers};
use crate::parts::scalar::{Scalar, length};

numbers!(QuadraticDrag { coefficient });

impl<S: Scalar> Effect<S> for QuadraticDrag<S> {
    const INFO: Info = Info::drag(
        "quadratic_drag",
        "drag in proportion to the square of the velocity of c",
    )
    .equation("F = -c |v| v")
    .source("Rayleigh's drag equation")
    .parameters(&[size(
        "coefficient",
        "N s^2/m^2",
        [0.0, 100.0],
        &[0.1, 0.5, 2.0],
    )]);

    fn force(&self, motion: &Motion<S>, wrench: &mut Wrench<S>) {
        let factor = self.coefficient * length(motion.velocity);
        wrench.along -= factor * motion.velocity[0];
        wrench.across -= factor * motion.velocity[1];
    }

    fn has_force(&self) -> bool {
        true
    }
}
