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
use crate::maker::logs::{self, Log};
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
    recipes: Vec<Recipe>,
}

/// How a case comes about.
#[derive(Debug, Clone, PartialEq)]
enum Recipe {
    /// A scene of robots with masses, drawn when it is made.
    Scene(CaseSpec),
    /// The log of a kinematic robot, drawn already.
    Log(Box<Log>),
}

impl Recipe {
    /// Whether it conceals this effect.
    fn needs(&self, id: &str) -> bool {
        match self {
            Self::Scene(spec) => spec.needs(&[id]),
            Self::Log(log) => log.conceals(&[id]),
        }
    }
}

/// One case of a plan, not yet made.
#[derive(Debug, Clone, PartialEq)]
pub struct PlannedCase {
    /// The name of its folder.
    pub name: String,
    /// Nonce of its commitment.
    pub nonce: String,
    seed: u64,
    recipe: Recipe,
}

impl Plan {
    fn of(seed: u64, specs: Vec<CaseSpec>) -> Self {
        Self {
            seed,
            recipes: specs.into_iter().map(Recipe::Scene).collect(),
        }
    }

    /// `cases` cases drawn from a seed.
    pub fn sealed(cases: usize, seed: u64) -> Self {
        let spec = |at: usize| sealed(&mut RandomStream::new(seed, at as u64));
        Self::of(seed, (0..cases).map(spec).collect())
    }

    /// `cases` logs of kinematic robots, with what logs of real robots have, drawn from a seed.
    pub fn logs(cases: usize, seed: u64) -> Self {
        let log = |at: usize| Recipe::Log(Box::new(logs::draw(case_seed(seed, at))));
        Self {
            seed,
            recipes: (0..cases).map(log).collect(),
        }
    }

    /// The battery: every effect at several sizes, nulls, pairs, effects outside the vocabulary, other steps,
    /// random disturbances, and effects that only the catalogue has.
    pub fn battery(seed: u64) -> Self {
        Self::of(seed, battery())
    }

    /// Robots without known masses under commanded speeds, without and with process noise.
    pub fn kinematic(seed: u64) -> Self {
        Self::of(seed, kinematic())
    }

    /// Nulls, single effects and pairs under process noise, and nulls without it.
    pub fn noise(seed: u64) -> Self {
        Self::of(seed, noise())
    }

    /// Recordings that start inside what acts.
    pub fn starts(seed: u64) -> Self {
        Self::of(seed, starts())
    }

    /// `cases` cases from all over the plan, each as often as any other (or once more); with other random numbers
    /// where one is there twice.
    #[must_use]
    pub fn spread(mut self, cases: usize) -> Self {
        let all = self.recipes.len();
        let spread = (0..cases).filter_map(|at| self.recipes.get(at * all / cases));
        self.recipes = spread.cloned().collect();
        self
    }

    /// The cases of the plan that conceal this effect, alone or with others.
    #[must_use]
    pub fn with_effect(mut self, id: &str) -> Self {
        self.recipes.retain(|recipe| recipe.needs(id));
        self
    }

    /// The cases, in order.
    pub fn cases(&self) -> impl Iterator<Item = PlannedCase> {
        self.recipes
            .iter()
            .enumerate()
            .map(|(at, recipe)| PlannedCase {
                name: format!("case-{:04}", at + 1),
                nonce: RandomStream::new(self.seed, (1 << 40) + at as u64).nonce(),
                seed: case_seed(self.seed, at),
                recipe: recipe.clone(),
            })
    }
}

/// The seed of a case.
fn case_seed(seed: u64, at: usize) -> u64 {
    // An odd factor, so that neighbouring seeds give different cases.
    seed.wrapping_mul(0x9e37_79b9_7f4a_7c15)
        .wrapping_add(1000 * at as u64)
}

impl PlannedCase {
    /// Makes the case.
    ///
    /// # Errors
    /// A model that cannot be simulated.
    pub fn make(&self) -> Result<MadeCase, String> {
        match &self.recipe {
            Recipe::Log(log) => Ok(logs::make(log, &self.name)),
            Recipe::Scene(spec) => match (spec.by_sim, spec.effects.as_slice()) {
                (Some(size), [id]) => {
                    catalogue_case::make(id, size, &spec.kind, self.seed, &self.name)
                }
                _ => detectable_scene(spec, self.seed, &self.name),
            },
        }
    }
}

/// Draws scenes until the concealed effects are detectable.
fn detectable_scene(spec: &CaseSpec, seed: u64, name: &str) -> Result<MadeCase, String> {
    let min_gain_nats = if spec.size.is_some() {
        MIN_GAIN_GIVEN_NATS
    } else {
        MIN_GAIN_DRAWN_NATS
    };
    let mut drawn = scene(spec, seed, 0)?;
    let mut made = make(&drawn, name)?;
    for draw in 1..MAX_DRAWS {
        if is_detectable(&made.label, min_gain_nats) {
            break;
        }
        drawn = scene(spec, seed, draw)?;
        made = make(&drawn, name)?;
    }
    match scaled_down(spec, &drawn, &made.label) {
        None => Ok(made),
        Some(smaller) => make(&smaller, name),
    }
}

/// The same scene with its effect scaled down to the specified number of standard deviations, if one is
/// specified.
fn scaled_down(spec: &CaseSpec, scene: &Scene, label: &Label) -> Option<Scene> {
    let deviations = spec.deviations?;
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

fn scene(spec: &CaseSpec, seed: u64, draw: u64) -> Result<Scene, String> {
    let seed = seed.wrapping_add(draw);
    // Effects of no given size must stand out of process noise.
    if spec.noise.is_none() || spec.size.is_some() {
        return draw_scene(spec, seed);
    }
    // Larger from draw to draw, until they do.
    let larger = CaseSpec {
        size: Some(0.4 + 0.6 * draw as f64 / (MAX_DRAWS - 1) as f64),
        ..spec.clone()
    };
    draw_scene(&larger, seed)
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

    /// The scenes of a plan.
    fn specs(plan: &Plan) -> Vec<&CaseSpec> {
        let recipes = plan.recipes.iter();
        let scenes = recipes.filter_map(|recipe| match recipe {
            Recipe::Scene(spec) => Some(spec),
            Recipe::Log(_) => None,
        });
        scenes.collect()
    }

    #[test]
    fn a_list_is_cut_to_cases_from_all_over_it() {
        let all = Plan::kinematic(1);
        let few = Plan::kinematic(1).spread(3);
        assert_eq!(few.cases().count(), 3);
        let third = all.recipes.len() / 3;
        assert_eq!(few.recipes[1], all.recipes[third]);
        assert_eq!(Plan::kinematic(1).spread(all.recipes.len()), all);
        let twice = Plan::kinematic(1).spread(2 * all.recipes.len());
        assert_eq!(twice.recipes[1], all.recipes[0]);
        assert_eq!(Plan::kinematic(1).spread(0).cases().count(), 0);
    }

    #[test]
    fn the_battery_contains_every_effect_and_nulls() {
        let plan = Plan::battery(1);
        let contains = |id: &str| specs(&plan).iter().any(|spec| spec.effects == [id]);
        assert!(VOCABULARY.into_iter().all(contains));
        assert!(
            specs(&plan)
                .iter()
                .filter(|spec| spec.kind.starts_with("null"))
                .count()
                >= 20
        );
        let all = specs(&plan);
        let outside = all.iter().filter_map(|spec| spec.outside);
        assert_eq!(outside.max(), Some(OUTSIDE_KINDS - 1));
    }

    /// What an effect gets that only the catalogue knows, shown with one that both simulators know.
    #[test]
    fn the_plant_simulates_any_effect_of_the_catalogue() {
        let spec = CaseSpec {
            by_sim: Some(1.0),
            ..CaseSpec::new("catalogue", &["yaw_scrub"])
        };
        let plan = Plan::of(1, vec![spec]);
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
        assert!(plan.recipes.len() > 4);
        let all = specs(&plan);
        assert!(all.iter().all(|spec| spec.effects.contains(&"payload")));
    }

    #[test]
    fn a_seed_determines_the_plan() {
        assert_eq!(Plan::sealed(40, 3), Plan::sealed(40, 3));
        assert_ne!(Plan::sealed(40, 3).recipes, Plan::sealed(40, 4).recipes);
        let names: Vec<String> = Plan::sealed(2, 3).cases().map(|case| case.name).collect();
        assert_eq!(names, ["case-0001", "case-0002"]);
        // A longer trial begins with the cases of a shorter one.
        assert_eq!(
            Plan::sealed(40, 3).recipes[..10],
            Plan::sealed(10, 3).recipes
        );
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
        let plan = Plan::of(1, vec![spec]);
        let made = plan.cases().next().unwrap().make().unwrap();
        let gain = made.label.effects[0].expected_gain.unwrap();
        assert!((gain / 200.0 - 1.0).abs() < 0.2, "{gain}");
    }
}
