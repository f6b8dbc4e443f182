//! What may be left out: one effect of the catalogue at one set of first values.

use slipstream_bus::{EffectSpec, ModelError, Parameter, RobotModel};
use slipstream_sim::effects::{CATALOGUE, Domain, Info, ParameterInfo};
use slipstream_sim::{Command, CommandKind};

/// An effect and the values from which its fit starts.
#[derive(Debug, Clone)]
pub(crate) struct Hypothesis {
    pub(crate) info: &'static Info,
    pub(crate) values: Vec<(&'static str, f64)>,
    pub(crate) text: Option<(&'static str, &'static str)>,
}

impl Hypothesis {
    /// As a model lists it.
    pub(crate) fn spec(&self) -> EffectSpec {
        let mut spec = EffectSpec::new(self.info.id, &self.values);
        if let Some((name, word)) = self.text {
            spec.parameters
                .push((name.to_owned(), Parameter::Text(word.to_owned())));
        }
        spec
    }

    /// Whether an effect of the model is this one: a second cannot be found.
    fn is_listed(&self, model: &RobotModel) -> bool {
        model
            .effects
            .iter()
            .any(|listed| listed.effect == self.info.id)
    }
}

/// Effects that need a search over place or time of their own, which this search does not make.
const LOCAL: [&str; 2] = ["friction_patch", "push"];

/// Effects that show only where there is an inertial sensor or a link.
const ELSEWHERE: [&str; 2] = ["imu_latency", "link_delay"];

/// All hypotheses that `model` can express and commands of this kind can show, without `excluded`.
pub(crate) fn all(model: &RobotModel, command: &Command, excluded: &[String]) -> Vec<Hypothesis> {
    let kind = match command {
        Command::Torque { .. } => CommandKind::Torque,
        Command::Voltage { .. } => CommandKind::Voltage,
        Command::Speed { .. } | Command::Twist { .. } => CommandKind::Speed,
    };
    let able = |info: &&Info| {
        let search = !LOCAL.contains(&info.id) && !ELSEWHERE.contains(&info.id);
        search && !excluded.iter().any(|id| id == info.id)
    };
    let hypotheses = CATALOGUE
        .iter()
        .filter(able)
        .flat_map(|info| of(info, kind));
    hypotheses
        .filter(|h| !h.is_listed(model) && expressible(model, h, kind).is_ok())
        .collect()
}

/// Whether a robot of the model with this effect can be built, and moves by it.
fn expressible(
    model: &RobotModel,
    hypothesis: &Hypothesis,
    kind: CommandKind,
) -> Result<(), ModelError> {
    let mut model = model.clone();
    model.effects.push(hypothesis.spec());
    slipstream_sim::Robot::new(&model)?.accepts(kind)
}

fn of(info: &'static Info, kind: CommandKind) -> Vec<Hypothesis> {
    let fits = |parameter: &&ParameterInfo| {
        let speed = parameter.name == "speed_rad_s";
        !parameter.alternative || speed == (kind == CommandKind::Speed)
    };
    let numbers: Vec<&ParameterInfo> = info.parameters.iter().filter(fits).collect();
    let words: Vec<Option<(&str, &str)>> = info
        .parameters
        .iter()
        .find_map(|p| match p.domain {
            Domain::Text(words) => Some(words.iter().map(|w| Some((p.name, *w))).collect()),
            Domain::Number { .. } => None,
        })
        .unwrap_or_else(|| vec![None]);
    starts(info, &numbers)
        .into_iter()
        .flat_map(|values| {
            words.iter().map(move |&text| Hypothesis {
                info,
                values: values.clone(),
                text,
            })
        })
        .collect()
}

/// Values to start from: factors from 1, places and offsets from 0, everything else from each of
/// its probes; two parameters of one scale together.
fn starts(info: &Info, numbers: &[&'static ParameterInfo]) -> Vec<Vec<(&'static str, f64)>> {
    let probes = |p: &ParameterInfo| match p.domain {
        Domain::Number { probes, .. } => probes,
        Domain::Text(_) => &[],
    };
    let numbers: Vec<&&ParameterInfo> = numbers.iter().filter(|p| !probes(p).is_empty()).collect();
    let is_factor = |p: &ParameterInfo| {
        p.unit == "1" && p.name.ends_with("scale") || p.name == "right" || p.name == "left"
    };
    if numbers.iter().all(|p| is_factor(p)) {
        return vec![numbers.iter().map(|p| (p.name, 1.0)).collect()];
    }
    match info.id {
        "wheel_slip" => probes(numbers[0])
            .iter()
            .map(|&friction| numbers.iter().map(|p| (p.name, friction)).collect())
            .collect(),
        "floor_slope" => probes(numbers[1])
            .iter()
            .map(|&downhill| {
                vec![
                    (numbers[0].name, probes(numbers[0])[0]),
                    (numbers[1].name, downhill),
                ]
            })
            .collect(),
        "payload" => vec![
            numbers
                .iter()
                .enumerate()
                .map(|(i, p)| (p.name, if i == 0 { probes(p)[1] } else { 0.0 }))
                .collect(),
        ],
        "pose_offset" => vec![numbers.iter().map(|p| (p.name, 0.0)).collect()],
        _ => probes(numbers[0])
            .iter()
            .map(|&probe| vec![(numbers[0].name, probe)])
            .collect(),
    }
}
