//! Hypotheses: effects that the model may lack, or have with other numbers, each with values to
//! start from.

use slipstream_bus::{EffectSpec, InputError, Parameter, RobotModel};
use slipstream_sim::effects::{
    CATALOGUE, Channel, Domain, Info, ModelSite, ParameterInfo, Role, When, find,
};
use slipstream_sim::{CommandKind, Stream};

use crate::data::command::asked;
use crate::data::track::{Sensor, Series, Track};
use crate::filter::wrapped;

/// One effect at the values from which a fit begins, or at which it ended.
#[derive(Debug, Clone)]
pub(crate) struct Hypothesis {
    pub(crate) info: &'static Info,
    /// The parameters that are fitted.
    pub(crate) values: Vec<(&'static str, f64)>,
    /// A parameter that is a word, and the word.
    pub(crate) text: Option<(&'static str, &'static str)>,
    /// The model's own effect that this one stands for with other numbers.
    pub(crate) replaces: Option<usize>,
    /// It holds in runs of today alone, where these are compared with runs from before.
    pub(crate) since: bool,
}

impl Hypothesis {
    pub(crate) fn new(info: &'static Info, values: Vec<(&'static str, f64)>) -> Self {
        Self {
            info,
            values,
            text: None,
            replaces: None,
            since: false,
        }
    }

    /// As a model lists it.
    pub(crate) fn spec(&self) -> EffectSpec {
        let mut spec = EffectSpec::new(self.info.id, &self.values);
        if let Some((name, word)) = self.text {
            spec.parameters
                .push((name.to_owned(), Parameter::Text(word.to_owned())));
        }
        spec
    }

    /// Whether both say the same of the robot, in whatever numbers.
    pub(crate) fn is_like(&self, other: &Self) -> bool {
        self.is_of(other) && self.since == other.since
    }

    /// Whether both are of the same effect.
    pub(crate) fn is_of(&self, other: &Self) -> bool {
        self.info.id == other.info.id && self.text == other.text
    }

    /// Of a change, what runs from before have of the same effect.
    pub(crate) fn counterpart(&self, among: &[Self]) -> Option<usize> {
        let same = |own: &Self| !own.since && own.is_of(self);
        among.iter().position(same).filter(|_| self.since)
    }

    /// The value at which a parameter does nothing: 1 for a factor, the model's for what it has.
    pub(crate) fn nothing(&self, model: &RobotModel, name: &str) -> f64 {
        let factor = self.info.parameter(name).is_some_and(is_factor);
        self.nominal(model, name)
            .unwrap_or(if factor { 1.0 } else { 0.0 })
    }

    /// The model's value of a parameter, where the model has the effect.
    pub(crate) fn nominal(&self, model: &RobotModel, name: &str) -> Option<f64> {
        let listed = &model.effects[self.replaces?];
        listed
            .parameters
            .iter()
            .find_map(|(known, value)| match value {
                Parameter::Number(number) if known == name => Some(*number),
                _ => None,
            })
    }

    /// Static friction is not below kinetic friction.
    pub(crate) fn keep_in_order(&mut self) {
        if let (Some(above), Some(below)) = (self.value(STATIC), self.value(KINETIC)) {
            self.set(STATIC, above.max(below));
        }
    }

    /// Whether it changes little by little nowhere: a friction that is far off says nothing of which
    /// way the true one lies.
    pub(crate) fn is_abrupt(&self) -> bool {
        self.replaces.is_none() && self.info.acts == When::Sliding
    }

    /// Whether it has a place or a time that is searched.
    pub(crate) fn is_local(&self) -> bool {
        is_local(self.info)
    }

    /// Whether it acts at one place alone.
    pub(crate) fn is_placed(&self) -> bool {
        self.info.acts == When::Inside
    }

    /// Whether it acts once, for a moment.
    pub(crate) fn is_momentary(&self) -> bool {
        self.info.acts == When::Once
    }

    /// Whether gears come apart by it.
    pub(crate) fn has_play(&self) -> bool {
        self.info.acts == When::Apart
    }

    /// The value of a parameter, where it has one of that name.
    pub(crate) fn value(&self, name: &str) -> Option<f64> {
        let mut values = self.values.iter();
        values.find(|(known, _)| *known == name).map(|v| v.1)
    }

    /// Sets a parameter of that name, where it has one.
    pub(crate) fn set(&mut self, name: &str, value: f64) {
        let mut values = self.values.iter_mut();
        if let Some(own) = values.find(|(known, _)| *known == name) {
            own.1 = value;
        }
    }

    /// Whether its size is found by trying values one by one: a threshold on commands of which
    /// there are only so many has no derivative.
    pub(crate) fn is_threshold(&self) -> bool {
        self.info.acts == When::Below
    }
}

/// A value of a parameter within its first turn, where it is a direction: one that comes round again
/// has no bounds to be held by.
pub(crate) fn come_round(info: &Info, name: &str, value: f64) -> f64 {
    if comes_round(info, name) {
        wrapped(value)
    } else {
        value
    }
}

/// The nominal model with `hypotheses`, in place of its own effects where they say so.
pub(crate) fn with(model: &RobotModel, hypotheses: &[Hypothesis]) -> RobotModel {
    let mut better = model.clone();
    for hypothesis in hypotheses {
        match hypothesis.replaces {
            Some(at) => better.effects[at] = hypothesis.spec(),
            None => better.effects.push(hypothesis.spec()),
        }
    }
    better
}

/// The hypotheses that hold in runs of today, or in those from before.
pub(crate) fn in_force(hypotheses: &[Hypothesis], today: bool) -> Vec<Hypothesis> {
    let replaced = |own: &Hypothesis| hypotheses.iter().any(|h| h.since && h.is_of(own));
    let holds = |own: &&Hypothesis| {
        if today {
            own.since || !replaced(own)
        } else {
            !own.since
        }
    };
    hypotheses.iter().filter(holds).cloned().collect()
}

/// Whether an effect does less the larger it is, and nothing at all from some size on.
pub(crate) fn is_limit(info: &Info) -> bool {
    info.acts == When::Above
}

/// Whether wheels may slide by an effect.
pub(crate) fn slides(info: &Info) -> bool {
    matches!(info.acts, When::Sliding | When::Inside)
}

/// Whether what becomes of a command depends on time, or on the commands before.
pub(crate) fn changes_commands_over_time(info: &Info) -> bool {
    let by_factors = info.parameters.iter().all(is_factor);
    info.site == ModelSite::Command && info.acts == When::Always && !by_factors
}

/// Effects at one time or place: where they are is searched.
pub(crate) fn momentary_and_placed() -> impl Iterator<Item = Hypothesis> {
    let own = CATALOGUE.iter().filter(|info| is_local(info));
    own.map(|info| {
        let numbers = info.parameters.iter().filter(|p| !p.alternative);
        let begun = |p: &ParameterInfo| (p.name, probes(p).first().copied().unwrap_or(0.0));
        Hypothesis::new(info, numbers.map(begun).collect())
    })
}

/// Whether an effect has a place or a time that is searched.
fn is_local(info: &Info) -> bool {
    matches!(info.acts, When::Inside | When::Once)
}

/// How many of an effect's numbers say how large it is: the first alone, where others say where a mass
/// lies or which way is down.
pub(crate) fn sizes_of(info: &Info) -> usize {
    if info.parameters.iter().any(is_mass) || points_downhill(info) {
        1
    } else {
        info.parameters.len()
    }
}

fn is_mass(parameter: &ParameterInfo) -> bool {
    parameter.role == Role::Mass
}

/// Whether what an effect does depends on where the robot is or which way it faces.
pub(crate) fn is_bound_to_place(info: &Info) -> bool {
    is_local(info) || points_downhill(info)
}

/// Whether it is a matter of which way is down.
pub(crate) fn points_downhill(info: &Info) -> bool {
    let mut parameters = info.parameters.iter();
    info.acts == When::Always && parameters.any(|p| is_direction(info, p.name))
}

/// Whether a parameter is a direction on the floor, not one in which a sensor looks.
pub(crate) fn is_direction(info: &Info, name: &str) -> bool {
    comes_round(info, name) && info.site != ModelSite::Sensor
}

/// Whether a parameter may take any angle.
fn comes_round(info: &Info, name: &str) -> bool {
    info.parameter(name)
        .is_some_and(|p| p.role == Role::Direction)
}

fn is_factor(parameter: &ParameterInfo) -> bool {
    parameter.role == Role::Factor
}

/// Friction's two coefficients, of which the first is not below the second.
pub(crate) const STATIC: &str = "friction_static";
pub(crate) const KINETIC: &str = "friction_kinetic";

/// Effects that this engine takes as a model lists them: it has no means to tell them from their
/// look-alikes (a radius, a force without a name).
const NOT_TRIED: [&str; 3] = ["slip_ratio", "force_law", "motion_law"];
/// The same under torques: a dead zone of torques is the friction of an axle, but for wheels that coast.
const NOT_OF_TORQUES: &str = "command_dead_zone";

/// All hypotheses that `model` can express and `tracks` can show, without `excluded`.
pub(crate) fn all(model: &RobotModel, tracks: &[Track], excluded: &[String]) -> Vec<Hypothesis> {
    let Some(track) = tracks.first() else {
        return Vec::new();
    };
    let able = |info: &&Info| {
        // what links do several robots show together
        let search = !is_local(info) && info.site != ModelSite::Link;
        let left_out = NOT_TRIED.contains(&info.id)
            || info.id == NOT_OF_TORQUES && track.kind() == CommandKind::Torque
            || excluded.iter().any(|id| id == info.id);
        search && !left_out && shows(info, track)
    };
    let fresh = CATALOGUE
        .iter()
        .filter(able)
        .flat_map(|info| of(info, track, model))
        .filter(|h| has_stream(h, track))
        .filter(|h| is_new(h, model) && expressible(model, h, track.kind()).is_ok());
    fresh.chain(listed(model, excluded)).collect()
}

/// Hypotheses that say the same in other numbers, together; the kinds in the order of their first.
pub(crate) fn kinds<'a>(all: impl IntoIterator<Item = &'a Hypothesis>) -> Vec<Vec<&'a Hypothesis>> {
    let mut kinds: Vec<Vec<&Hypothesis>> = Vec::new();
    for hypothesis in all {
        match kinds.iter_mut().find(|kind| kind[0].is_like(hypothesis)) {
            Some(kind) => kind.push(hypothesis),
            None => kinds.push(vec![hypothesis]),
        }
    }
    kinds
}

/// Whether a track has the sensors and the drive in which an effect shows.
fn shows(info: &Info, track: &Track) -> bool {
    let has = |sensor| track.of(sensor).is_some();
    let wheels = has(Sensor::WheelAngle) || has(Sensor::WheelSpeed) || has(Sensor::Odometry);
    info.channels.iter().any(|channel| match channel {
        Channel::SensorPose => has(Sensor::Pose),
        Channel::SensorWheels => wheels,
        Channel::SensorImu => has(Sensor::Imu),
        _ => true,
    })
}

/// Whether a track has the stream that a hypothesis names; one without a name needs none.
fn has_stream(hypothesis: &Hypothesis, track: &Track) -> bool {
    let Some(("stream", word)) = hypothesis.text else {
        return true;
    };
    let named = |series: &Series| match series.sensor.clock() {
        Stream::Wheels => word == "wheels",
        Stream::Pose => word == "pose",
        Stream::Imu => word == "imu",
    };
    track.series.iter().any(named)
}

/// Whether an effect can be had beside those of the model.
fn is_new(hypothesis: &Hypothesis, model: &RobotModel) -> bool {
    let mut listed = model.effects.iter();
    hypothesis.info.repeats && hypothesis.text.is_none()
        || !listed.any(|listed| listed.effect == hypothesis.info.id)
}

/// The model's own effects with other numbers.
fn listed(model: &RobotModel, excluded: &[String]) -> Vec<Hypothesis> {
    let listed = model.effects.iter().enumerate();
    let known = listed.filter_map(|(i, spec)| Some((i, spec, find(&spec.effect)?)));
    known
        .filter(|(_, _, info)| !NOT_TRIED.contains(&info.id) && info.id != NOT_OF_TORQUES)
        .filter(|(_, _, info)| !excluded.iter().any(|id| id == info.id))
        .map(|(i, spec, info)| {
            let numbers = info.parameters.iter().filter_map(|p| {
                let own = spec.parameters.iter().find(|(name, _)| name == p.name)?;
                match own.1 {
                    Parameter::Number(number) => Some((p.name, number)),
                    Parameter::Text(_) | Parameter::List(_) => None,
                }
            });
            let text = info.parameters.iter().find_map(|p| {
                let own = spec.parameters.iter().find(|(name, _)| name == p.name)?;
                match (&own.1, p.domain) {
                    (Parameter::Text(word), Domain::Text(words)) => {
                        let word = words.iter().find(|known| *known == word)?;
                        Some((p.name, *word))
                    }
                    _ => None,
                }
            });
            Hypothesis {
                info,
                values: numbers.collect(),
                text,
                replaces: Some(i),
                since: false,
            }
        })
        .filter(|h| !h.values.is_empty())
        .collect()
}

/// Whether a robot of the model with this effect can be built, and moves by it.
fn expressible(
    model: &RobotModel,
    hypothesis: &Hypothesis,
    kind: CommandKind,
) -> Result<(), InputError> {
    let mut model = model.clone();
    model.effects.push(hypothesis.spec());
    slipstream_sim::Robot::new(&model)?.accepts(kind)
}

fn of(info: &'static Info, track: &Track, model: &RobotModel) -> Vec<Hypothesis> {
    let kind = track.kind();
    let by_volts = info.parameter("voltage_v").is_some();
    let fits = |parameter: &&ParameterInfo| {
        let own = match kind {
            CommandKind::Speed => "speed_rad_s",
            CommandKind::Voltage if by_volts => "voltage_v",
            _ => "torque_nm",
        };
        !parameter.alternative || parameter.name == own
    };
    let numbers: Vec<&'static ParameterInfo> = info.parameters.iter().filter(fits).collect();
    let words: Vec<Option<(&str, &str)>> = info
        .parameters
        .iter()
        .find_map(|p| match p.domain {
            Domain::Text(words) => Some(words.iter().map(|w| Some((p.name, *w))).collect()),
            Domain::Number { .. } | Domain::List { .. } => None,
        })
        .unwrap_or_else(|| vec![None]);
    starts(info, &numbers, track, model)
        .into_iter()
        .flat_map(|values| {
            words.iter().map(move |&text| Hypothesis {
                text,
                ..Hypothesis::new(info, values.clone())
            })
        })
        .collect()
}

fn probes(p: &ParameterInfo) -> &'static [f64] {
    match p.domain {
        Domain::Number { probes, .. } => probes,
        Domain::Text(_) | Domain::List { .. } => &[],
    }
}

/// Values to start from: a friction from all that there are, limits of the command from what is
/// commanded, one number from each of its probes, and several from one value each, whichever way is
/// down.
fn starts(
    info: &Info,
    numbers: &[&'static ParameterInfo],
    track: &Track,
    model: &RobotModel,
) -> Vec<Vec<(&'static str, f64)>> {
    let numbers: Vec<&&ParameterInfo> = numbers.iter().filter(|p| !probes(p).is_empty()).collect();
    if numbers.is_empty() {
        return Vec::new();
    }
    let of_all = |value: f64| numbers.iter().map(|p| (p.name, value)).collect();
    let alone = |values: &[f64]| values.iter().copied().map(of_all).collect();
    match info.acts {
        When::Sliding => frictions().map(of_all).collect(),
        When::Below => {
            let mut probes = sizes(track, model, &DEAD_BANDS);
            // or nothing that was commanded does anything
            probes.extend(all_sizes(track, model).last().map(|most| BEYOND * most));
            alone(&probes)
        }
        When::Above => alone(&sizes(track, model, &SATURATIONS)),
        _ if numbers.len() == 1 && !is_factor(numbers[0]) => alone(probes(numbers[0])),
        _ => {
            let begun = |p: &&&ParameterInfo| (p.name, begun(p, model));
            let start: Vec<(&str, f64)> = numbers.iter().map(begun).collect();
            let Some(way) = numbers.iter().position(|p| is_direction(info, p.name)) else {
                return vec![start];
            };
            let towards = |&down: &f64| {
                let mut start = start.clone();
                start[way].1 = down;
                start
            };
            probes(numbers[way]).iter().map(towards).collect()
        }
    }
}

/// Where one number of several begins: a factor at 1, what lies on either side of 0 there, a load at a
/// share of the body's mass, all else at its first probe.
fn begun(parameter: &ParameterInfo, model: &RobotModel) -> f64 {
    let probes = probes(parameter);
    if is_factor(parameter) {
        1.0
    } else if is_mass(parameter) {
        // how a load shows where it lies is a product of both: neither may be small
        LOAD * model.robot.body_mass_kg.unwrap_or(1.0)
    } else if probes.iter().any(|p| *p < 0.0) {
        0.0
    } else {
        probes[0]
    }
}

/// Share of the body's mass at which a load begins.
const LOAD: f64 = 0.1;

/// Frictions from which a fit begins, large to small: rubber on a clean floor to wet ice. One that is a
/// tenth off may already fit worse than none.
fn frictions() -> impl Iterator<Item = f64> {
    std::iter::successors(Some(1.0), |friction| Some(friction / 1.1)).take_while(|f| *f > 0.02)
}

/// Shares of the sizes that are commanded that lie within a dead band to begin with: what a small one
/// swallows to and fro adds up to little, so that only one close to it shows.
const DEAD_BANDS: [f64; 20] = [
    0.01, 0.02, 0.03, 0.04, 0.05, 0.06, 0.07, 0.085, 0.1, 0.12, 0.14, 0.17, 0.2, 0.24, 0.29, 0.35,
    0.42, 0.5, 0.6, 0.7,
];

/// Shares of the sizes that are commanded that are not cut to begin with: all but the largest, where
/// that is all that is.
const SATURATIONS: [f64; 8] = [0.3, 0.5, 0.6, 0.7, 0.8, 0.9, 0.97, 1.0];

/// A threshold above all commands, over the largest of them.
const BEYOND: f64 = 1.05;

/// Sizes of what is commanded at the wheels, at these shares of all that are not zero.
fn sizes(track: &Track, model: &RobotModel, shares: &[f64]) -> Vec<f64> {
    let sizes = all_sizes(track, model);
    let at = |share: &f64| {
        let last = sizes.len().checked_sub(1)?;
        Some(sizes[(share * last as f64) as usize] * (1.0 - 1e-6))
    };
    let mut list: Vec<f64> = shares.iter().filter_map(at).collect();
    list.dedup();
    list
}

/// The threshold between the commands of sizes `at - 1` and `at`.
pub(crate) fn threshold(sizes: &[f64], at: usize) -> f64 {
    let below = at.checked_sub(1).map_or(0.0, |below| sizes[below]);
    let above = sizes
        .get(at)
        .map_or((2.0 * BEYOND - 1.0) * below, |above| *above);
    0.5 * (below + above)
}

/// All sizes that are commanded at a wheel, small to large, in the unit of the limits of effects:
/// N m or rad/s.
pub(crate) fn all_sizes(track: &Track, model: &RobotModel) -> Vec<f64> {
    let per_volt = model
        .motor
        .as_ref()
        .map_or(1.0, |m| m.stall_torque_nm / m.nominal_voltage_v);
    let unit = if track.kind() == CommandKind::Voltage {
        per_volt
    } else {
        1.0
    };
    let [r, b] = [model.robot.wheel_radius_m, model.robot.half_track_m];
    let asked = track
        .commands
        .iter()
        .flat_map(|(_, command)| asked(command, r, b));
    let mut sizes: Vec<f64> = asked.map(|v| v.abs() * unit).filter(|v| *v > 0.0).collect();
    sizes.sort_by(f64::total_cmp);
    sizes.dedup();
    sizes
}
