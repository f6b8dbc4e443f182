//! From the terms that are needed to effects of the catalogue.
//!
//! The fits know what the streams show: how late one clock is against another, how far a wheel carries.
//! Which effect that is follows from all of them together, the fewest that explain it: a wheel that
//! turns too far under its command and carries too little by as much is an encoder that counts wrong.

use super::calibration::Calibration;
use super::claim::{Claim, Law, Scale, Value};
use super::drive::DriveFit;
use super::term::{
    BAND_TERM, CLOCK_TERM, DELAY_TERM, FLOOR, GAIN_TERM, GEOMETRY, GYRO_CLOCK, GYRO_LATE, LAG_TERM,
    LAW_TERMS, OFFSET, OFFSET_TURN, POSE_CLOCK, POSE_LATE, SAG_TERM, SATURATION_TERM, ZONE_TERM,
};
use super::wheel_side::{Doubt, Settled};
use crate::filter::motion_law::{DRIVERS, VALUES};
use crate::model::drive::{
    CLOCK, DEAD_BAND, DEAD_ZONE, DELAY, DRIVE, GAIN, GAIN_ASYMMETRY, LAG, SAG, SATURATION,
};
use crate::model::from_wheels::{
    ASYMMETRY, COMMON, DRIVE_FIRST, FromWheels, GYRO_LATENCY, GYRO_RATE, LAW_FIRST, OFFSET_X,
    OFFSET_Y, OFFSET_YAW, POSE_LATENCY, POSE_RATE, RUN_SCALE, RUN_TRACK, TRACK,
};
use crate::select::criterion::Criterion;
use crate::select::elimination::{Kept, Selected};

/// Deviations within which two numbers count as one.
const ALIKE: f64 = 3.0;
/// Latencies within this (s) count as one.
const ALIKE_S: f64 = 2e-3;

/// Factor from which on a wheel is no longer of another size.
const FAR: f64 = 1.8;

/// A number and its deviation; what was not needed is 0 and known.
#[derive(Debug, Clone, Copy, Default)]
struct Known {
    value: f64,
    deviation: f64,
    needed: bool,
    gain: f64,
    p_value: f64,
    /// By how much it is larger in the second half, where the halves differ.
    difference: Option<f64>,
}

/// One fit whose terms are read: of a drive, or of a calibration.
#[derive(Clone, Copy)]
struct Fitted<'a> {
    found: &'a Selected,
    criterion: Criterion,
    /// Nominal values, with the index of the first parameter.
    nominal: &'a [f64],
    first: usize,
}

impl Fitted<'_> {
    fn kept(&self, name: &str) -> Option<&Kept> {
        self.found.kept(name)
    }

    fn change(&self, index: usize) -> f64 {
        self.found.fit.at[index] - self.nominal[self.first + index]
    }

    /// A linear combination of parameters that belong to one term.
    fn known(&self, term: &str, weights: &[(usize, f64)]) -> Known {
        let Some(kept) = self.kept(term) else {
            return Known::default();
        };
        let wald = kept.wald / (kept.term.caution * kept.term.caution);
        Known {
            value: weights.iter().map(|(i, w)| w * self.change(*i)).sum(),
            deviation: self.found.deviation(weights) * kept.term.caution,
            needed: true,
            gain: kept.gain,
            p_value: self.criterion.p_value(wald, kept.term.parameters.len()),
            difference: self
                .found
                .difference(weights)
                .map(|[difference, _]| difference),
        }
    }

    /// The term that has scale and track of single runs.
    fn of_floor(&self) -> &'static str {
        self.kept(FLOOR).map_or(GEOMETRY, |kept| kept.term.name)
    }

    fn half(&self, known: Known) -> f64 {
        self.criterion.half_width() * known.deviation
    }

    /// A number as the change of a parameter.
    fn value(&self, name: &'static str, scale: Scale, known: Known) -> Value {
        let halves = known
            .difference
            .map(|d| [known.value - d / 2.0, known.value + d / 2.0]);
        Value {
            halves,
            ..Value::new(name, scale, known.value, self.half(known))
        }
    }

    /// Whether a number is clearly not 0.
    fn is_clear(&self, known: Known) -> bool {
        let z = known.value / known.deviation.max(1e-300);
        known.needed
            && self.criterion.alone().p_value(z * z, 1) < crate::select::criterion::FALSE_ALARM
    }
}

/// All fits of one machine.
pub(crate) struct Reading<'a> {
    pub(crate) machine: &'a FromWheels,
    pub(crate) nominal: &'a [f64],
    /// The same with what turned out to be the encoders': what the calibration starts from.
    pub(crate) neutral: &'a [f64],
    pub(crate) calibration: Option<&'a Calibration>,
    pub(crate) drive: Option<&'a DriveFit>,
    pub(crate) settled: &'a [Settled],
}

impl Reading<'_> {
    /// What the model leaves out.
    pub(crate) fn claims(&self) -> Vec<Claim> {
        let mut claims = Vec::new();
        self.latencies(&mut claims);
        self.clocks(&mut claims);
        self.mounting(&mut claims);
        self.sizes(&mut claims);
        self.commands(&mut claims);
        self.laws(&mut claims);
        claims.sort_by(|a, b| b.gain.total_cmp(&a.gain));
        claims
    }

    fn reference(&self) -> Option<Fitted<'_>> {
        self.calibration.map(|calibration| Fitted {
            found: &calibration.after,
            criterion: calibration.criterion,
            nominal: self.neutral,
            first: 0,
        })
    }

    /// The drive: fitted by itself where wheels were recorded, else with the reference.
    fn drive_fitted(&self) -> Option<Fitted<'_>> {
        if let Some(drive) = self.drive {
            return Some(Fitted {
                found: &drive.after,
                criterion: drive.criterion,
                nominal: self.nominal,
                first: DRIVE_FIRST,
            });
        }
        self.reference().filter(|_| self.machine.is_commanded())
    }

    /// Index of a parameter of the drive in its fit.
    fn of_drive(&self, parameter: usize) -> usize {
        if self.drive.is_some() {
            parameter
        } else {
            DRIVE_FIRST + parameter
        }
    }

    /// What was settled of a doubt.
    fn settled(&self, doubt: Doubt) -> Option<&Settled> {
        self.settled.iter().find(|settled| settled.doubt == doubt)
    }

    fn is_wheels(&self, doubt: Doubt) -> bool {
        self.settled(doubt).is_some_and(|settled| settled.is_wheels)
    }

    /// The other name of a doubt that nothing settles.
    fn doubtful(&self, doubt: Doubt, other: &'static str) -> Vec<&'static str> {
        match (self.settled(doubt), self.drive) {
            (Some(settled), _) if !settled.tie => Vec::new(),
            (None, None) => Vec::new(),
            _ => vec![other],
        }
    }

    /// The effect that fits as well in the place of a term of the drive.
    fn alike(&self, term: &str, other: &'static str) -> Option<&'static str> {
        let fitted = self.drive_fitted()?;
        let mut all = fitted.found.alike.iter();
        all.any(|[own, _]| *own == term).then_some(other)
    }

    fn latencies(&self, claims: &mut Vec<Claim>) {
        let delay = self.drive_fitted().map_or(Known::default(), |fitted| {
            fitted.known(DELAY_TERM, &[(self.of_drive(DELAY), 1.0)])
        });
        let late = |term: &str, index: usize| {
            self.reference()
                .map_or(Known::default(), |f| f.known(term, &[(index, 1.0)]))
        };
        let mut pose = late(POSE_LATE, POSE_LATENCY);
        let mut gyro = late(GYRO_LATE, GYRO_LATENCY);
        if self.drive.is_none() && !self.machine.is_commanded() && pose.needed && gyro.needed {
            // both references late by one amount: early wheels
            let all = [(-1.0, pose), (-1.0, gyro)];
            let common = together(&all);
            if all
                .iter()
                .all(|(sign, known)| alike(sign * known.value, known.deviation, common, ALIKE_S))
            {
                claims.push(self.late("wheels_latency", common, &[POSE_LATENCY, GYRO_LATENCY]));
                (pose, gyro) = (Known::default(), Known::default());
            }
        }
        if delay.needed && self.drive.is_some() {
            let early = delay.value < 0.0;
            let mut claim = if self.is_wheels(Doubt::Delay) || early {
                let toggles = [POSE_LATENCY, GYRO_LATENCY];
                let mut claim = self.late("wheels_latency", delay, &toggles);
                claim.confused = self.doubtful(Doubt::Delay, "actuator_delay");
                claim
            } else {
                let mut claim = self.delay(delay);
                claim.confused = self.doubtful(Doubt::Delay, "wheels_latency");
                claim
            };
            claim.toggles.push(DRIVE_FIRST + DELAY);
            claim
                .confused
                .extend(self.alike(DELAY_TERM, "actuator_lag"));
            claims.push(claim);
        } else if delay.needed {
            let mut claim = self.delay(delay);
            claim.toggles = vec![DRIVE_FIRST + DELAY];
            claim.confused = if self.machine.has_pose() {
                vec!["pose_latency"]
            } else {
                vec!["imu_latency"]
            };
            claim
                .confused
                .extend(self.alike(DELAY_TERM, "actuator_lag"));
            claims.push(claim);
        }
        for (known, effect, index) in [
            (pose, "pose_latency", POSE_LATENCY),
            (gyro, "imu_latency", GYRO_LATENCY),
        ] {
            if known.needed && self.has_two_streams() {
                claims.push(self.between(effect, known, index));
            } else if known.needed {
                claims.push(self.late(effect, known, &[index]));
            }
        }
    }

    /// Whether wheels and one reference are all that there is: nothing tells which of both is late.
    fn has_two_streams(&self) -> bool {
        let references = [self.machine.has_pose(), self.machine.has_gyro()];
        self.drive.is_none() && !self.machine.is_commanded() && references != [true; 2]
    }

    /// The claim of a delay between wheels and their only reference, `effect` if that is the late one. A
    /// stream that is stamped before it is measured is the less likely of the two.
    fn between(&self, effect: &'static str, known: Known, index: usize) -> Claim {
        let wheels = "wheels_latency";
        if known.value > 0.0 {
            let mut claim = self.late(effect, known, &[index]);
            claim.confused = vec![wheels];
            return claim;
        }
        let late = Known {
            value: -known.value,
            ..known
        };
        let mut claim = self.late(wheels, late, &[index]);
        claim.confused = vec![effect];
        claim
    }

    fn delay(&self, delay: Known) -> Claim {
        let fitted = self.drive_fitted();
        let value = fitted.map(|fitted| fitted.value("delay_s", Scale::Plain, delay));
        claim("actuator_delay", delay, value, [])
    }

    /// The claim of a late stream.
    fn late(&self, effect: &'static str, known: Known, toggles: &[usize]) -> Claim {
        self.stamped(effect, "latency_s", known, toggles)
    }

    /// The claim of an effect of stamps.
    fn stamped(
        &self,
        effect: &'static str,
        name: &'static str,
        known: Known,
        toggles: &[usize],
    ) -> Claim {
        let fitted = self.reference().or_else(|| self.drive_fitted());
        let value = fitted.map(|fitted| fitted.value(name, Scale::Plain, known));
        claim(effect, known, value, toggles.iter().copied())
    }

    fn clocks(&self, claims: &mut Vec<Claim>) {
        let rate = |term: &str, index: usize| {
            self.reference()
                .map_or(Known::default(), |f| f.known(term, &[(index, 1.0)]))
        };
        let pose = rate(POSE_CLOCK, POSE_RATE);
        let gyro = rate(GYRO_CLOCK, GYRO_RATE);
        let wheels = self.drive.and(self.drive_fitted());
        let wheels = wheels.map_or(Known::default(), |f| f.known(CLOCK_TERM, &[(CLOCK, 1.0)]));
        let own: &[usize] = if self.is_wheels(Doubt::Clock) {
            &[POSE_RATE, GYRO_RATE, DRIVE_FIRST + CLOCK]
        } else {
            &[DRIVE_FIRST + CLOCK]
        };
        for (known, stream, index) in [
            (pose, "pose", &[POSE_RATE][..]),
            (gyro, "imu", &[GYRO_RATE]),
            (wheels, "wheels", own),
        ] {
            if known.needed {
                claims.push(self.drift(stream, known, index));
            }
        }
    }

    fn drift(&self, stream: &'static str, known: Known, toggles: &[usize]) -> Claim {
        Claim {
            word: Some(("stream", stream)),
            ..self.stamped("clock_drift", "rate", known, toggles)
        }
    }

    fn mounting(&self, claims: &mut Vec<Claim>) {
        let Some(fitted) = self.reference() else {
            return;
        };
        let (place, turn) = (fitted.kept(OFFSET), fitted.kept(OFFSET_TURN));
        if place.is_none() && turn.is_none() {
            return;
        }
        let x = fitted.known(OFFSET, &[(OFFSET_X, 1.0)]);
        let y = fitted.known(OFFSET, &[(OFFSET_Y, 1.0)]);
        let yaw = fitted.known(OFFSET_TURN, &[(OFFSET_YAW, 1.0)]);
        let strongest = if x.gain > yaw.gain { x } else { yaw };
        let parts = [("x_m", x), ("y_m", y), ("yaw_rad", yaw)];
        let needed = parts.into_iter().filter(|(_, known)| known.needed);
        let values = needed.map(|(name, known)| fitted.value(name, Scale::Plain, known));
        claims.push(Claim {
            gain: x.gain + yaw.gain,
            ..claim(
                "pose_offset",
                strongest,
                values,
                [OFFSET_X, OFFSET_Y, OFFSET_YAW],
            )
        });
    }

    /// Radii, slip, encoders, gains and track.
    fn sizes(&self, claims: &mut Vec<Claim>) {
        let gains = self.gains();
        let by_run = self.calibration.map_or([false; 2], |c| c.by_run);
        claims.extend(self.gain_claim(gains));
        let is_sized = |own: &Fitted<'_>| [GEOMETRY, FLOOR].iter().any(|n| own.kept(n).is_some());
        let Some(fitted) = self.reference().filter(is_sized) else {
            return;
        };
        if by_run[0] {
            self.slip_of_runs(&fitted, claims);
        } else {
            self.radii(&fitted, claims);
        }
        if by_run[1] {
            self.track_of_runs(&fitted, claims);
        }
    }

    /// Logarithms of what each wheel turns beyond its command.
    fn gains(&self) -> Option<[Known; 2]> {
        self.drive?;
        let fitted = self.drive_fitted()?;
        fitted.kept(GAIN_TERM)?;
        Some(
            [0.5, -0.5].map(|half| fitted.known(GAIN_TERM, &[(GAIN, 1.0), (GAIN_ASYMMETRY, half)])),
        )
    }

    /// A gain of the motors, or encoders that count wrong.
    fn gain_claim(&self, gains: Option<[Known; 2]>) -> Option<Claim> {
        let gains = gains?;
        let fitted = self.drive_fitted()?;
        let drive = [GAIN, GAIN_ASYMMETRY].map(|i| DRIVE_FIRST + i);
        let is_wheels = self.is_wheels(Doubt::Gain);
        let (effect, names, other) = if is_wheels {
            ("encoder_scale", ["right_scale", "left_scale"], "motor_gain")
        } else {
            ("motor_gain", ["right", "left"], "encoder_scale")
        };
        let values = names.into_iter().zip(gains);
        let values = values.map(|(name, known)| fitted.value(name, Scale::Factor, known));
        let mut claim = claim(effect, gains[0], values, drive);
        if is_wheels {
            claim.toggles.extend([COMMON, ASYMMETRY]);
        }
        claim.confused = self.doubtful(Doubt::Gain, other);
        let alike = self.alike(GAIN_TERM, "command_dead_zone");
        claim.confused.extend(alike.filter(|_| !is_wheels));
        Some(claim)
    }

    /// Wheel radius, encoders and track of the machine.
    fn radii(&self, fitted: &Fitted<'_>, claims: &mut Vec<Claim>) {
        let gyro_alone = !self.machine.has_pose();
        let asymmetry = fitted.known(GEOMETRY, &[(ASYMMETRY, 1.0)]);
        let track = fitted.known(GEOMETRY, &[(TRACK, 1.0)]);
        let wheels =
            [0.5, -0.5].map(|half| fitted.known(GEOMETRY, &[(COMMON, 1.0), (ASYMMETRY, half)]));
        let clear = wheels.iter().any(|wheel| fitted.is_clear(*wheel));
        if gyro_alone {
            self.turning(fitted, asymmetry, track, claims);
            return;
        }
        if clear && self.is_miscounted(&wheels) {
            claims.push(self.miscounted(fitted, &wheels));
        } else if clear {
            claims.push(self.wheel_radius(fitted, &wheels));
        }
        if !self.calibration.is_some_and(|c| c.by_run[1]) && fitted.is_clear(track) {
            claims.push(track_width(fitted, track, vec![TRACK]));
        }
    }

    /// Wheels whose size is far from the model's, with no command that tells them from encoders: no wheel is
    /// that much larger than its data, encoders and gears are.
    fn is_miscounted(&self, wheels: &[Known; 2]) -> bool {
        let far = |wheel: &Known| wheel.value.abs() > FAR.ln();
        self.drive.is_none() && !self.machine.is_commanded() && wheels.iter().any(far)
    }

    /// Encoders that count wrong, where the calibration alone shows it.
    fn miscounted(&self, fitted: &Fitted<'_>, wheels: &[Known; 2]) -> Claim {
        let values = ["right_scale", "left_scale"].into_iter().zip(wheels);
        let values = values.map(|(name, known)| {
            let counted = Known {
                value: -known.value,
                ..*known
            };
            fitted.value(name, Scale::Factor, counted)
        });
        let mut claim = claim("encoder_scale", wheels[0], values, [COMMON, ASYMMETRY]);
        claim.confused = vec!["wheel_radius"];
        claim
    }

    fn wheel_radius(&self, fitted: &Fitted<'_>, wheels: &[Known; 2]) -> Claim {
        let values = ["right_scale", "left_scale"].into_iter().zip(wheels);
        let values = values.map(|(name, known)| fitted.value(name, Scale::Factor, *known));
        let mut claim = claim("wheel_radius", wheels[0], values, [COMMON, ASYMMETRY]);
        claim.confused = vec!["slip_ratio"];
        if self.machine.is_commanded() {
            claim.confused.push("motor_gain");
        } else if self.drive.is_none() {
            claim.confused.push("encoder_scale");
        }
        claim
    }

    /// What a gyro alone shows of the geometry: turns.
    fn turning(
        &self,
        fitted: &Fitted<'_>,
        asymmetry: Known,
        track: Known,
        claims: &mut Vec<Claim>,
    ) {
        let drive: &[&'static str] = if self.machine.is_commanded() {
            &["motor_gain"]
        } else {
            &["encoder_scale"]
        };
        if fitted.is_clear(asymmetry) {
            // wheels that differ; a common factor of both and the track are one in turns
            let values = [("right_scale", 0.5), ("left_scale", -0.5)].map(|(name, half)| {
                let known = fitted.known(GEOMETRY, &[(ASYMMETRY, half), (TRACK, -1.0)]);
                fitted.value(name, Scale::Factor, known)
            });
            let mut claim = claim("wheel_radius", asymmetry, values, [ASYMMETRY, TRACK]);
            claim.confused = [&["slip_ratio"], drive].concat();
            claims.push(claim);
        } else if fitted.is_clear(track) {
            let mut claim = track_width(fitted, track, vec![TRACK, ASYMMETRY]);
            claim.confused = [&["wheel_radius"], drive].concat();
            claims.push(claim);
        }
    }

    /// One scale for every run: slip, which belongs to the floor.
    fn slip_of_runs(&self, fitted: &Fitted<'_>, claims: &mut Vec<Claim>) {
        let asymmetry = fitted.known(GEOMETRY, &[(ASYMMETRY, 1.0)]);
        for run in 0..self.machine.runs.len() {
            let index = self.machine.of_run(run, RUN_SCALE);
            let scale = fitted.known(fitted.of_floor(), &[(index, 1.0)]);
            if !fitted.is_clear(scale) {
                continue;
            }
            let mut ratio = fitted.value("ratio", Scale::Loss, scale);
            ratio.before = self.machine.offsets.get(run).map_or(0.0, |own| own[0]);
            let mut claim = claim("slip_ratio", scale, [ratio], [index, ASYMMETRY]);
            if fitted.is_clear(asymmetry) {
                let factor = -scale.value.exp();
                let change = factor * 2.0 * (asymmetry.value / 2.0).sinh();
                let half = -factor * fitted.half(asymmetry);
                claim
                    .values
                    .push(Value::new("asymmetry", Scale::Plain, change, half));
            }
            claim.runs = Some(vec![run]);
            claim.confused = vec!["wheel_radius"];
            claims.push(claim);
        }
    }

    fn track_of_runs(&self, fitted: &Fitted<'_>, claims: &mut Vec<Claim>) {
        for run in 0..self.machine.runs.len() {
            let index = self.machine.of_run(run, RUN_TRACK);
            let track = fitted.known(fitted.of_floor(), &[(index, 1.0)]);
            if !fitted.is_clear(track) {
                continue;
            }
            let mut claim = track_width(fitted, track, vec![index]);
            claim.values[0].before = self.machine.offsets.get(run).map_or(0.0, |own| own[1]);
            claim.runs = (self.machine.runs.len() > 1).then(|| vec![run]);
            claims.push(claim);
        }
    }

    /// What the catalogue does not have: a speed that follows the turn rate, or the speed.
    fn laws(&self, claims: &mut Vec<Claim>) {
        let Some(fitted) = self.reference() else {
            return;
        };
        for (place, name) in LAW_TERMS.into_iter().enumerate() {
            if fitted.kept(name).is_none() {
                continue;
            }
            let first = LAW_FIRST + place * VALUES[0];
            let own = first..first + VALUES[place];
            let mut claim = claim("unknown", fitted.known(name, &[]), [], own.clone());
            let knots = self.machine.knots[place];
            let changes: Vec<f64> = own.clone().map(|i| fitted.change(i)).collect();
            // values are linear in the parameters: the weights of each
            let parts: Vec<Vec<f64>> = (0..VALUES[place])
                .map(|k| {
                    let one: Vec<f64> = (0..VALUES[place])
                        .map(|i| f64::from(u8::from(i == k)))
                        .collect();
                    knots.values(&one).to_vec()
                })
                .collect();
            let half = (0..knots.places().len()).map(|value| {
                let weights: Vec<(usize, f64)> = own
                    .clone()
                    .zip(parts.iter().map(|part| part[value]))
                    .collect();
                fitted.half(fitted.known(name, &weights))
            });
            claim.law = Some(Law {
                driver: DRIVERS[place],
                knots: knots.places(),
                values: knots.values(&changes).to_vec(),
                half: half.collect(),
            });
            claims.push(claim);
        }
    }

    /// What the drive does with its commands, but for delay and gain.
    fn commands(&self, claims: &mut Vec<Claim>) {
        let Some(fitted) = self.drive_fitted() else {
            return;
        };
        let list = [
            (LAG_TERM, "actuator_lag", "time_constant_s", LAG),
            (ZONE_TERM, "command_dead_zone", "speed_rad_s", DEAD_ZONE),
            (
                SATURATION_TERM,
                "command_saturation",
                "speed_rad_s",
                SATURATION,
            ),
            (SAG_TERM, "supply_sag", "rate_per_s", SAG),
        ];
        for (term, effect, name, parameter) in list {
            let mut known = fitted.known(term, &[(self.of_drive(parameter), 1.0)]);
            if !known.needed {
                continue;
            }
            if term == ZONE_TERM && self.is_wheels(Doubt::Gain) {
                // the loss counts behind the encoders, which count it wrong as well
                let gain = fitted.known(GAIN_TERM, &[(self.of_drive(GAIN), 1.0)]);
                known.value -= self.nominal[DRIVE_FIRST + DEAD_ZONE] * gain.value.exp_m1();
                if known.value.abs() < ALIKE * known.deviation {
                    continue;
                }
            }
            if term == LAG_TERM {
                // only its size is meant
                let total = known.value + self.nominal[DRIVE_FIRST + LAG];
                known.value = total.abs() - self.nominal[DRIVE_FIRST + LAG];
            }
            let value = fitted.value(name, Scale::Plain, known);
            let mut claim = claim(effect, known, [value], [DRIVE_FIRST + parameter]);
            if term == LAG_TERM {
                claim
                    .confused
                    .extend(self.alike(LAG_TERM, "actuator_delay"));
            }
            if term == ZONE_TERM {
                claim.confused.extend(self.alike(ZONE_TERM, "motor_gain"));
            }
            claims.push(claim);
        }
        if let Some(kept) = fitted.kept(BAND_TERM) {
            claims.push(self.dead_band(&fitted, kept));
        }
    }

    fn dead_band(&self, fitted: &Fitted<'_>, kept: &Kept) -> Claim {
        let known = fitted.known(BAND_TERM, &[(self.of_drive(DEAD_BAND), 1.0)]);
        let [low, high] = self.band_rad_s();
        let at = known.value + self.nominal[DRIVE_FIRST + DEAD_BAND];
        let value = Value {
            name: "speed_rad_s",
            scale: Scale::Plain,
            change: known.value,
            half: [at - low, high - at],
            before: 0.0,
            halves: None,
        };
        Claim {
            p_value: (fitted.criterion.tried as f64 * (-kept.gain).exp()).min(1.0),
            ..claim(
                "command_dead_band",
                known,
                [value],
                [DRIVE_FIRST + DEAD_BAND],
            )
        }
    }

    fn band_rad_s(&self) -> [f64; 2] {
        match (self.drive, self.calibration) {
            (Some(drive), _) => drive.band_rad_s,
            (None, Some(calibration)) => calibration.band_rad_s,
            (None, None) => [0.0; 2],
        }
    }

    /// The parameters of the machine with everything that was found.
    pub(crate) fn fitted(&self) -> Vec<f64> {
        let mut at = match self.calibration {
            Some(calibration) => calibration.after.fit.at.clone(),
            None => self.nominal.to_vec(),
        };
        if let Some(drive) = self.drive {
            at[DRIVE_FIRST..LAW_FIRST].copy_from_slice(&drive.after.fit.at[..DRIVE]);
        }
        at
    }
}

fn claim(
    effect: &'static str,
    known: Known,
    values: impl IntoIterator<Item = Value>,
    toggles: impl IntoIterator<Item = usize>,
) -> Claim {
    Claim {
        effect,
        values: values.into_iter().collect(),
        word: None,
        runs: None,
        toggles: toggles.into_iter().collect(),
        gain: known.gain,
        p_value: known.p_value,
        confused: Vec::new(),
        law: None,
    }
}

fn track_width(fitted: &Fitted<'_>, track: Known, toggles: Vec<usize>) -> Claim {
    let scale = fitted.value("scale", Scale::Factor, track);
    claim("track_width", track, [scale], toggles)
}

/// Several signed measurements of one number, weighted by their precision.
fn together(all: &[(f64, Known)]) -> Known {
    let weight = |known: &Known| known.deviation.max(1e-9).powi(-2);
    let sum: f64 = all.iter().map(|(_, known)| weight(known)).sum();
    let value = all
        .iter()
        .map(|(sign, known)| sign * known.value * weight(known))
        .sum::<f64>()
        / sum;
    Known {
        value,
        deviation: sum.sqrt().recip(),
        needed: true,
        gain: all.iter().map(|(_, known)| known.gain).sum(),
        p_value: all
            .iter()
            .map(|(_, known)| known.p_value)
            .fold(1.0, f64::min),
        difference: None,
    }
}

fn alike(value: f64, deviation: f64, common: Known, floor: f64) -> bool {
    let width = (deviation * deviation + common.deviation * common.deviation).sqrt();
    (value - common.value).abs() < ALIKE * width + floor
}
