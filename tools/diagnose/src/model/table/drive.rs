//! How drives follow their commands.

use super::draft::Place::{Drive, Reference};
use super::draft::{Draft, Row, Shown, about, mostly};
use super::known::Known;
use super::sizes::{
    COMMAND_SHARE, COUNT_COST, DEAD_ZONES, GYRO_STEP_SHARE, LAGS_S, LATENCIES_S, LOADS, MOTOR,
    PAIR, PULLS, SAG_PER_S, SATURATION_COST, SATURATIONS, SIZE, SLOW, TIME_S, repeatability,
};
use crate::data::streams::WheelKind;
use crate::estimate::Prior;
use crate::estimate::term::{Link, Search};
use crate::model::drive::{
    AVERAGED, DEAD_BAND, DEAD_ZONE, DELAY, FRICTION, GAIN, GAIN_ASYMMETRY, LAG, PULL, SAG,
    SATURATION, SLOW_SHARE, SLOW_TIME,
};
use crate::model::run::Run;
use crate::model::wheel_parameters::{ASYMMETRY, COMMON};

impl Known<'_> {
    pub(super) fn commands(&self, all: &mut Vec<Draft>) {
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
        // without wheels, a delay is a latency of the poses in all runs
        let is_of_runs = is_commanded && !self.has_gyro && self.asked.by_run[2];
        if !is_of_runs {
            let starts = starts.map(|own| vec![own]);
            all.push(Draft::new("delay", vec![row], vec![delay]).from(starts));
        }
        let row = of("lag", LAG, about(0.3), step_s, repeatability::TIME_S);
        let load = self.load();
        // what motors move, a data sheet says to some tens of per cent
        let shown = match load {
            Some(_) => Vec::new(),
            None => vec![Shown::plain("actuator_lag", "time_constant_s")],
        };
        let starts = match load {
            Some(load) => LOADS.map(|share| vec![share * load.lag_s()]).to_vec(),
            None => LAGS_S.map(|own| vec![own]).to_vec(),
        };
        let mut lag = Draft::new("lag", vec![row], shown).from(starts);
        (lag.later, lag.varies) = (is_commanded, load.is_some());
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
        if !is_commanded && self.volts.is_none() {
            let slow = Draft::new("slow response", vec![share, time], Vec::new());
            all.push(slow.from([SLOW.to_vec()]));
        }
        self.means(all, &of);
        self.forces(all, &of);
        let row = of("sag", SAG, about(0.02), SAG_PER_S, repeatability::SAG_PER_S);
        let mut sag = Draft::new(
            "sag",
            vec![row],
            vec![Shown::plain("supply_sag", "rate_per_s")],
        );
        (sag.positive, sag.needs_relevance, sag.later) = (true, true, true);
        all.push(sag);
    }

    /// What takes from the speed of a motor under voltage: friction of the axles, a slope along the robot.
    fn forces(
        &self,
        all: &mut Vec<Draft>,
        of: &dyn Fn(&'static str, usize, Prior, f64, f64) -> Row,
    ) {
        let Some(load) = self.load() else { return };
        let top = self.top_rad_s;
        let prior = about(0.3 * top);
        let (resolution, repeatable) = (COMMAND_SHARE * top, repeatability::COMMAND * top);
        let row = of("friction", FRICTION, prior, resolution, repeatable);
        let torque_nm = 1.0 / load.speed_per_torque;
        let shown = vec![Shown::scaled("axle_friction", "torque_nm", torque_nm)];
        let starts = DEAD_ZONES.map(|share| vec![share * top]);
        let mut friction = Draft::new("friction", vec![row], shown).from(starts);
        (friction.positive, friction.needs_relevance) = (true, true);
        all.push(friction);
        if !self.streams.reference.keeps_heading() {
            return;
        }
        let row = of("pull", PULL, prior, resolution, repeatable);
        let grade = 1.0 / load.speed_per_sine;
        let shown = vec![Shown::scaled("floor_slope", "grade", grade)];
        let starts = PULLS.map(|share| vec![share * top]);
        let mut pull = Draft::new("pull", vec![row], shown).from(starts);
        pull.needs_relevance = true;
        all.push(pull);
    }

    /// Speeds of wheels that are means over an interval.
    fn means(
        &self,
        all: &mut Vec<Draft>,
        of: &dyn Fn(&'static str, usize, Prior, f64, f64) -> Row,
    ) {
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
    }

    /// Motors that turn more than commanded, or encoders that count more.
    pub(super) fn gains(&self, all: &mut Vec<Draft>, crude: f64) {
        let rows = self.factors(
            "gain",
            [vec![(Drive(GAIN), 1.0)], vec![(Drive(GAIN_ASYMMETRY), 1.0)]],
            match self.volts {
                // what a data sheet says of the speed without a load
                Some(_) if crude == 0.0 => [mostly(MOTOR), mostly(MOTOR)],
                _ => [about(0.3_f64.max(crude.abs())), about(0.2)],
            },
        );
        let mut shown = Shown::wheels("motor_gain", ["right", "left"]);
        if !self.has_reference() {
            shown.confused = vec!["encoder_scale"];
        }
        let starts = || (crude != 0.0).then(|| vec![crude, 0.0]);
        if self.volts.is_some() {
            self.motors(all, rows, &shown.confused, crude);
        } else {
            let mut gain = Draft::new("gain", rows, vec![shown]).from(starts());
            gain.needs_relevance = true;
            all.push(gain);
        }
        if !self.has_pose {
            return;
        }
        let rows = self.factors(
            "count",
            [
                vec![(Reference(COMMON), -1.0), (Drive(GAIN), 1.0)],
                vec![(Reference(ASYMMETRY), -1.0), (Drive(GAIN_ASYMMETRY), 1.0)],
            ],
            // beside wheels of another size, whose prior it has: what is due for it tells them apart
            [mostly(SIZE), mostly(PAIR)],
        );
        let shown = vec![Shown::wheels(
            "encoder_scale",
            ["right_scale", "left_scale"],
        )];
        let mut count = Draft::new("count", rows, shown).from(starts());
        count.needs_relevance = true;
        count.cost = COUNT_COST;
        count.later = true;
        all.push(count);
    }

    /// Motors under voltage: what both share looks like friction, what they differ by does not.
    fn motors(&self, all: &mut Vec<Draft>, rows: Vec<Row>, confused: &[&'static str], crude: f64) {
        let sides = [("gain", 1.0, 1.0), ("gain of sides", 0.5, -0.5)];
        for ((name, right, left), row) in sides.into_iter().zip(rows) {
            let of = |name, weight| (name, Link::Log, vec![(0, weight)]);
            let mut shown = Shown::new("motor_gain", vec![of("right", right), of("left", left)]);
            shown.confused = confused.to_vec();
            let begun = (crude != 0.0 && name == "gain").then(|| vec![crude]);
            let mut gain = Draft::new(name, vec![row], vec![shown]).from(begun);
            gain.needs_relevance = true;
            all.push(gain);
        }
    }

    /// Dead zone, saturation, dead band.
    pub(super) fn limits(
        &self,
        all: &mut Vec<Draft>,
        of: &dyn Fn(&'static str, usize, Prior, f64, f64) -> Row,
    ) {
        let top = self.top_rad_s;
        let (resolution, repeatable) = (COMMAND_SHARE * top, repeatability::COMMAND * top);
        let row = of("zone", DEAD_ZONE, about(0.3 * top), resolution, repeatable);
        let shown = vec![match self.volts {
            Some(volts) => {
                Shown::scaled("command_dead_zone", "voltage_v", 1.0 / volts.speed_per_volt)
            }
            None => Shown::plain("command_dead_zone", "speed_rad_s"),
        }];
        let starts = DEAD_ZONES.map(|share| vec![share * top]);
        let mut zone = Draft::new("dead zone", vec![row], shown).from(starts);
        (zone.positive, zone.needs_relevance, zone.later) = (true, true, self.is_commanded);
        all.push(zone);
        let known = self.nominal_of(SATURATION);
        let mean = if known == 0.0 { top } else { 0.0 };
        let prior = Prior {
            mean,
            deviation: top,
            has_tails: false,
        };
        let row = of("saturation", SATURATION, prior, resolution, repeatable);
        let shown = vec![match self.load() {
            Some(load) => Shown::scaled(
                "command_saturation",
                "torque_nm",
                1.0 / load.speed_per_torque,
            ),
            None => Shown::plain("command_saturation", "speed_rad_s"),
        }];
        let starts = SATURATIONS.map(|share| vec![share * top]).into_iter();
        let starts = starts.filter(|_| known == 0.0);
        let mut saturation = Draft::new("saturation", vec![row], shown).from(starts);
        (
            saturation.positive,
            saturation.needs_relevance,
            saturation.later,
        ) = (true, true, true);
        saturation.cost = SATURATION_COST;
        all.push(saturation);
        let bands = self.bands();
        // voltages of a controller are all different
        if bands.is_empty() || self.volts.is_some() {
            return;
        }
        let row = of("band", DEAD_BAND, about(top), resolution, repeatable);
        let shown = vec![Shown::plain("command_dead_band", "speed_rad_s")];
        let mut band = Draft::new("dead band", vec![row], shown);
        band.search = Search::Profiled(bands);
        (band.needs_relevance, band.later) = (true, true);
        all.push(band);
    }

    /// Dead bands between the sizes of commands, as changes, rising.
    pub(super) fn bands(&self) -> Vec<f64> {
        let levels = self.streams.levels_rad_s();
        let known = self.nominal_of(DEAD_BAND);
        let gaps = levels
            .windows(2)
            .map(|pair| f64::midpoint(pair[0], pair[1]));
        gaps.map(|own| own - known).collect()
    }
}
