//! How the wheels of a robot answer the torques or voltages that it is told: the filter over the plant, row by row. Poses and
//! gyro are left to the filters of the wheels: what a wheel does on its way is no force.

use slipstream_bus::EffectSpec;
use slipstream_sim::Robot;

use super::bank::{Bank, Source};
use super::changes::{Forces, SENSORS};
use super::kinematic::counts;
use super::linear::Linear;
use crate::data::feed::Feed;
use crate::data::streams::WheelKind;
use crate::filter::dynamic::flow::{Flow, Point};
use crate::filter::dynamic::gains::{Heard, NOT_MEASURED, On};
use crate::filter::dynamic::{DISTURBANCES, DISTURBED, N, Noise, Row, Run, SLIP, Sensor, Vector};
use crate::model::plant::filtered::STEPS_S;
use crate::model::plant::machine::Start;

/// Rows that are this much farther apart begin the filter anew (s).
const LOST_S: f64 = 5.0;
/// A stream that says nothing is waited for so long (s).
const WAITS_S: f64 = 1.0;
/// The filter begins when it has rows of this time (s).
const BEGINS_S: f64 = 0.3;
/// Slowest wheel of which parameters tell (rad/s).
const ROLLS_RAD_S: f64 = 0.5;
/// The filter on its way.
pub(crate) struct Dynamic {
    forces: Forces,
    source: usize,
    run: Run,
    on: Option<On<N>>,
    /// When the last row was measured (s).
    before_s: f64,
    /// Rows that wait, by when they were measured (s).
    waiting: Vec<(f64, Row)>,
    /// Last stamps (s) of the wheels and the commands.
    last_s: [f64; 2],
    /// The last reading of each wheel, and how often it was read in a row.
    repeated: [(f64, f64); 2],
}

impl Dynamic {
    /// The filter of a robot, and the source that a bank has of it: with this number, and with parameters from `first` on.
    pub(crate) fn new(forces: Forces, number: usize, first: usize) -> (Self, Source) {
        let places = forces.robots.places.iter().map(|own| own + first);
        let source = Source {
            n: N,
            places: places.collect(),
        };
        let own = Self {
            run: nothing(),
            source: number,
            forces,
            on: None,
            before_s: f64::NEG_INFINITY,
            waiting: Vec::new(),
            last_s: [f64::NEG_INFINITY; 2],
            repeated: [(f64::NAN, 0.0); 2],
        };
        (own, source)
    }

    /// Forgets where the robot is.
    pub(crate) fn restart(&mut self) {
        self.on = None;
        self.before_s = f64::NEG_INFINITY;
        self.waiting.clear();
        self.run.commands.clear();
        self.last_s = [f64::NEG_INFINITY; 2];
        self.repeated = [(f64::NAN, 0.0); 2];
    }

    /// From now on the robot has parameters that are off those of the baseline by `shift`, and effects besides that are
    /// none of its forces. Returns whether there is such a robot.
    pub(crate) fn move_to(&mut self, shift: &[f64], besides: &[EffectSpec]) -> bool {
        let Some(robots) = self.forces.plants.at(shift, besides) else {
            return false;
        };
        self.forces.robots = robots;
        self.on = None;
        true
    }

    /// Hears the rows of a feed that no other stream can precede any more.
    pub(crate) fn hear(&mut self, feed: &mut Feed, bank: &mut Bank) {
        self.take(feed);
        let until_s = self.until_s(feed.now_s);
        self.waiting.sort_by(|a, b| a.0.total_cmp(&b.0));
        let due = self
            .waiting
            .partition_point(|(true_s, _)| *true_s <= until_s);
        if self.on.is_none() && !self.begin(due, until_s) {
            return;
        }
        let rows: Vec<(f64, Row)> = self.waiting.drain(..due).collect();
        for (true_s, row) in rows {
            self.hear_row(true_s, &row, bank);
        }
        self.forget();
    }

    /// Takes what a feed has.
    fn take(&mut self, feed: &mut Feed) {
        for (t_s, command) in feed.told.drain(..) {
            self.last_s[1] = t_s;
            self.run.commands.push((t_s, command));
        }
        let kind = match feed.kind {
            WheelKind::Angle => Sensor::WheelAngle,
            WheelKind::Speed => Sensor::WheelSpeed,
        };
        // others hear the wheels, too
        let last_s = self.last_s[0];
        for (stamp_s, [right, left]) in feed.rows.iter().filter(|row| row.0 > last_s) {
            self.last_s[0] = *stamp_s;
            self.wait(kind, *stamp_s, [*right, *left, f64::NAN]);
        }
    }

    fn wait(&mut self, sensor: Sensor, stamp_s: f64, value: [f64; 3]) {
        let place = SENSORS.iter().position(|own| own.0 == sensor);
        let Some(mut variance) = place.and_then(|place| self.forces.variance[place]) else {
            return;
        };
        if sensor == Sensor::WheelAngle {
            for wheel in 0..2 {
                variance[wheel] *= self.again(wheel, value[wheel]);
            }
        }
        for (own, value) in variance.iter_mut().zip(&value) {
            if !value.is_finite() {
                *own = NOT_MEASURED;
            }
        }
        let robot = &self.forces.robots.base;
        let true_s = robot.true_s(sensor.stream(), stamp_s);
        // what comes behind rows that were heard is too late
        if true_s >= self.before_s {
            let row = Row {
                sensor,
                stamp_s,
                value,
                variance,
            };
            self.waiting.push((true_s, row));
        }
    }

    /// Readings of a wheel that repeat count as one: the factor of the variance of one more.
    fn again(&mut self, wheel: usize, value: f64) -> f64 {
        let (last, times) = &mut self.repeated[wheel];
        *times = if value == *last { *times + 1.0 } else { 1.0 };
        *last = value;
        *times * if *times > 1.0 { *times - 1.0 } else { 1.0 }
    }

    /// Until when (s) everything was said.
    fn until_s(&self, now_s: f64) -> f64 {
        let least_s = self.last_s[0].min(self.last_s[1]);
        least_s.max(now_s - WAITS_S)
    }

    /// Begins with the first of the rows that are due, if they say how the robot moves.
    fn begin(&mut self, due: usize, until_s: f64) -> bool {
        let (Some((first_s, _)), Some((told_s, _))) =
            (self.waiting.first(), self.run.commands.first())
        else {
            return false;
        };
        let begin_s = first_s.max(*told_s);
        if until_s - begin_s < BEGINS_S {
            return false;
        }
        let rows: Vec<Row> = self.waiting[..due].iter().map(|own| own.1).collect();
        let start = Start::of(&rows, 0.0, self.forces.plants.model());
        self.run.begin_s = begin_s;
        self.run.start = start.at;
        self.run.start_deviation = of(&self.forces.noise, start.deviation);
        self.run.lost_deviation = of(&self.forces.noise, start.lost_deviation);
        let flow = flow(&self.forces.robots.base, &self.run, &self.forces.noise);
        self.on = Some(On::begin(&flow, &self.forces.noise));
        self.before_s = begin_s;
        true
    }

    fn hear_row(&mut self, true_s: f64, row: &Row, bank: &mut Bank) {
        let true_s = true_s.max(self.run.begin_s);
        if true_s - self.before_s > LOST_S {
            self.on = None;
        }
        let noise = &self.forces.noise;
        let Some(on) = &mut self.on else {
            bank.lose(self.source);
            return;
        };
        let decay = noise.decay((true_s - self.before_s).max(0.0));
        on.go_on(noise, &decay);
        let before = on.point.clone();
        let flow = flow(&self.forces.robots.base, &self.run, noise);
        let Some(heard) = on.hear(&flow, noise, true_s, row) else {
            self.on = None;
            bank.lose(self.source);
            return;
        };
        let linear = self
            .forces
            .linear(&flow, [&before, &on.point], &heard, &decay, true_s, row);
        self.before_s = true_s;
        bank.hear(self.source, &linear, 1.0);
    }

    /// Lets go of commands that were followed.
    fn forget(&mut self) {
        if let Some(on) = &mut self.on {
            let passed = on.point.passed();
            self.run.commands.drain(..passed);
        }
    }
}

/// A run of which nothing was heard.
fn nothing() -> Run {
    Run {
        commands: Vec::new(),
        rows: Vec::new(),
        begin_s: 0.0,
        start: [0.0; N],
        start_deviation: [0.0; N],
        tracked_ahead_m: 0.0,
        without_gravity: false,
        left_out_s: Vec::new(),
        lost_deviation: [0.0; N],
        disturbances_s: Vec::new(),
    }
}

/// Deviations of a start; of wheels that cannot slide, none of slip.
fn of(noise: &Noise, mut deviation: Vector) -> Vector {
    if !noise.of_wheels {
        deviation[SLIP..].fill(0.0);
    }
    deviation
}

fn flow<'a>(robot: &'a Robot, run: &'a Run, noise: &Noise) -> Flow<'a> {
    Flow {
        robot,
        run,
        step_s: STEPS_S,
        of_wheels: noise.of_wheels,
        loads: &[],
    }
}

impl Forces {
    /// A row about the course of the filter: by its state before, from which disturbances had decayed, and by parameters.
    fn linear(
        &self,
        flow: &Flow<'_>,
        [before, after]: [&Point; 2],
        heard: &Heard,
        decay: &[f64; DISTURBANCES],
        true_s: f64,
        row: &Row,
    ) -> Linear {
        let (gain, step) = (&heard.gain, &heard.step);
        let white = gain.whitened(&heard.innovation);
        let size = white.iter().map(|own| own * own).sum::<f64>().sqrt();
        let root = counts(size, 3.0);
        let p = self.robots.after.len();
        let mut own = Linear {
            m: 3,
            n: N,
            p,
            innovation: white.iter().map(|own| own * root).collect(),
            by_state: vec![0.0; 3 * N],
            by_parameters: vec![0.0; 3 * p],
            state_by_state: vec![0.0; N * N],
            state_by_parameters: vec![0.0; N * p],
        };
        let left = |k: usize| {
            let disturbance = k.checked_sub(DISTURBED).and_then(|k| decay.get(k));
            disturbance.copied().unwrap_or(1.0)
        };
        for k in 0..N {
            let seen = step.measurement.map(|own| -own[k] * left(k));
            let whitened = gain.whitened(&seen);
            let corrected = gain.correction(&seen);
            for (a, own_white) in whitened.iter().enumerate() {
                own.by_state[a * N + k] = root * own_white;
            }
            for (i, own_corrected) in corrected.iter().enumerate() {
                own.state_by_state[i * N + k] = step.flow[i][k] * left(k) + own_corrected;
            }
        }
        if rolls(before) && rolls(after) {
            self.by_parameters(flow, before, heard, (true_s, row), root, &mut own);
        }
        own
    }

    /// By parameters: as the plant of each would have gone on from the same state.
    fn by_parameters(
        &self,
        flow: &Flow<'_>,
        before: &Point,
        heard: &Heard,
        (true_s, row): (f64, &Row),
        root: f64,
        own: &mut Linear,
    ) {
        let coordinates = flow.coordinates(before);
        let base = gone_on(flow, before, &coordinates, true_s, row);
        for (i, (robot, step)) in self.robots.after.iter().zip(&self.robots.steps).enumerate() {
            let other = Flow { robot, ..*flow };
            let moved = gone_on(&other, before, &coordinates, true_s, row);
            let seen: [f64; 3] = std::array::from_fn(|a| {
                let slope = (base.1[a] - moved.1[a]) / step;
                if slope.is_finite() { slope } else { 0.0 }
            });
            for (a, white) in heard.gain.whitened(&seen).into_iter().enumerate() {
                own.by_parameters[a * own.p + i] = root * white;
            }
            for (k, corrected) in heard.gain.correction(&seen).into_iter().enumerate() {
                let flow = (moved.0[k] - base.0[k]) / step;
                own.state_by_parameters[k * own.p + i] = flow + corrected;
            }
        }
    }
}

/// Whether both wheels roll on: what friction does jumps where one slides or stops.
fn rolls(point: &Point) -> bool {
    let speeds = point.state.wheel_speed();
    let turn = speeds.iter().all(|own| own.abs() > ROLLS_RAD_S);
    turn && point.state.slides() == [false; 2] && point.state.engaged() == [true; 2]
}

/// State and readings of a robot at `true_s` (s), which was at these coordinates before.
fn gone_on(
    flow: &Flow<'_>,
    before: &Point,
    coordinates: &Vector,
    true_s: f64,
    row: &Row,
) -> (Vector, [f64; 3]) {
    let mut point = flow.rolling_as(before, coordinates);
    flow.advance(&mut point, true_s);
    (flow.coordinates(&point), flow.measured(&point, row))
}

#[cfg(test)]
mod tests {
    use slipstream_bus::RobotModel;

    use super::*;
    use crate::data::feed::Habits;
    use crate::data::track;
    use crate::explain::dynamic::baseline::Baseline;
    use crate::model::plant::machine::Machine;
    use crate::predict::fixture;
    use crate::watch::changes;
    use crate::watch::hypotheses::Hypotheses;

    const NOISE: Noise = Noise {
        size: [0.01, 1e-3, 1e-3, 1e-3, 1e-3],
        time_s: [0.3; 3],
        of_wheels: false,
        jitter_s: 0.0,
        beyond: [0.0; 3],
    };

    fn prepared() -> (Forces, Hypotheses) {
        let track = fixture::driven(&RobotModel::default(), 8.0, fixture::gentle);
        let machine = Machine::new(vec![track], RobotModel::default(), &[]);
        changes::of(Baseline {
            machine,
            noise: NOISE,
        })
        .unwrap()
    }

    /// The parameters of which a recording of `truth` says most, each by itself, and how much of it there is.
    fn told(own: (Forces, Hypotheses), truth: &RobotModel, shift: &[f64]) -> (Hypotheses, Bank) {
        let (forces, hypotheses) = own;
        let (mut filter, source) = Dynamic::new(forces, 0, 0);
        assert!(filter.move_to(shift, &[]));
        let mut bank = Bank::new(hypotheses.wide.len(), vec![source]);
        bank.open(0.0);
        let track = fixture::driven(truth, 8.0, fixture::gentle);
        let mut feed = Feed::new(Habits::default());
        feed.now_s = 8.0;
        feed.told.clone_from(&track.commands);
        let wheels = &track.of(track::Sensor::WheelAngle).unwrap().rows;
        feed.rows = wheels
            .iter()
            .map(|(t_s, [right, left, _])| (*t_s, [*right, *left]))
            .collect();
        filter.hear(&mut feed, &mut bank);
        (hypotheses, bank)
    }

    /// The number of an effect alone that fits best (in its unit), and its gain (nats).
    fn best(hypotheses: &Hypotheses, bank: &Bank, effect: &str) -> [f64; 2] {
        let sum = &bank.onsets[0].sum;
        let mut all = hypotheses.all.iter();
        let own = all.find(|own| own.effect == effect).unwrap();
        let w = own.directions.column(0);
        let (score, information) = (w.dot(&sum.score), w.dot(&(&sum.information * w)));
        let size = score / information * own.values[0].weights[0];
        [size, score * score / information / 2.0]
    }

    #[test]
    fn a_load_is_seen_as_large_as_it_is() {
        let load = [("mass_kg", 0.05), ("x_m", 0.0), ("y_m", 0.0)];
        let truth = RobotModel::default().with("payload", &load);
        let (hypotheses, bank) = told(prepared(), &truth, &[]);
        let [mass_kg, gain] = best(&hypotheses, &bank, "payload");
        // a twentieth of the mass: to first order, and as far as Huber's weights leave it
        assert!((mass_kg - 0.05).abs() < 0.005, "{mass_kg} kg");
        assert!(gain > 10.0, "{gain}");
        let drag = best(&hypotheses, &bank, "viscous_drag");
        assert!(drag[1] < gain, "{drag:?} beside {gain}");
    }

    #[test]
    fn a_load_that_is_known_is_no_change() {
        let load = [("mass_kg", 0.05), ("x_m", 0.0), ("y_m", 0.0)];
        let truth = RobotModel::default().with("payload", &load);
        let own = prepared();
        let mut all = own.1.all.iter();
        let payload = all.find(|own| own.effect == "payload").unwrap();
        let numbers = 0.05 / payload.values[0].weights[0];
        let shift: Vec<f64> = payload
            .directions
            .column(0)
            .iter()
            .map(|own| own * numbers)
            .collect();
        let (hypotheses, bank) = told(own, &truth, &shift);
        let [mass_kg, gain] = best(&hypotheses, &bank, "payload");
        assert!(mass_kg.abs() < 1e-3 && gain < 1.0, "{mass_kg} kg, {gain}");
    }
}
