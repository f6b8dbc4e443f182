//! A claim: one effect of the catalogue with the sizes that it has beyond the nominal model.

use slipstream_bus::{EffectSpec, Parameter, RobotModel};
use slipstream_sim::effects::{Domain, find};

use crate::answer::shape::resemblance;
use crate::estimate::term::Link;
use crate::filter::motion_law::Table;

/// Factors that wheels and encoders have without a mistake.
const USUAL_FACTOR: f64 = 2.0;
/// A factor beyond that is one where it is known this well (half width of the interval of its logarithm):
/// streams that hardly follow each other do not tell it to 1 %.
const KNOWN_FACTOR: f64 = 0.01;

/// The change of one parameter.
#[derive(Debug, Clone)]
pub(crate) struct Value {
    pub(crate) name: &'static str,
    pub(crate) link: Link,
    pub(crate) change: f64,
    /// Half widths of its 95 % interval, below and above.
    pub(crate) half: [f64; 2],
    /// How far a run was from the nominal value before, as a change.
    pub(crate) before: f64,
    /// What the first and the second half say, as changes, where they differ.
    pub(crate) halves: Option<[f64; 2]>,
}

/// One effect.
#[derive(Debug, Clone)]
pub(crate) struct Claim {
    pub(crate) effect: &'static str,
    pub(crate) values: Vec<Value>,
    pub(crate) word: Option<(&'static str, &'static str)>,
    /// Runs for which it holds; all without it.
    pub(crate) runs: Option<Vec<usize>>,
    /// Fitted parameters that it explains.
    pub(crate) toggles: Vec<usize>,
    pub(crate) gain: f64,
    pub(crate) p_value: f64,
    pub(crate) confused: Vec<&'static str>,
    /// Of what the catalogue does not have: a table.
    pub(crate) law: Option<Law>,
}

/// A speed (m/s) or a turn rate (rad/s) as a table over a driver.
#[derive(Debug, Clone)]
pub(crate) struct Law {
    pub(crate) table: Table,
    pub(crate) knots: Vec<f64>,
    pub(crate) values: Vec<f64>,
    /// Half widths of their 95 % intervals.
    pub(crate) half: Vec<f64>,
}

impl Law {
    /// What it looks like, in words.
    pub(crate) fn shape(&self) -> String {
        let (name, unit) = match self.table.driver {
            "w" => ("turn rate", "rad/s"),
            _ => ("speed", "m/s"),
        };
        let (what, of) = self.quantity();
        let pairs = self.knots.iter().zip(&self.values);
        let extreme = |sign: f64| {
            let own = pairs.clone().filter(|(knot, _)| **knot * sign > 0.0);
            own.max_by(|a, b| a.1.abs().total_cmp(&b.1.abs()))
        };
        let words: Vec<String> = [-1.0, 1.0]
            .into_iter()
            .filter_map(extreme)
            .map(|(knot, value)| format!("{value:+.3} {of} at {knot:+.2} {unit}"))
            .collect();
        // shapes have the names of losses of speed
        let near = resemblance(self.table.driver, &self.knots, &self.values)
            .filter(|_| self.table.acts_on == "speed");
        format!(
            "{what} that depends on the {name}: {}{}",
            words.join(", "),
            near.map_or(String::new(), |near| format!("; {near}"))
        )
    }

    /// What it adds, and the unit of that.
    pub(crate) fn quantity(&self) -> (&'static str, &'static str) {
        match self.table.acts_on {
            "turn_rate" => ("turn rate beside that of the track", "rad/s"),
            _ => ("forward speed", "m/s"),
        }
    }

    /// As a model lists it.
    fn spec(&self) -> EffectSpec {
        let mut spec = EffectSpec::new("motion_law", &[]);
        let text = |word: &str| Parameter::Text(word.to_owned());
        spec.parameters = vec![
            ("acts_on".to_owned(), text(self.table.acts_on)),
            ("driver".to_owned(), text(self.table.driver)),
            ("knots".to_owned(), Parameter::List(self.knots.clone())),
            ("values".to_owned(), Parameter::List(self.values.clone())),
        ];
        spec
    }
}

impl Value {
    pub(crate) fn new(name: &'static str, link: Link, change: f64, half: f64) -> Self {
        Self {
            name,
            link,
            change,
            half: [half; 2],
            before: 0.0,
            halves: None,
        }
    }

    /// The same change seen from the other side: what was below is above.
    pub(crate) fn negate(&mut self) {
        self.change = -self.change;
        self.half.reverse();
        self.halves = self.halves.map(|own| own.map(|half| -half));
    }

    /// What the change makes of a nominal value.
    pub(crate) fn applied(&self, nominal: Option<f64>, change: f64) -> f64 {
        match self.link {
            Link::Identity => nominal.unwrap_or(0.0) + change,
            Link::Log => nominal.unwrap_or(1.0) * change.exp(),
            Link::LogLoss => 1.0 - (1.0 - nominal.unwrap_or(0.0)) * change.exp(),
        }
    }

    pub(crate) fn estimate(&self, nominal: Option<f64>) -> f64 {
        self.applied(nominal, self.change)
    }

    /// Whether it is no factor, or one that robots have.
    fn is_usual(&self) -> bool {
        self.link != Link::Log || self.change.abs() <= USUAL_FACTOR.ln()
    }

    /// Whether it is a factor that is known well.
    fn is_known(&self) -> bool {
        self.half[0].max(self.half[1]) < KNOWN_FACTOR
    }

    pub(crate) fn interval(&self, nominal: Option<f64>) -> [f64; 2] {
        let [below, above] = self.half;
        let [a, b] = [self.change - below, self.change + above].map(|c| self.applied(nominal, c));
        [a.min(b), a.max(b)]
    }
}

impl Claim {
    /// Whether the halves of the recordings tell different changes: the smaller is below half of the larger, or
    /// has the other sign.
    pub(crate) fn is_disputed(&self) -> bool {
        let disputed = |value: &Value| {
            value.halves.is_some_and(|[a, b]| {
                let [small, large] = if a.abs() < b.abs() { [a, b] } else { [b, a] };
                small / large < 0.5
            })
        };
        !self.values.is_empty() && self.values.iter().all(disputed)
    }

    /// Whether its sizes are what the catalogue calls plausible.
    pub(crate) fn is_plausible(&self, model: &RobotModel) -> bool {
        let Some(info) = find(self.effect) else {
            return true;
        };
        // a floor may make any track of skid steering
        let of_wheels = ["wheel_radius", "encoder_scale"].contains(&self.effect);
        self.values.iter().all(|value| {
            let estimate = value.estimate(self.nominal(model, value.name));
            match info.parameter(value.name).map(|own| own.domain) {
                Some(Domain::Number { lower, upper, .. }) => {
                    let sure = !of_wheels || value.is_usual() || value.is_known();
                    (lower..=upper).contains(&estimate) && sure
                }
                _ => true,
            }
        })
    }

    /// The nominal value of a parameter; of a drift, that of its stream.
    pub(crate) fn nominal(&self, model: &RobotModel, name: &str) -> Option<f64> {
        match self.word {
            Some((_, stream)) => crate::model::nominal::clock_rate(model, stream),
            None => {
                let own = self.values.iter().find(|value| value.name == name);
                let nominal = model.number(self.effect, name);
                match own.filter(|value| value.before != 0.0) {
                    Some(value) => Some(value.applied(nominal, value.before)),
                    None => nominal,
                }
            }
        }
    }

    /// Puts the effect into a model, in place of its own.
    pub(crate) fn write(&self, model: &mut RobotModel) {
        if let Some(law) = &self.law {
            model.effects.push(law.spec());
            return;
        }
        let listed = |spec: &EffectSpec| {
            let words = self.word.is_none_or(|(name, word)| {
                spec.parameters.iter().any(|(own, value)| {
                    own == name && matches!(value, Parameter::Text(text) if text == word)
                })
            });
            spec.effect == self.effect && words
        };
        let place = model.effects.iter().position(listed);
        let known = place.map(|place| model.effects[place].clone());
        let mut spec = known.unwrap_or_else(|| EffectSpec::new(self.effect, &[]));
        let numbers = self.values.iter().map(|value| {
            let estimate = value.estimate(self.nominal(model, value.name));
            (value.name, Parameter::Number(estimate))
        });
        let word = self
            .word
            .map(|(name, word)| (name, Parameter::Text(word.to_owned())));
        for (name, value) in numbers.chain(word) {
            match spec.parameters.iter_mut().find(|(own, _)| own == name) {
                Some((_, own)) => *own = value,
                None => spec.parameters.push((name.to_owned(), value)),
            }
        }
        match place {
            Some(place) => model.effects[place] = spec,
            None => model.effects.push(spec),
        }
    }
}
