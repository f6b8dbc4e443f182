//! A plan, and how one of its cases is made.

use super::battery::battery;
use super::case_spec::CaseSpec;
use super::draw_scene::draw_scene;
use super::kinematic::kinematic;
use super::noise::noise;
use super::sealed::sealed;
use super::starts::starts;
use crate::label::{ConcealedEffect, Label};
use crate::maker::case::{MadeCase, make};
use crate::maker::catalogue_case;
use crate::maker::draw_effect::scaled;
use crate::maker::random::RandomStream;
use crate::maker::scene::Scene;

/// Largest number of draws of one case; the last is taken as it is.
const MAX_DRAWS: u64 = 8;
/// Least expected gain of an effect of random size (nats): nine standard deviations.
const MIN_GAIN_DRAWN_NATS: f64 = 40.0;
/// Least expected gain of an effect of given size (nats).
const MIN_GAIN_GIVEN_NATS: f64 = 1.0;

/// A list of cases.
#[derive(Debug, Clone, PartialEq)]
pub struct Plan {
    seed: u64,
    specs: Vec<CaseSpec>,
}

/// One case of a plan, not yet made.
#[derive(Debug, Clone, PartialEq)]
pub struct PlannedCase {
    /// The name of its folder.
    pub name: String,
    /// Nonce of its commitment.
    pub nonce: String,
    seed: u64,
    spec: CaseSpec,
}

impl Plan {
    /// `cases` cases drawn from a seed.
    pub fn sealed(cases: usize, seed: u64) -> Self {
        let spec = |at: usize| sealed(&mut RandomStream::new(seed, at as u64));
        Self {
            seed,
            specs: (0..cases).map(spec).collect(),
        }
    }

    /// The battery: every effect at several sizes, nulls, pairs, effects outside the vocabulary, other steps,
    /// random disturbances, and effects that only the catalogue has.
    pub fn battery(seed: u64) -> Self {
        Self {
            seed,
            specs: battery(),
        }
    }

    /// Robots without known masses under commanded speeds, without and with process noise.
    pub fn kinematic(seed: u64) -> Self {
        Self {
            seed,
            specs: kinematic(),
        }
    }

    /// Nulls, single effects and pairs under process noise, and nulls without it.
    pub fn noise(seed: u64) -> Self {
        Self {
            seed,
            specs: noise(),
        }
    }

    /// Recordings that start inside what acts.
    pub fn starts(seed: u64) -> Self {
        Self {
            seed,
            specs: starts(),
        }
    }

    /// The cases of the plan that conceal this effect, alone or with others.
    #[must_use]
    pub fn with_effect(mut self, id: &str) -> Self {
        self.specs.retain(|spec| spec.needs(&[id]));
        self
    }

    /// The cases, in order.
    pub fn cases(&self) -> impl Iterator<Item = PlannedCase> {
        self.specs.iter().enumerate().map(|(at, spec)| PlannedCase {
            name: format!("case-{:04}", at + 1),
            nonce: RandomStream::new(self.seed, (1 << 40) + at as u64).nonce(),
            // An odd factor, so that neighbouring seeds give different cases.
            seed: self
                .seed
                .wrapping_mul(0x9e37_79b9_7f4a_7c15)
                .wrapping_add(1000 * at as u64),
            spec: spec.clone(),
        })
    }
}

impl PlannedCase {
    /// Makes the case: draws scenes until the concealed effects are detectable.
    ///
    /// # Errors
    /// A model that cannot be simulated.
    pub fn make(&self) -> Result<MadeCase, String> {
        if let (Some(size), [id]) = (self.spec.by_sim, self.spec.effects.as_slice()) {
            return catalogue_case::make(id, size, &self.spec.kind, self.seed, &self.name);
        }
        let min_gain_nats = if self.spec.size.is_some() {
            MIN_GAIN_GIVEN_NATS
        } else {
            MIN_GAIN_DRAWN_NATS
        };
        let mut scene = self.scene(0)?;
        let mut made = make(&scene, &self.name)?;
        for draw in 1..MAX_DRAWS {
            if is_detectable(&made.label, min_gain_nats) {
                break;
            }
            scene = self.scene(draw)?;
            made = make(&scene, &self.name)?;
        }
        match self.scaled_down(&scene, &made.label) {
            None => Ok(made),
            Some(smaller) => make(&smaller, &self.name),
        }
    }

    /// The same scene with its effect scaled down to the specified number of standard deviations, if one is
    /// specified.
    fn scaled_down(&self, scene: &Scene, label: &Label) -> Option<Scene> {
        let deviations = self.spec.deviations?;
        let ([concealed], None) = (label.effects.as_slice(), &label.unknown) else {
            return None;
        };
        let factor = deviations / (2.0 * concealed.expected_gain?).sqrt();
        let mut scene = scene.clone();
        for effect in scene
            .robots
            .iter_mut()
            .flat_map(|robot| &mut robot.concealed)
        {
            *effect = scaled(effect, factor.min(1.0));
        }
        Some(scene)
    }

    fn scene(&self, draw: u64) -> Result<Scene, String> {
        let seed = self.seed.wrapping_add(draw);
        if !self.stands_out() {
            return draw_scene(&self.spec, seed);
        }
        // Larger from draw to draw, until it stands out of the noise.
        let spec = CaseSpec {
            size: Some(0.4 + 0.6 * draw as f64 / (MAX_DRAWS - 1) as f64),
            ..self.spec.clone()
        };
        draw_scene(&spec, seed)
    }

    /// Whether its effects must stand out of process noise.
    fn stands_out(&self) -> bool {
        self.spec.noise.is_some() && self.spec.size.is_none()
    }
}

/// Whether every concealed effect acts and has at least this expected gain (nats).
fn is_detectable(label: &Label, min_gain_nats: f64) -> bool {
    let effects = label.effects.iter();
    let detectable = |concealed: &ConcealedEffect| {
        let acts = concealed.effect != "wheel_slip" || !concealed.intervals_s.is_empty();
        acts && concealed
            .expected_gain
            .is_none_or(|gain| gain >= min_gain_nats)
    };
    let mut effects = effects.map(detectable);
    let unknown = label
        .unknown
        .as_ref()
        .and_then(|unknown| unknown.expected_gain);
    effects.all(|detectable| detectable) && unknown.is_none_or(|gain| gain >= min_gain_nats)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::maker::draw_effect::{OUTSIDE_KINDS, VOCABULARY};
    use crate::maker::manoeuvre::CommandKind;
    use crate::maker::scene::Control;

    #[test]
    fn the_battery_contains_every_effect_and_nulls() {
        let plan = Plan::battery(1);
        let contains = |id: &str| plan.specs.iter().any(|spec| spec.effects == [id]);
        assert!(VOCABULARY.into_iter().all(contains));
        assert!(
            plan.specs
                .iter()
                .filter(|spec| spec.kind.starts_with("null"))
                .count()
                >= 20
        );
        let outside = plan.specs.iter().filter_map(|spec| spec.outside);
        assert_eq!(outside.max(), Some(OUTSIDE_KINDS - 1));
    }

    /// What an effect gets that only the catalogue knows, shown with one that both simulators know.
    #[test]
    fn the_plant_simulates_any_effect_of_the_catalogue() {
        let spec = CaseSpec {
            by_sim: Some(1.0),
            ..CaseSpec::new("catalogue", &["yaw_scrub"])
        };
        let plan = Plan {
            seed: 1,
            specs: vec![spec],
        };
        let made = plan.cases().next().unwrap().make().unwrap();
        let concealed = &made.label.effects[0];
        assert_eq!(concealed.effect, "yaw_scrub");
        assert_eq!(concealed.channels, ["yaw"]);
        assert!(made.recording.robots[0].pose.as_ref().unwrap().t_s.len() > 500);
        assert_eq!(made.model.effects, []);
    }

    #[test]
    fn a_plan_can_be_restricted_to_one_effect() {
        let plan = Plan::battery(1).with_effect("payload");
        assert!(plan.specs.len() > 4);
        assert!(
            plan.specs
                .iter()
                .all(|spec| spec.effects.contains(&"payload"))
        );
    }

    #[test]
    fn a_seed_determines_the_plan() {
        assert_eq!(Plan::sealed(40, 3), Plan::sealed(40, 3));
        assert_ne!(Plan::sealed(40, 3).specs, Plan::sealed(40, 4).specs);
        let names: Vec<String> = Plan::sealed(2, 3).cases().map(|case| case.name).collect();
        assert_eq!(names, ["case-0001", "case-0002"]);
        // A longer trial begins with the cases of a shorter one.
        assert_eq!(Plan::sealed(40, 3).specs[..10], Plan::sealed(10, 3).specs);
    }

    #[test]
    fn scaled_down_cases_have_the_specified_size() {
        let spec = CaseSpec {
            deviations: Some(20.0),
            size: Some(0.5),
            command_kind: Some(CommandKind::Torque),
            control: Some(Control::Open),
            ..CaseSpec::new("small", &["viscous_drag"])
        };
        let plan = Plan {
            seed: 1,
            specs: vec![spec],
        };
        let made = plan.cases().next().unwrap().make().unwrap();
        let gain = made.label.effects[0].expected_gain.unwrap();
        assert!((gain / 200.0 - 1.0).abs() < 0.2, "{gain}");
    }
}
