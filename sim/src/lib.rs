//! The world: plant, effects and sensors.
