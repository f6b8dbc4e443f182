//! The table of parameters: of everything that a machine that is commanded speeds may have, what it moves,
//! how large it plausibly is, below which size it is none, and what it is reported as.

use super::drive::{
    AVERAGED, CLOCK, DEAD_BAND, DEAD_ZONE, DELAY, DRIVE, GAIN, GAIN_ASYMMETRY, LAG, SAG,
    SATURATION, SLOW_SHARE, SLOW_TIME,
};
use super::from_wheels::{
    ASYMMETRY, COMMON, DRIVE_FIRST, GYRO_LATENCY, GYRO_RATE, LAW_FIRST, OFFSET_X, OFFSET_Y,
    OFFSET_YAW, POSE_LATENCY, POSE_RATE, RUN_BIAS, RUN_LATE, RUN_NOISE_FIRST, RUN_RATE, RUN_SCALE,
    RUN_TRACK, TRACK,
};
use super::run::{Run, is_process};
use super::streams::Streams;
use crate::data::streams::WheelKind;
use crate::estimate::term::{Acts, Attribution, Link, Search, Term, Value};
use crate::estimate::{Prior, pairs};
use crate::filter::motion_law::VALUES;

/// What the stamp of a row means within a sampling interval is a convention: this share of it.
const STAMP_SHARE: f64 = 0.1;
/// A turn rate that jumps is integrated late or early by up to this share of the gyro's interval.
const GYRO_STEP_SHARE: f64 = 0.5;
/// Integrators of two simulators differ by this much in factors and angles, and in lengths by this share of
/// the half track.
const FACTOR: f64 = 1e-4;
const LENGTH_SHARE: f64 = 1e-3;
/// The same of times (s), of shares of the largest command, of sag (1/s) and of rates of clocks.
const TIME_S: f64 = 2e-4;
const COMMAND_SHARE: f64 = 2e-4;
const SAG_PER_S: f64 = 2e-5;
const RATE: f64 = 1e-5;
/// Wheels that differ by less than this cannot be told from errors of the gyro's scale.
const GYRO_ASYMMETRY: f64 = 0.004;
/// A robot that turns or drives more slowly than this shows no law (rad/s, m/s).
const LEAST_DRIVER: [f64; 2] = [0.02, 5e-3];

/// Repeatability: standard deviation between recordings of one unchanged robot.
mod repeatability {
    pub(super) const SCALE: f64 = 0.006;
    pub(super) const ASYMMETRY: f64 = 0.003;
    pub(super) const TRACK: f64 = 0.008;
    /// Of the track.
    pub(super) const OFFSET: f64 = 0.02;
    pub(super) const YAW_RAD: f64 = 5e-3;
    pub(super) const TIME_S: f64 = 5e-3;
    pub(super) const RATE: f64 = 2e-4;
    /// Of the largest command.
    pub(super) const COMMAND: f64 = 0.01;
    pub(super) const SAG_PER_S: f64 = 2e-4;
}

/// Latencies of logs wander more slowly than blocks of time show, rates of clocks still more slowly: their
/// standard errors are inflated by this.
const LATENCY_INFLATION: f64 = 1.3;
const RATE_INFLATION: f64 = 1.75;
/// Prior log-odds (nats) against encoders that count wrong, beside a motor or a wheel that is off; against a
/// stream that is stamped before it was measured; against a clock that runs fast, which crystals do by less
/// than 1e-4.
const COUNT_COST: f64 = 3.0;
const RATE_COST: f64 = 3.0;
/// The same against a saturation, beside a gain: robots are rarely commanded more than they can do.
const SATURATION_COST: f64 = 2.0;
/// The same against late wheels, beside commands that act late.
const WHEELS_COST: f64 = 2.0;
/// The same against a law that the catalogue does not have, beside any effect that it has.
const LAW_COST: f64 = 10.0;

/// What most robots have somewhat of.
const USUAL: [&str; 6] = [
    "geometry",
    "track",
    "gain",
    "delay",
    "late pose",
    "late gyro",
];

/// Latencies and delays from which a search begins (s).
const LATENCIES_S: [f64; 14] = [
    -0.5, -0.3, -0.2, -0.15, -0.1, -0.05, 0.02, 0.05, 0.1, 0.15, 0.2, 0.3, 0.4, 0.6,
];
const LAGS_S: [f64; 4] = [0.02, 0.06, 0.15, 0.4];
/// Saturations and dead zones from which it begins, as shares of the largest command.
const SATURATIONS: [f64; 7] = [0.98, 0.93, 0.87, 0.8, 0.72, 0.63, 0.53];
const DEAD_ZONES: [f64; 3] = [0.02, 0.08, 0.2];
/// Share and log of the time of a slow response from which it begins.
const SLOW: [f64; 2] = [0.05, 0.0];
/// Mountings from which it begins (rad).
const MOUNTINGS_RAD: [f64; 3] = [-1.57, 1.57, 3.1];

/// Which parameter it is: the same in the table of all runs and in that of today's.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Key {
    pub(crate) name: &'static str,
    /// Number of the robot counted from the first of today's: negative of runs from before.
    pub(crate) robot: Option<i64>,
    pub(crate) number: usize,
    /// Of runs from before and of today alike, where these are compared.
    pub(crate) is_shared: bool,
}

/// The parameters of one machine, and its terms.
#[derive(Debug, Default)]
pub(crate) struct Table {
    /// How each parameter moves what the filters read.
    pub(crate) weights: Vec<Vec<(usize, f64)>>,
    pub(crate) priors: Vec<Prior>,
    /// Longest step of each in one iteration of a fit.
    pub(crate) longest: Vec<f64>,
    pub(crate) keys: Vec<Key>,
    pub(crate) terms: Vec<Term>,
    /// Parameters that are always free and no noise sizes.
    pub(crate) always: Vec<usize>,
    pub(crate) noise: Vec<usize>,
    /// The filters that each parameter moves, a bit for each: of the reference, of the drive.
    pub(crate) parts: Vec<u8>,
    /// Of a change, what runs from before have of the same parameter.
    pub(crate) twins: Vec<Option<usize>>,
    resolution: Vec<f64>,
    repeatability: Vec<f64>,
}

/// Which filter reads a parameter.
#[derive(Clone, Copy)]
enum Place {
    Reference(usize),
    Drive(usize),
}
use Place::{Drive, Reference};

/// One parameter of the machine.
struct Row {
    name: &'static str,
    number: usize,
    moves: Vec<(Place, f64)>,
    prior: Prior,
    resolution: f64,
    repeatability: f64,
}

/// What is asked of a table.
pub(crate) struct Asked<'a> {
    pub(crate) streams: Streams<'a>,
    /// What the filters read under the nominal model.
    pub(crate) nominal: &'a [f64],
    /// Effects that are not looked for.
    pub(crate) excluded: &'a [String],
    /// Whether scale and track are those of each run.
    pub(crate) by_run: [bool; 2],
}

fn about(deviation: f64) -> Prior {
    Prior {
        mean: 0.0,
        deviation,
    }
}

impl Table {
    pub(crate) fn new(asked: &Asked<'_>) -> Self {
        let mut table = Self::default();
        let known = Known::new(asked);
        for term in known.terms() {
            table.add(asked, &known, term);
        }
        table.add_runs(asked);
        table.add_noise(asked);
        let first = asked.streams.drive_first();
        let part = |(index, _): &(usize, f64)| if *index < first { 1 } else { 2 };
        let of = |weights: &Vec<(usize, f64)>| weights.iter().fold(0, |all, own| all | part(own));
        table.parts = table.weights.iter().map(of).collect();
        table
    }

    pub(crate) fn parameters(&self) -> usize {
        self.weights.len()
    }

    pub(crate) fn find(&self, key: &Key) -> Option<usize> {
        self.keys.iter().position(|own| own == key)
    }

    fn push(&mut self, key: Key, weights: Vec<(usize, f64)>, prior: Prior, longest: f64) -> usize {
        self.keys.push(key);
        self.weights.push(weights);
        self.priors.push(prior);
        self.longest.push(longest);
        self.twins.push(None);
        self.resolution.push(0.0);
        self.repeatability.push(0.0);
        self.keys.len() - 1
    }

    /// The parameter of a row, or what runs from before share with those of today of it.
    fn row(&mut self, asked: &Asked<'_>, row: &Row, is_shared: bool) -> usize {
        let key = Key {
            name: row.name,
            robot: None,
            number: row.number,
            is_shared,
        };
        if let Some(known) = self.find(&key) {
            return known;
        }
        let streams = &asked.streams;
        let first = streams.drive_first();
        let index = |place: &Place| match (*place, streams.drive) {
            (Drive(own), Some(_)) if is_shared => {
                first + super::command_to_wheels::CommandToWheels::shared(own)
            }
            (Drive(own), Some(_)) => first + own,
            (Drive(own), None) if is_shared => streams.reference.shared(DRIVE_FIRST + own),
            (Drive(own), None) => DRIVE_FIRST + own,
            (Reference(own), _) if is_shared => streams.reference.shared(own),
            (Reference(own), _) => own,
        };
        // a part without runs from before has nothing to share with them
        let has = |place: &Place| {
            let before = match (place, streams.drive) {
                (Drive(_), Some(drive)) => &drive.before,
                _ => &streams.reference.before,
            };
            !is_shared || before.any()
        };
        let moves = row.moves.iter().filter(|(place, _)| has(place));
        let weights = moves
            .map(|(place, weight)| (index(place), *weight))
            .collect();
        let prior = if is_shared {
            about(row.prior.deviation)
        } else {
            row.prior
        };
        let at = self.push(key, weights, prior, row.prior.deviation / 2.0);
        self.resolution[at] = row.resolution * row.resolution;
        self.repeatability[at] = row.repeatability * row.repeatability;
        at
    }

    fn add(&mut self, asked: &Asked<'_>, known: &Known<'_>, draft: Draft) {
        let allowed = |effect: &&str| !asked.excluded.iter().any(|own| own == effect);
        let is_law = draft.name.starts_with("law");
        if is_law && !allowed(&"motion_law") || draft.rows.is_empty() {
            return;
        }
        let mut term = Term {
            name: draft.name,
            parameters: Vec::new(),
            resolution: Vec::new(),
            repeatability: Vec::new(),
            inflation: draft.inflation,
            cost: draft.cost,
            search: draft.search,
            usual: USUAL.contains(&draft.name),
            positive: draft.positive,
            lasting: draft.lasting,
            acts: acts(&draft.rows),
            shown: Vec::new(),
        };
        let compares = asked.streams.compares();
        for row in &draft.rows {
            let at = match row {
                Drafted::Machine(row) => {
                    let at = self.row(asked, row, false);
                    if compares {
                        let twin = self.row(asked, row, true);
                        self.twins[at] = Some(twin);
                        if known.had(asked, row, draft.later) && !self.always.contains(&twin) {
                            self.always.push(twin);
                        }
                    }
                    at
                }
                Drafted::Run {
                    name,
                    run,
                    place,
                    deviation,
                } => self.of_run(asked, name, *run, *place, *deviation),
            };
            term.parameters.push(at);
        }
        term.resolution = term
            .parameters
            .iter()
            .map(|i| self.resolution[*i])
            .collect();
        term.repeatability = term.parameters.iter().map(|_| 0.0).collect();
        if compares {
            let own = term.parameters.iter().map(|i| self.repeatability[*i]);
            term.repeatability = own.collect();
        }
        let nuisance = draft.shown.is_empty();
        for shown in draft.shown {
            if allowed(&shown.effect) {
                term.shown.push(shown.attribution(&term.parameters));
            }
        }
        // what a machine is compared with has its nuisances already
        if nuisance && !compares || !term.shown.is_empty() {
            self.terms.push(term);
        }
    }

    fn of_run(
        &mut self,
        asked: &Asked<'_>,
        name: &'static str,
        run: usize,
        parameter: usize,
        deviation: f64,
    ) -> usize {
        let reference = asked.streams.reference;
        let key = Key {
            name,
            robot: Some(robot(reference.runs[run].robot, reference.before.robots)),
            number: 0,
            is_shared: false,
        };
        let index = reference.of_run(run, parameter);
        if let Some(known) = self.find(&key) {
            return known;
        }
        let at = self.push(
            key,
            vec![(index, 1.0)],
            about(deviation),
            deviation.min(0.3) / 1.5,
        );
        self.resolution[at] = FACTOR * FACTOR;
        let place = usize::from(parameter == RUN_TRACK);
        let spread = reference.before.spread[place].unwrap_or(0.0);
        let own = [repeatability::SCALE, repeatability::TRACK][place].hypot(spread);
        self.repeatability[at] = own * own;
        at
    }

    /// Biases and clocks of single runs, which belong to sensors; scales and tracks of runs from before.
    fn add_runs(&mut self, asked: &Asked<'_>) {
        let reference = asked.streams.reference;
        let clocks = reference.has_clocks_of_runs();
        for (i, run) in reference
            .runs
            .iter()
            .enumerate()
            .filter(|(_, run)| run.gyro.is_some())
        {
            let mut own = vec![("gyro bias", RUN_BIAS, 0.02)];
            if clocks && reference.as_before(i).is_none() {
                own.extend([("run late", RUN_LATE, 0.3), ("run rate", RUN_RATE, 0.003)]);
            }
            for (name, parameter, deviation) in own {
                let key = Key {
                    name,
                    robot: Some(robot(run.robot, reference.before.robots)),
                    number: 0,
                    is_shared: false,
                };
                let index = vec![(reference.of_run(i, parameter), 1.0)];
                let at = self.push(key, index, about(deviation), deviation / 2.0);
                self.always.push(at);
            }
        }
        let spread = reference.before.spread;
        let own = [("run scale", RUN_SCALE), ("run track", RUN_TRACK)];
        for ((name, parameter), spread) in own.into_iter().zip(spread) {
            let Some(spread) = spread else { continue };
            for run in 0..reference.before.runs {
                let at = self.of_run(asked, name, run, parameter, spread);
                self.always.push(at);
            }
        }
    }

    /// Noise sizes: the sensors' of all runs together, beside first guesses of each run; what moves the pose of
    /// each run by itself, for floors differ.
    fn add_noise(&mut self, asked: &Asked<'_>) {
        let reference = asked.streams.reference;
        let shared = reference.shared(0);
        let (of_runs, shares): (Vec<usize>, Vec<usize>) = reference
            .noise()
            .into_iter()
            .partition(|index| *index < shared);
        let width = reference.of_run(1, 0) - reference.of_run(0, 0);
        let place = |index: usize| {
            let beyond = index - reference.of_run(0, 0);
            (beyond / width, beyond % width)
        };
        let mut numbers: Vec<usize> = of_runs.iter().map(|index| place(*index).1).collect();
        numbers.sort_unstable();
        numbers.dedup();
        let key = |name, robot, number| Key {
            name,
            robot,
            number,
            is_shared: false,
        };
        for number in &numbers {
            let own = of_runs.iter().filter(|index| place(**index).1 == *number);
            let weights = own.map(|index| (*index, 1.0)).collect();
            self.noise_of(key("noise", None, *number), weights, false, 2.0);
        }
        if reference.runs.len() > 1 {
            for (run, own) in reference.runs.iter().enumerate() {
                let of = robot(own.robot, reference.before.robots);
                let process = of_runs.iter().filter(|index| {
                    let (of, number) = place(**index);
                    of == run && is_process(number - RUN_NOISE_FIRST)
                });
                let weights = process.map(|index| (*index, 1.0)).collect();
                self.noise_of(key("noise of a run", Some(of), 0), weights, false, 1.0);
            }
        }
        for index in shares {
            let own = key("share", None, index - shared);
            self.noise_of(own, vec![(index, 1.0)], true, 2.0);
        }
        let first = asked.streams.drive_first();
        for index in asked.streams.drive.iter().flat_map(|drive| drive.noise()) {
            let is_share = index == super::command_to_wheels::CommandToWheels::SHARE;
            let number = index - DRIVE;
            let key = Key {
                name: if is_share {
                    "share of the drive"
                } else {
                    "noise of the drive"
                },
                robot: None,
                number,
                is_shared: false,
            };
            // the time of a disturbance is known to lie between some tenths of a second and some seconds
            let deviation = if [1, 4].contains(&number) { 1.0 } else { 2.0 };
            self.noise_of(key, vec![(first + index, 1.0)], is_share, deviation);
        }
    }

    fn noise_of(&mut self, key: Key, weights: Vec<(usize, f64)>, is_share: bool, deviation: f64) {
        let (deviation, longest) = if is_share {
            (pairs::DEVIATION, pairs::LONGEST)
        } else {
            (deviation, 1.0)
        };
        let at = self.push(key, weights, about(deviation), longest);
        self.noise.push(at);
    }
}

fn robot(robot: usize, before: usize) -> i64 {
    robot as i64 - before as i64
}

/// What rows act on.
fn acts(rows: &[Drafted]) -> Acts {
    let mut acts = Acts::default();
    for row in rows {
        match row {
            Drafted::Run { .. } => acts.on_reference = true,
            Drafted::Machine(row) => {
                for (place, _) in &row.moves {
                    match place {
                        Reference(_) => acts.on_reference = true,
                        Drive(_) => acts.on_drive = true,
                    }
                }
            }
        }
    }
    acts
}

/// A parameter of a term.
enum Drafted {
    Machine(Row),
    Run {
        name: &'static str,
        run: usize,
        place: usize,
        deviation: f64,
    },
}

/// What a term is reported as: weights are by place among its parameters.
struct Shown {
    effect: &'static str,
    word: Option<(&'static str, &'static str)>,
    run: Option<usize>,
    values: Vec<(&'static str, Link, Vec<(usize, f64)>)>,
    confused: Vec<&'static str>,
    mirror: Option<(&'static str, f64)>,
}

impl Shown {
    fn new(effect: &'static str, values: Vec<(&'static str, Link, Vec<(usize, f64)>)>) -> Self {
        Self {
            effect,
            word: None,
            run: None,
            values,
            confused: Vec::new(),
            mirror: None,
        }
    }

    /// A single number, the first parameter of its term.
    fn plain(effect: &'static str, name: &'static str) -> Self {
        Self::new(effect, vec![(name, Link::Identity, vec![(0, 1.0)])])
    }

    /// Factors of both wheels, from what they share and right over left.
    fn wheels(effect: &'static str, names: [&'static str; 2]) -> Self {
        let [right, left] = names;
        Self::new(
            effect,
            vec![
                (right, Link::Log, vec![(0, 1.0), (1, 0.5)]),
                (left, Link::Log, vec![(0, 1.0), (1, -0.5)]),
            ],
        )
    }

    fn attribution(self, parameters: &[usize]) -> Attribution {
        let mut own: Vec<usize> = Vec::new();
        let values = self.values.into_iter().map(|(name, link, weights)| {
            let weights: Vec<(usize, f64)> = weights
                .into_iter()
                .map(|(i, w)| (parameters[i], w))
                .collect();
            own.extend(weights.iter().map(|(index, _)| *index));
            Value {
                name,
                link,
                weights,
            }
        });
        let values: Vec<Value> = values.collect();
        if values.is_empty() {
            own.extend(parameters);
        }
        own.sort_unstable();
        own.dedup();
        Attribution {
            effect: self.effect,
            word: self.word,
            run: self.run,
            values,
            parameters: own,
            confused: self.confused,
            mirror: self.mirror,
        }
    }
}

/// A term before its parameters have their numbers.
struct Draft {
    name: &'static str,
    rows: Vec<Drafted>,
    shown: Vec<Shown>,
    inflation: f64,
    cost: f64,
    search: Search,
    positive: bool,
    lasting: bool,
    /// Runs from before share it only where they needed it.
    later: bool,
}

impl Draft {
    fn new(name: &'static str, rows: Vec<Row>, shown: Vec<Shown>) -> Self {
        Self {
            name,
            rows: rows.into_iter().map(Drafted::Machine).collect(),
            shown,
            inflation: 1.0,
            cost: 0.0,
            search: Search::Smooth(Vec::new()),
            positive: false,
            lasting: false,
            later: false,
        }
    }

    fn from(mut self, starts: impl IntoIterator<Item = Vec<f64>>) -> Self {
        self.search = Search::Smooth(starts.into_iter().collect());
        self
    }
}

/// What is known of the streams when their table is made.
struct Known<'a> {
    streams: Streams<'a>,
    asked: &'a Asked<'a>,
    has_pose: bool,
    has_heading: bool,
    has_gyro: bool,
    is_commanded: bool,
    /// Largest command (rad/s); 0 without commands.
    top_rad_s: f64,
    half_track_m: f64,
}

impl<'a> Known<'a> {
    fn new(asked: &'a Asked<'a>) -> Self {
        let streams = asked.streams;
        let reference = streams.reference;
        let is_commanded = reference.is_commanded();
        Self {
            streams,
            asked,
            has_pose: reference.has_pose(),
            has_heading: reference.has_heading(),
            has_gyro: reference.has_gyro(),
            is_commanded,
            top_rad_s: match streams.drive {
                Some(drive) => drive.largest_rad_s,
                None if is_commanded => reference.largest_rad_s(),
                None => 0.0,
            },
            half_track_m: reference.half_track_m,
        }
    }

    fn is_driven(&self) -> bool {
        self.streams.drive.is_some() || self.is_commanded
    }

    fn has_reference(&self) -> bool {
        self.has_pose || self.has_gyro
    }

    /// Largest of an interval over all runs (s).
    fn longest_s(&self, interval_s: fn(&Run) -> f64) -> f64 {
        let runs = self.streams.reference.runs.iter();
        runs.map(interval_s).fold(0.0, f64::max)
    }

    fn duration_s(&self) -> f64 {
        let runs = self.streams.reference.runs.iter();
        let spans = runs.map(|run| run.blocks.span_s[1] - run.blocks.span_s[0]);
        spans.fold(1.0, f64::max)
    }

    /// Whether runs from before are fitted with a parameter whatever changed: what the streams show, and
    /// what the machine had before.
    fn had(&self, asked: &Asked<'_>, row: &Row, later: bool) -> bool {
        let first = self.streams.drive_first();
        let known = row.moves.iter().any(|(place, _)| {
            let index = match (*place, self.streams.drive) {
                (Drive(own), Some(_)) => {
                    first + super::command_to_wheels::CommandToWheels::shared(own)
                }
                (Drive(own), None) => self.streams.reference.shared(DRIVE_FIRST + own),
                (Reference(own), _) => self.streams.reference.shared(own),
            };
            asked.nominal.get(index).is_some_and(|own| *own != 0.0)
        });
        !later || known
    }

    fn terms(&self) -> Vec<Draft> {
        let mut all = Vec::new();
        if self.has_reference() {
            self.geometry(&mut all);
            self.mounting(&mut all);
        }
        self.clocks(&mut all);
        if self.is_driven() {
            self.commands(&mut all);
        }
        self.laws(&mut all);
        all
    }

    fn factors(
        &self,
        name: &'static str,
        moves: [Vec<(Place, f64)>; 2],
        prior: [f64; 2],
    ) -> Vec<Row> {
        let unnoticed = [repeatability::SCALE, repeatability::ASYMMETRY];
        let rows = moves.into_iter().zip(prior).zip(unnoticed).enumerate();
        rows.map(|(number, ((moves, deviation), repeatability))| Row {
            name,
            number,
            moves,
            prior: about(deviation),
            resolution: if number == 1 && !self.has_pose {
                GYRO_ASYMMETRY
            } else {
                FACTOR
            },
            repeatability,
        })
        .collect()
    }

    fn track(&self) -> Row {
        Row {
            name: "track",
            number: 0,
            moves: vec![(Reference(TRACK), 1.0)],
            // steering by skidding, the contact lies anywhere between the wheels and twice beyond
            prior: about(if self.streams.reference.skids {
                0.6
            } else {
                0.2
            }),
            resolution: FACTOR,
            repeatability: repeatability::TRACK,
        }
    }

    fn geometry(&self, all: &mut Vec<Draft>) {
        let crude = self.streams.reference.crude_scale;
        let radii = self.factors(
            "radius",
            [
                vec![(Reference(COMMON), 1.0)],
                vec![(Reference(ASYMMETRY), 1.0)],
            ],
            [0.3_f64.max(crude.abs()), 0.1],
        );
        let names = ["right_scale", "left_scale"];
        let mut radius = if self.has_pose {
            Shown::wheels("wheel_radius", names)
        } else {
            let of = |name, half| (name, Link::Log, vec![(0, half)]);
            Shown::new("wheel_radius", vec![of(names[0], 0.5), of(names[1], -0.5)])
        };
        radius.confused = vec!["slip_ratio"];
        if self.is_commanded {
            radius.confused.push("motor_gain");
        } else if self.streams.drive.is_none() {
            radius.confused.push("encoder_scale");
        }
        let track = |place: usize| {
            Shown::new(
                "track_width",
                vec![("scale", Link::Log, vec![(place, 1.0)])],
            )
        };
        let [by_scale, by_track] = self.asked.by_run;
        if !self.has_pose {
            // a gyro sees turns alone: a common factor of both wheels and the track are one
            if by_track {
                self.of_runs(all, "track of runs", "run track", RUN_TRACK);
            } else {
                all.push(Draft::new("track", vec![self.track()], vec![track(0)]));
            }
            let mut rows = radii;
            let mut radii = Draft::new("radii", vec![rows.remove(1)], vec![radius]);
            radii.lasting = self.is_commanded;
            all.push(radii);
            return;
        }
        let mut rows = radii;
        let mut shown = vec![radius];
        if by_scale {
            self.of_runs(all, "scale of runs", "run scale", RUN_SCALE);
            rows.remove(0);
            shown.clear();
        }
        if by_track {
            self.of_runs(all, "track of runs", "run track", RUN_TRACK);
        } else {
            shown.push(track(rows.len()));
            rows.push(self.track());
        }
        let mut geometry = Draft::new("geometry", rows, shown);
        geometry.lasting = self.is_commanded;
        if crude != 0.0 && !by_scale {
            geometry =
                geometry.from([vec![crude, 0.0, 0.0][..2 + usize::from(!by_track)].to_vec()]);
        }
        all.push(geometry);
    }

    /// Scale or track of each run of today by itself.
    fn of_runs(&self, all: &mut Vec<Draft>, name: &'static str, row: &'static str, place: usize) {
        let reference = self.streams.reference;
        let runs: Vec<usize> = (reference.before.runs..reference.runs.len()).collect();
        let deviation = match (place, reference.skids) {
            (RUN_TRACK, true) => 0.6,
            _ => 0.3,
        };
        let shown = runs.iter().enumerate().map(|(i, run)| {
            let values = if place == RUN_TRACK {
                vec![("scale", Link::Log, vec![(i, 1.0)])]
            } else {
                vec![("ratio", Link::LogLoss, vec![(i, 1.0)])]
            };
            let effect = if place == RUN_TRACK {
                "track_width"
            } else {
                "slip_ratio"
            };
            let mut shown = Shown::new(effect, values);
            shown.run = Some(*run);
            if place == RUN_SCALE {
                shown.confused = vec!["wheel_radius"];
            }
            shown
        });
        let mut draft = Draft::new(name, Vec::new(), shown.collect());
        draft.rows = runs
            .iter()
            .map(|run| Drafted::Run {
                name: row,
                run: *run,
                place,
                deviation,
            })
            .collect();
        draft.lasting = self.is_commanded;
        all.push(draft);
    }

    fn mounting(&self, all: &mut Vec<Draft>) {
        if !self.has_pose {
            return;
        }
        let length = |number: usize, index: usize| Row {
            name: "offset",
            number,
            moves: vec![(Reference(index), 1.0)],
            prior: about(4.0 * self.half_track_m),
            resolution: LENGTH_SHARE * self.half_track_m,
            repeatability: repeatability::OFFSET * 2.0 * self.half_track_m,
        };
        let mut rows = vec![length(0, OFFSET_X), length(1, OFFSET_Y)];
        let mut values = vec![
            ("x_m", Link::Identity, vec![(0, 1.0)]),
            ("y_m", Link::Identity, vec![(1, 1.0)]),
        ];
        let mut starts = Vec::new();
        if self.has_heading {
            rows.push(Row {
                name: "offset",
                number: 2,
                moves: vec![(Reference(OFFSET_YAW), 1.0)],
                prior: about(1.0),
                resolution: FACTOR,
                repeatability: repeatability::YAW_RAD,
            });
            values.push(("yaw_rad", Link::Identity, vec![(2, 1.0)]));
            starts.extend(MOUNTINGS_RAD.map(|yaw| vec![0.0, 0.0, yaw]));
        }
        let shown = vec![Shown::new("pose_offset", values)];
        all.push(Draft::new("offset", rows, shown).from(starts));
    }

    /// Which streams are late, and whose clock runs fast.
    fn clocks(&self, all: &mut Vec<Draft>) {
        let pose_s = STAMP_SHARE * self.longest_s(Run::pose_interval_s);
        let gyro_s = STAMP_SHARE * self.longest_s(|run| run.wheel_interval_s);
        let reference = self.streams.reference;
        let both = self.has_pose && self.has_gyro;
        let has_wheels = !self.is_commanded && self.has_reference();
        // wheels and one reference are all: nothing tells which of both is late
        let two = self.streams.drive.is_none() && !both;
        let unnoticed = |interval_s: f64| repeatability::TIME_S.max(interval_s);
        let late = |name, moves: Vec<(Place, f64)>, resolution: f64| Row {
            name,
            number: 0,
            moves,
            prior: about(0.3),
            resolution,
            repeatability: unnoticed(resolution),
        };
        let duration_s = self.duration_s();
        let fast = |name, moves: Vec<(Place, f64)>, stamp_s: f64| Row {
            name,
            number: 0,
            moves,
            prior: about(0.003),
            resolution: RATE.max(stamp_s / duration_s),
            repeatability: repeatability::RATE,
        };
        let stamped = reference.before.stamped;
        let mut add_late = |row: Row, effect, mirror, stamped_s: f64| {
            let mut shown = Shown::plain(effect, "latency_s");
            if two {
                shown.mirror = mirror;
                shown.confused = mirror.iter().map(|(other, _)| *other).collect();
            }
            let starts = LATENCIES_S.map(|own| vec![own]).into_iter();
            let starts = starts.chain((stamped_s != 0.0).then(|| vec![stamped_s]));
            let mut draft = Draft::new(row.name, vec![row], vec![shown]).from(starts);
            draft.inflation = LATENCY_INFLATION;
            if effect == "wheels_latency" {
                draft.cost = WHEELS_COST;
            }
            all.push(draft);
        };
        let wheels = Some(("wheels_latency", -1.0));
        if self.has_pose && !self.is_commanded {
            let row = late("late pose", vec![(Reference(POSE_LATENCY), 1.0)], pose_s);
            add_late(row, "pose_latency", wheels, stamped[0][0]);
        }
        if self.has_gyro && (self.has_pose || !self.is_commanded) {
            let row = late("late gyro", vec![(Reference(GYRO_LATENCY), 1.0)], gyro_s);
            let mirror = wheels.filter(|_| !self.is_commanded);
            add_late(row, "imu_latency", mirror, stamped[1][0]);
        }
        if has_wheels && !two {
            let moves = self.of_wheels([POSE_LATENCY, GYRO_LATENCY], DELAY);
            let row = late("late wheels", moves, TIME_S.max(gyro_s));
            add_late(row, "wheels_latency", None, -stamped[0][0]);
        }
        let mut add_fast = |row: Row, stream: &'static str| {
            let mut shown = Shown::plain("clock_drift", "rate");
            shown.word = Some(("stream", stream));
            let mut draft = Draft::new(row.name, vec![row], vec![shown]);
            draft.inflation = RATE_INFLATION;
            draft.cost = RATE_COST;
            draft.later = true;
            all.push(draft);
        };
        if self.has_pose {
            add_fast(
                fast("fast pose", vec![(Reference(POSE_RATE), 1.0)], pose_s),
                "pose",
            );
        }
        if self.has_gyro && !reference.has_clocks_of_runs() {
            add_fast(
                fast("fast gyro", vec![(Reference(GYRO_RATE), 1.0)], gyro_s),
                "imu",
            );
        }
        if (has_wheels && !two) || self.streams.drive.is_some() {
            let moves = self.of_wheels([POSE_RATE, GYRO_RATE], CLOCK);
            add_fast(fast("fast wheels", moves, 0.0), "wheels");
        }
    }

    /// What the clock of the wheels moves.
    fn of_wheels(&self, references: [usize; 2], drive: usize) -> Vec<(Place, f64)> {
        let has = [self.has_pose, self.has_gyro];
        let own = references.into_iter().zip(has).filter(|(_, has)| *has);
        let own = own.map(|(index, _)| (Reference(index), -1.0));
        own.chain(self.streams.drive.map(|_| (Drive(drive), 1.0)))
            .collect()
    }

    fn commands(&self, all: &mut Vec<Draft>) {
        let of = |name, index, prior: Prior, resolution: f64, repeatability: f64| Row {
            name,
            number: 0,
            moves: vec![(Drive(index), 1.0)],
            prior,
            resolution,
            repeatability,
        };
        let mut step_s = TIME_S;
        if self.is_commanded && !self.has_pose {
            step_s = step_s.hypot(GYRO_STEP_SHARE * self.longest_s(Run::gyro_interval_s));
        }
        let is_commanded = self.is_commanded;
        let mut delay = Shown::plain("actuator_delay", "delay_s");
        if is_commanded {
            let stream = if self.has_pose {
                "pose_latency"
            } else {
                "imu_latency"
            };
            delay.confused = vec![stream];
        } else {
            // a command cannot act before it is given: then the stamps of the wheels are early
            delay.mirror = Some(("wheels_latency", 1.0));
            if !self.has_reference() {
                delay.confused = vec!["wheels_latency"];
            }
        }
        let stamped_s = self
            .streams
            .drive
            .map_or(0.0, |own| own.before.stamped[0][0]);
        let starts = LATENCIES_S.into_iter().filter(|own| *own > -0.2);
        let starts = starts.chain((stamped_s != 0.0).then_some(stamped_s));
        let row = of("delay", DELAY, about(0.2), step_s, repeatability::TIME_S);
        all.push(Draft::new("delay", vec![row], vec![delay]).from(starts.map(|own| vec![own])));
        let row = of("lag", LAG, about(0.3), step_s, repeatability::TIME_S);
        let shown = vec![Shown::plain("actuator_lag", "time_constant_s")];
        let mut lag = Draft::new("lag", vec![row], shown).from(LAGS_S.map(|own| vec![own]));
        lag.later = is_commanded;
        all.push(lag);
        if let Some(drive) = self.streams.drive {
            self.gains(all, drive.crude_gain);
        }
        self.limits(all, &of);
        let share = Row {
            number: 0,
            ..of("slow", SLOW_SHARE, about(0.3), 0.01, 0.0)
        };
        let time = Row {
            number: 1,
            ..of("slow", SLOW_TIME, about(2.0), 1.0, 0.0)
        };
        if !is_commanded {
            let slow = Draft::new("slow response", vec![share, time], Vec::new());
            all.push(slow.from([SLOW.to_vec()]));
        }
        let speeds = self.streams.drive.filter(|own| {
            let mut runs = own.runs.iter();
            runs.any(|run| run.wheels.kind == WheelKind::Speed)
        });
        if let Some(drive) = speeds {
            let interval_s = drive
                .runs
                .iter()
                .map(|run| run.interval_s())
                .fold(0.0, f64::max);
            let row = of("averaged", AVERAGED, about(0.1), interval_s, 0.0);
            let mut averaged = Draft::new("mean speeds", vec![row], Vec::new());
            averaged.positive = true;
            all.push(averaged.from([vec![interval_s], vec![0.5 * interval_s]]));
        }
        let row = of("sag", SAG, about(0.02), SAG_PER_S, repeatability::SAG_PER_S);
        let mut sag = Draft::new(
            "sag",
            vec![row],
            vec![Shown::plain("supply_sag", "rate_per_s")],
        );
        (sag.positive, sag.lasting, sag.later) = (true, true, true);
        all.push(sag);
    }

    /// Motors that turn more than commanded, or encoders that count more.
    fn gains(&self, all: &mut Vec<Draft>, crude: f64) {
        let rows = self.factors(
            "gain",
            [vec![(Drive(GAIN), 1.0)], vec![(Drive(GAIN_ASYMMETRY), 1.0)]],
            [0.3_f64.max(crude.abs()), 0.2],
        );
        let mut shown = Shown::wheels("motor_gain", ["right", "left"]);
        if !self.has_reference() {
            shown.confused = vec!["encoder_scale"];
        }
        let starts = || (crude != 0.0).then(|| vec![crude, 0.0]);
        let mut gain = Draft::new("gain", rows, vec![shown]).from(starts());
        gain.lasting = true;
        all.push(gain);
        if !self.has_pose {
            return;
        }
        let rows = self.factors(
            "count",
            [
                vec![(Reference(COMMON), -1.0), (Drive(GAIN), 1.0)],
                vec![(Reference(ASYMMETRY), -1.0), (Drive(GAIN_ASYMMETRY), 1.0)],
            ],
            [0.3_f64.max(crude.abs()), 0.2],
        );
        let shown = vec![Shown::wheels(
            "encoder_scale",
            ["right_scale", "left_scale"],
        )];
        let mut count = Draft::new("count", rows, shown).from(starts());
        count.lasting = true;
        count.cost = COUNT_COST;
        count.later = true;
        all.push(count);
    }

    /// Dead zone, saturation, dead band.
    fn limits(
        &self,
        all: &mut Vec<Draft>,
        of: &dyn Fn(&'static str, usize, Prior, f64, f64) -> Row,
    ) {
        let top = self.top_rad_s;
        let (resolution, unnoticed) = (COMMAND_SHARE * top, repeatability::COMMAND * top);
        let row = of("zone", DEAD_ZONE, about(0.3 * top), resolution, unnoticed);
        let shown = vec![Shown::plain("command_dead_zone", "speed_rad_s")];
        let starts = DEAD_ZONES.map(|share| vec![share * top]);
        let mut zone = Draft::new("dead zone", vec![row], shown).from(starts);
        (zone.positive, zone.lasting, zone.later) = (true, true, self.is_commanded);
        all.push(zone);
        let known = self.nominal_of(SATURATION);
        let mean = if known == 0.0 { top } else { 0.0 };
        let prior = Prior {
            mean,
            deviation: top,
        };
        let row = of("saturation", SATURATION, prior, resolution, unnoticed);
        let shown = vec![Shown::plain("command_saturation", "speed_rad_s")];
        let starts = SATURATIONS.map(|share| vec![share * top]).into_iter();
        let starts = starts.filter(|_| known == 0.0);
        let mut saturation = Draft::new("saturation", vec![row], shown).from(starts);
        (saturation.positive, saturation.lasting, saturation.later) = (true, true, true);
        saturation.cost = SATURATION_COST;
        all.push(saturation);
        let bands = self.bands();
        if bands.is_empty() {
            return;
        }
        let row = of("band", DEAD_BAND, about(top), resolution, unnoticed);
        let shown = vec![Shown::plain("command_dead_band", "speed_rad_s")];
        let mut band = Draft::new("dead band", vec![row], shown);
        band.search = Search::Profiled(bands);
        (band.lasting, band.later) = (true, true);
        all.push(band);
    }

    /// What the drive has of a parameter before any change.
    fn nominal_of(&self, drive: usize) -> f64 {
        let index = match self.streams.drive {
            Some(own) if own.before.any() => {
                self.streams.drive_first()
                    + super::command_to_wheels::CommandToWheels::shared(drive)
            }
            Some(_) => self.streams.drive_first() + drive,
            None if self.streams.compares() => self.streams.reference.shared(DRIVE_FIRST + drive),
            None => DRIVE_FIRST + drive,
        };
        self.asked.nominal[index]
    }

    /// Dead bands between the sizes of commands, as changes, rising.
    fn bands(&self) -> Vec<f64> {
        let levels = self.streams.levels_rad_s();
        let known = self.nominal_of(DEAD_BAND);
        let gaps = levels
            .windows(2)
            .map(|pair| f64::midpoint(pair[0], pair[1]));
        gaps.map(|own| own - known).collect()
    }

    /// Laws of speed over turn rate and over speed: what the catalogue does not have.
    fn laws(&self, all: &mut Vec<Draft>) {
        if !self.has_pose {
            return;
        }
        let reference = self.streams.reference;
        let reach = reference.knots.map(|knots| knots.reach());
        let floor = LENGTH_SHARE * (reach[0] * self.half_track_m).max(reach[1]);
        for (place, name) in ["law of w", "law of v"].into_iter().enumerate() {
            if reach[place] <= LEAST_DRIVER[place] {
                continue;
            }
            let first = LAW_FIRST + place * VALUES[0];
            let rows = (0..VALUES[place]).map(|number| Row {
                name,
                number,
                moves: vec![(Reference(first + number), 1.0)],
                prior: about(reference.law_prior_m_s()),
                resolution: floor,
                repeatability: 0.0,
            });
            let shown = vec![Shown::new("unknown", Vec::new())];
            // at exactly 0 the filter leaves a law out, and has no derivative by it
            let start = vec![f64::MIN_POSITIVE; VALUES[place]];
            let mut law = Draft::new(name, rows.collect(), shown).from([start]);
            law.cost = LAW_COST;
            law.lasting = true;
            law.later = true;
            all.push(law);
        }
    }
}
