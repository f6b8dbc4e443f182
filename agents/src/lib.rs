//! One robot's controller.
