//! Sizes that nobody would call an effect, prior costs, and where searches begin.

/// What the stamp of a row means within a sampling interval is a convention: this share of it.
pub(super) const STAMP_SHARE: f64 = 0.1;
/// A turn rate that jumps is integrated late or early by up to this share of the gyro's interval.
pub(super) const GYRO_STEP_SHARE: f64 = 0.5;
/// Integrators of two simulators differ by this much in factors and angles, and in lengths by this share of
/// the half track.
pub(super) const FACTOR: f64 = 1e-4;
pub(super) const LENGTH_SHARE: f64 = 1e-3;
/// The same of times (s), of shares of the largest command, of sag (1/s) and of rates of clocks.
pub(super) const TIME_S: f64 = 2e-4;
pub(super) const COMMAND_SHARE: f64 = 2e-4;
pub(super) const SAG_PER_S: f64 = 2e-5;
pub(super) const RATE: f64 = 1e-5;
/// Wheels that differ by less than this cannot be told from errors of the gyro's scale.
pub(super) const GYRO_ASYMMETRY: f64 = 0.004;
/// A robot that turns or drives more slowly than this shows no law (rad/s, m/s).
pub(super) const LEAST_DRIVER: [f64; 2] = [0.02, 5e-3];

/// Repeatability: standard deviation between recordings of one unchanged robot.
pub(super) mod repeatability {
    pub(crate) const SCALE: f64 = 0.006;
    pub(crate) const ASYMMETRY: f64 = 0.003;
    pub(crate) const TRACK: f64 = 0.008;
    /// Of the track.
    pub(crate) const OFFSET: f64 = 0.02;
    pub(crate) const YAW_RAD: f64 = 5e-3;
    pub(crate) const TIME_S: f64 = 5e-3;
    pub(crate) const RATE: f64 = 2e-4;
    /// Of the largest command.
    pub(crate) const COMMAND: f64 = 0.01;
    pub(crate) const SAG_PER_S: f64 = 2e-4;
}

/// Latencies of logs wander more slowly than blocks of time show, rates of clocks still more slowly: their
/// standard errors are inflated by this.
pub(super) const LATENCY_INFLATION: f64 = 1.3;
pub(super) const RATE_INFLATION: f64 = 1.75;
/// A recording from which on a clock that drifts by 1e-3 is off by more than drives respond otherwise up than down (s).
pub(super) const LEAST_DRIFT_S: f64 = 60.0;
/// Prior log-odds (nats) against encoders that count wrong, beside a motor or a wheel that is off; against a
/// stream that is stamped before it was measured; against a clock that runs fast, which crystals do by less
/// than 1e-4.
pub(super) const COUNT_COST: f64 = 3.0;
pub(super) const RATE_COST: f64 = 3.0;
/// The same against a saturation, beside a gain: robots are rarely commanded more than they can do.
pub(super) const SATURATION_COST: f64 = 2.0;
/// The same against late wheels, beside commands that act late.
pub(super) const WHEELS_COST: f64 = 2.0;
/// The same against speed lost in turns and a track that is larger to one side, which few robots have so that it shows.
pub(super) const TURN_COST: f64 = 3.0;
/// The same against a law that the catalogue does not have, beside any effect that it has.
pub(super) const LAW_COST: f64 = 10.0;

/// How far wheels and tracks mostly are from their data sheets, as a logarithm: tyres are pressed and worn by some
/// per cent. Wheels of one robot differ by less (Borenstein and Feng 1996).
pub(super) const SIZE: f64 = 0.03;
pub(super) const PAIR: f64 = 0.01;

/// The same of motors' speeds without a load, which are sold to a tenth.
pub(super) const MOTOR: f64 = 0.05;

/// What most robots have somewhat of.
pub(super) const USUAL: [&str; 7] = [
    "geometry",
    "track",
    "gain",
    "delay",
    "friction",
    "late pose",
    "late gyro",
];

/// Latencies and delays from which a search begins (s).
pub(super) const LATENCIES_S: [f64; 14] = [
    -0.5, -0.3, -0.2, -0.15, -0.1, -0.05, 0.02, 0.05, 0.1, 0.15, 0.2, 0.3, 0.4, 0.6,
];
pub(super) const LAGS_S: [f64; 4] = [0.02, 0.06, 0.15, 0.4];
/// Changes of what motors move, as shares of the time constant by the masses, and pulls of slopes, as shares of the
/// largest command, from which it begins.
pub(super) const LOADS: [f64; 3] = [-0.9, -0.4, 1.0];
pub(super) const PULLS: [f64; 4] = [-0.25, -0.08, 0.08, 0.25];
/// Saturations and dead zones from which it begins, as shares of the largest command.
pub(super) const SATURATIONS: [f64; 7] = [0.98, 0.93, 0.87, 0.8, 0.72, 0.63, 0.53];
pub(super) const DEAD_ZONES: [f64; 3] = [0.02, 0.08, 0.2];
/// Share and log of the time of a slow response from which it begins.
pub(super) const SLOW: [f64; 2] = [0.05, 0.0];
/// Mountings from which it begins (rad).
pub(super) const MOUNTINGS_RAD: [f64; 3] = [-1.57, 1.57, 3.1];
