//! What the figures of a report show, as plain numbers: residuals, missing forces, paths, and what was
//! ruled out down to which size.

/// A point of a figure: what stands on the axis across, what on the axis up.
pub type Point = (f64, f64);

/// What the figures of one machine show. A point that is not finite is a gap.
#[derive(Debug, Clone)]
pub struct Figures {
    /// The machine.
    pub robot: String,
    /// Begin and end of each of its recordings (s).
    pub spans_s: Vec<[f64; 2]>,
    /// Simulated minus measured, one for each channel of each recording.
    pub residuals: Vec<Residuals>,
    /// The force that the models miss; none for robots that are driven by speeds.
    pub forces: Vec<MissingForce>,
    /// The same against the variable that tells most of each finding.
    pub against: Vec<Against>,
    /// Where the camera saw each run, and where the models predict it.
    pub paths: Vec<Paths>,
    /// From which size on each effect that was not found would have been seen.
    pub limits: Vec<Limit>,
}

/// Residuals of one channel in the windows of the fit: time (s), standard deviations of the sensor.
#[derive(Debug, Clone)]
pub struct Residuals {
    /// Number of the recording, from 0.
    pub run: usize,
    /// As in `held_out`.
    pub channel: &'static str,
    /// Of the nominal model.
    pub before: Vec<Point>,
    /// Of the model with what was found; empty where nothing was found.
    pub after: Vec<Point>,
}

/// A force that a model misses over time (s), estimated every 50 ms without an idea of its cause,
/// and its mean over a quarter of a second without the extremes.
#[derive(Debug, Clone)]
pub struct MissingForce {
    /// Number of the recording, from 0.
    pub run: usize,
    /// What it is, with its unit.
    pub quantity: String,
    /// Of the nominal model.
    pub before: Vec<Point>,
    /// Of the model with what was found; empty where nothing was found.
    pub after: Vec<Point>,
}

/// Paths on the floor (m) in pieces of 5 s: the start of each is fitted to its first half second,
/// the rest is simulated from the commands alone.
#[derive(Debug, Clone)]
pub struct Paths {
    /// Number of the recording, from 0.
    pub run: usize,
    /// Where the camera saw the tracked point.
    pub camera: Vec<Point>,
    /// Where the nominal model has it.
    pub before: Vec<Point>,
    /// Where the model with what was found has it; empty where nothing was found.
    pub after: Vec<Point>,
}

/// A missing force against a variable.
#[derive(Debug, Clone)]
pub struct Against {
    /// The finding's effect.
    pub effect: String,
    /// The force, with its unit.
    pub quantity: String,
    /// The variable, with its unit.
    pub variable: String,
    /// Every moment, without the finding.
    pub before: Vec<Point>,
    /// Every moment with what was found; empty for `unknown` and for what is measured.
    pub after: Vec<Point>,
    /// Of an effect outside of the catalogue: the force that was found.
    pub curve: Vec<Point>,
    /// The curve is a function of the variable, not of more.
    pub is_function: bool,
}

/// How large an effect that was not found can be at most.
#[derive(Debug, Clone, PartialEq)]
pub struct Limit {
    /// The effect's identity.
    pub effect: &'static str,
    /// Of an effect with a word among its parameters, such as a stream: the word.
    pub word: Option<&'static str>,
    /// The parameter, and its unit.
    pub parameter: &'static str,
    /// Unit of the parameter.
    pub unit: &'static str,
    /// In which direction it would have been seen.
    pub seen: Seen,
    /// The size; `None` where this recording does not show the effect at any size.
    pub size: Option<f64>,
    /// The smallest size at which the catalogue expects the effect.
    pub usual: f64,
}

/// In which direction from a size an effect would have been seen.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Seen {
    /// Above the size.
    Above,
    /// Below the size.
    Below,
    /// Further than the size from this value.
    Around(f64),
}
