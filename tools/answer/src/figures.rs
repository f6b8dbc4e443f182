//! What the figures of a report show, as plain numbers: errors over time, paths, missing forces, how the
//! error depends on an assumed size, and what was ruled out down to which size.

/// A point of a figure: what stands on the axis across, what on the axis up.
pub type Point = (f64, f64);

/// What the figures of one machine show. A point that is not finite is a gap.
#[derive(Debug, Clone, Default)]
pub struct Figures {
    /// The machine.
    pub robot: String,
    /// The recording and the robot of each run.
    pub runs: Vec<String>,
    /// Begin and end of each of its recordings (s).
    pub spans_s: Vec<[f64; 2]>,
    /// How it drove.
    pub motion: Vec<Motion>,
    /// Predicted minus measured, one for each quantity of each recording.
    pub errors: Vec<ErrorLine>,
    /// The force that the models miss; none for robots that are driven by speeds.
    pub forces: Vec<MissingForce>,
    /// Where each run was seen, and where the models predict it.
    pub paths: Vec<Paths>,
    /// How the error depends on the size of each finding.
    pub profiles: Vec<Profile>,
    /// Laws that no effect of the catalogue is.
    pub laws: Vec<LawCurve>,
    /// From which size on each effect that was not found would have been seen.
    pub limits: Vec<Limit>,
}

/// Speed (m/s) and turn rate (rad/s) of one run over time (s), as its wheels or commands say.
#[derive(Debug, Clone)]
pub struct Motion {
    /// Number of the recording, from 0.
    pub run: usize,
    /// Speed.
    pub speed_m_s: Vec<Point>,
    /// Turn rate.
    pub turn_rad_s: Vec<Point>,
}

/// Predicted minus measured of one quantity over time (s), in windows of 5 s whose start is fitted to
/// their first half second; a gap after each window.
#[derive(Debug, Clone)]
pub struct ErrorLine {
    /// Number of the recording, from 0.
    pub run: usize,
    /// `forward` and `sideways`, as seen from the robot, `heading`, or a channel as in `held_out`.
    pub quantity: &'static str,
    /// `m`, `rad`, `m/s`, `rad/s` or `m/s²`.
    pub unit: &'static str,
    /// Standard deviation of the sensor, in that unit.
    pub deviation: f64,
    /// Of the nominal model.
    pub before: Vec<Point>,
    /// Of the model with what was found; empty where nothing was found.
    pub after: Vec<Point>,
}

/// A force that a model misses over time (s), as the filter estimates it.
#[derive(Debug, Clone)]
pub struct MissingForce {
    /// Number of the recording, from 0.
    pub run: usize,
    /// What it is.
    pub quantity: &'static str,
    /// Its unit.
    pub unit: &'static str,
    /// Of the nominal model.
    pub before: Vec<Point>,
    /// Of the model with what was found; empty where nothing was found.
    pub after: Vec<Point>,
}

/// Paths on the floor (m): the start is fitted to the first half second, the rest is predicted.
#[derive(Debug, Clone)]
pub struct Paths {
    /// Number of the recording, from 0.
    pub run: usize,
    /// Begin and end (s).
    pub span_s: [f64; 2],
    /// Whether it is predicted in pieces of 5 s, a gap after each; else in one.
    pub in_pieces: bool,
    /// Whether the wheels drive it; else the commands.
    pub by_wheels: bool,
    /// Where the tracked point was seen.
    pub seen: Vec<Point>,
    /// Where the nominal model has it.
    pub before: Vec<Point>,
    /// Where the model with what was found has it; empty where nothing was found.
    pub after: Vec<Point>,
}

/// How much worse the recordings fit against the assumed size of one parameter, everything else as found, by what the
/// fit made smallest: its lowest point lies at the estimate.
#[derive(Debug, Clone)]
pub struct Profile {
    /// Number of the finding in the answer.
    pub finding: usize,
    /// Name of the parameter.
    pub parameter: &'static str,
    /// Parameter, and standard deviations from the best fit: √(2 (ln L_best − ln L)).
    pub points: Vec<Point>,
}

impl Profile {
    /// The curve through sizes and their log-likelihoods (nats); none where no size has one.
    pub fn new(
        finding: usize,
        parameter: &'static str,
        likelihoods: impl IntoIterator<Item = Point>,
    ) -> Option<Self> {
        let likelihoods = likelihoods.into_iter();
        let known: Vec<Point> = likelihoods.filter(|(_, own)| own.is_finite()).collect();
        let best = known.iter().map(|own| own.1).reduce(f64::max)?;
        let points = known.into_iter();
        let points = points.map(|(size, own)| (size, (2.0 * (best - own)).sqrt()));
        Some(Self {
            finding,
            parameter,
            points: points.collect(),
        })
    }
}

/// A law that no effect of the catalogue is: a function of one variable with its 95 % band.
#[derive(Debug, Clone)]
pub struct LawCurve {
    /// Number of the finding in the answer.
    pub finding: usize,
    /// What it acts on, and the unit.
    pub quantity: &'static str,
    /// Its unit.
    pub unit: &'static str,
    /// What it depends on.
    pub driver: &'static str,
    /// The function.
    pub curve: Vec<Point>,
    /// Ends of its 95 % band, at the same places; empty where it is not known.
    pub band: [Vec<Point>; 2],
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
    /// Error of a prediction over 5 s that an effect of this size causes: root mean square of place (m)
    /// and heading (rad).
    pub error: [Option<f64>; 2],
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
