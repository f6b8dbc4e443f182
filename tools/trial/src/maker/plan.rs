//! Which cases a trial holds.

use slipstream_bus::RobotModel;

use super::case::{Made, make};
use super::chance::Chance;
use super::drive::play;
use super::effects::{OF_SPEEDS, STRANGE, Setting, VOCABULARY, effect, scaled, strange};
use super::manoeuvre::{Style, Told};
use super::scene::{Actual, Control, Eye, Scene};
use crate::label::Label;

/// Draws of one case before it is taken as it is.
const DRAWS: u64 = 8;
/// Nats that an effect must be worth in a sealed case: nine deviations.
const WORTH_SEALED: f64 = 40.0;
/// The same where sizes are asked for: enough that something is there at all.
const WORTH_ASKED: f64 = 1.0;

/// A list of cases.
#[derive(Debug, Clone, PartialEq)]
pub struct Plan {
    seed: u64,
    wishes: Vec<Wish>,
}

/// One case of a plan, not yet made.
#[derive(Debug, Clone, PartialEq)]
pub struct Planned {
    /// The name of its folder.
    pub name: String,
    /// Nonce of its commitment.
    pub nonce: String,
    seed: u64,
    wish: Wish,
}

/// What a case is to hold.
#[derive(Debug, Clone, PartialEq)]
struct Wish {
    kind: String,
    effects: Vec<&'static str>,
    /// Size between 0 and 1; drawn where it is not asked for.
    size: Option<f64>,
    /// Made so small that this many deviations of it are there.
    deviations: Option<f64>,
    strange: Option<usize>,
    /// The effect is taken out of the catalogue.
    withheld: bool,
    style: Option<Style>,
    control: Option<Control>,
    told: Option<Told>,
    wanders: bool,
    step_s: f64,
}

impl Wish {
    fn new(kind: &str, effects: &[&'static str]) -> Self {
        Self {
            kind: kind.to_owned(),
            effects: effects.to_vec(),
            size: None,
            deviations: None,
            strange: None,
            withheld: false,
            style: None,
            control: None,
            told: None,
            wanders: false,
            step_s: 1e-4,
        }
    }

    fn needs(&self, any: &[&str]) -> bool {
        self.effects.iter().any(|id| any.contains(id))
    }
}

/// Effects whose pairs make sense on any robot.
const PAIRED: [&str; 22] = [
    "wheel_slip",
    "rolling_resistance",
    "viscous_drag",
    "caster_drag",
    "yaw_scrub",
    "axle_friction",
    "torque_speed_droop",
    "actuator_lag",
    "actuator_delay",
    "motor_gain",
    "supply_sag",
    "command_dead_band",
    "backlash",
    "wheel_radius",
    "track_width",
    "payload",
    "floor_slope",
    "pose_offset",
    "pose_latency",
    "wheels_latency",
    "encoder_scale",
    "push",
];
/// Effects whose size is no number that ends at zero.
const THRESHOLDS: [&str; 6] = [
    "wheel_slip",
    "friction_patch",
    "command_saturation",
    "command_dead_band",
    "load_transfer",
    "link_delay",
];
/// Effects that nothing else in the vocabulary looks like.
const WITHHELD: [&str; 4] = [
    "floor_slope",
    "supply_sag",
    "command_dead_band",
    "yaw_scrub",
];

impl Plan {
    /// `cases` cases drawn from a seed.
    pub fn sealed(cases: usize, seed: u64) -> Self {
        let wish = |at: usize| sealed(&mut Chance::new(seed, at as u64));
        Self {
            seed,
            wishes: (0..cases).map(wish).collect(),
        }
    }

    /// Every effect at four sizes, nulls, pairs, what the vocabulary does not hold, another step and
    /// wandering forces.
    pub fn battery(seed: u64) -> Self {
        let wishes = [sized(), pairs(), outside(), nulls(), other_makers()].concat();
        Self { seed, wishes }
    }

    /// The cases, in order.
    pub fn cases(&self) -> impl Iterator<Item = Planned> {
        self.wishes.iter().enumerate().map(|(at, wish)| Planned {
            name: format!("case-{:04}", at + 1),
            nonce: Chance::new(self.seed, (1 << 40) + at as u64).nonce(),
            // the same odd factor spreads seeds that lie next to each other
            seed: self
                .seed
                .wrapping_mul(0x9e37_79b9_7f4a_7c15)
                .wrapping_add(1000 * at as u64),
            wish: wish.clone(),
        })
    }
}

/// Every effect at two sizes that robots show, and twice near the least that can be seen.
fn sized() -> Vec<Wish> {
    let sizes = |id: &&'static str| {
        let id: &'static str = id;
        let large = [0.2, 0.8].map(|size| Wish {
            size: Some(size),
            ..Wish::new("single", &[id])
        });
        let small = [6.0, 30.0].map(|deviations| {
            let deviations = Some(deviations);
            Wish {
                deviations,
                size: Some(0.5),
                ..Wish::new("small", &[id])
            }
        });
        // a threshold is not made smaller by making it less
        if THRESHOLDS.contains(&id) {
            large.to_vec()
        } else {
            [large, small].concat()
        }
    };
    VOCABULARY.iter().flat_map(sizes).collect()
}

fn pairs() -> Vec<Wish> {
    let pair = |at: usize| {
        let partner = |step: usize| PAIRED[(at * 7 + step) % PAIRED.len()];
        Wish {
            size: Some(0.6),
            ..Wish::new("pair", &[partner(0), partner(5)])
        }
    };
    (0..15).map(pair).collect()
}

/// What the vocabulary does not hold, and what the catalogue is handed out without.
fn outside() -> Vec<Wish> {
    let control = Some(Control::Open);
    let strange = (0..STRANGE).flat_map(|kind| [0.4, 0.9].map(|size| (kind, size)));
    let strange = strange.map(|(kind, size)| Wish {
        strange: Some(kind),
        size: Some(size),
        control,
        ..Wish::new("outside", &[])
    });
    let withheld = WITHHELD.into_iter().map(|id| Wish {
        withheld: true,
        size: Some(0.8),
        ..Wish::new("withheld", &[id])
    });
    strange.chain(withheld).collect()
}

fn nulls() -> Vec<Wish> {
    let mut wishes = Vec::new();
    for style in [Style::Lively, Style::Cruise, Style::Wild] {
        for control in [Control::Open, Control::Closed, Control::Platoon] {
            for wanders in [false, true] {
                let null = Wish::new(if wanders { "null, wandering" } else { "null" }, &[]);
                let (style, control) = (Some(style), Some(control));
                wishes.push(Wish {
                    style,
                    control,
                    wanders,
                    ..null
                });
            }
        }
    }
    for told in [Told::Voltage, Told::Twist, Told::WheelSpeed] {
        let (told, control) = (Some(told), Some(Control::Open));
        wishes.push(Wish {
            told,
            control,
            ..Wish::new("null", &[])
        });
    }
    wishes
}

/// Wandering forces, and finer and coarser steps of the maker.
fn other_makers() -> Vec<Wish> {
    let ids = [
        "rolling_resistance",
        "wheel_slip",
        "payload",
        "actuator_delay",
        "floor_slope",
        "motor_gain",
    ];
    let both = |(at, id): (usize, &'static str)| {
        let step_s = if at % 2 == 0 { 2.5e-5 } else { 4e-4 };
        [
            Wish {
                wanders: true,
                size: Some(0.7),
                ..Wish::new("wandering", &[id])
            },
            Wish {
                step_s,
                size: Some(0.6),
                ..Wish::new("another step", &[id])
            },
        ]
    };
    ids.into_iter().enumerate().flat_map(both).collect()
}

fn sealed(chance: &mut Chance) -> Wish {
    let one = |chance: &mut Chance| *chance.one(&VOCABULARY);
    match chance.unit() {
        ..0.2 => {
            let mut null = Wish::new("null", &[]);
            null.wanders = chance.happens(0.25);
            null
        }
        ..0.5 => Wish::new("single", &[one(chance)]),
        ..0.68 => {
            let deviations = Some(chance.in_proportion(9.0, 200.0));
            Wish {
                deviations,
                ..Wish::new("small", &[one(chance)])
            }
        }
        ..0.82 => {
            let first = *chance.one(&PAIRED);
            let others: Vec<&str> = PAIRED.into_iter().filter(|id| *id != first).collect();
            Wish::new("pair", &[first, *chance.one(&others)])
        }
        ..0.85 => {
            let first = (chance.unit() * PAIRED.len() as f64) as usize;
            let next = |step: usize| PAIRED[(first + step) % PAIRED.len()];
            Wish::new("triple", &[next(0), next(4), next(9)])
        }
        ..0.95 => {
            let kind = (chance.unit() * STRANGE as f64) as usize;
            Wish {
                strange: Some(kind),
                ..Wish::new("outside", &[])
            }
        }
        _ => Wish {
            withheld: true,
            ..Wish::new("withheld", &[*chance.one(&WITHHELD)])
        },
    }
}

impl Planned {
    /// Makes the case: draws until what it holds can be seen.
    ///
    /// # Errors
    /// A model that cannot move.
    pub fn make(&self) -> Result<Made, String> {
        let asked = self.wish.size.is_some();
        let worth = if asked { WORTH_ASKED } else { WORTH_SEALED };
        let mut scene = self.scene(0)?;
        let mut made = make(&scene, &self.name)?;
        for draw in 1..DRAWS {
            if can_be_seen(&made.label, worth) {
                break;
            }
            scene = self.scene(draw)?;
            made = make(&scene, &self.name)?;
        }
        match self.small(&scene, &made.label) {
            None => Ok(made),
            Some(small) => make(&small, &self.name),
        }
    }

    /// The same scene with a concealed effect so small that it is worth little.
    fn small(&self, scene: &Scene, label: &Label) -> Option<Scene> {
        let deviations = self.wish.deviations?;
        let ([hidden], None) = (label.effects.as_slice(), &label.unknown) else {
            return None;
        };
        let factor = deviations / (2.0 * hidden.expected_gain?).sqrt();
        let mut scene = scene.clone();
        for effect in scene.robots.iter_mut().flat_map(|robot| &mut robot.hidden) {
            *effect = scaled(effect, factor.min(1.0));
        }
        Some(scene)
    }

    fn scene(&self, draw: u64) -> Result<Scene, String> {
        scene(&self.wish, self.seed.wrapping_add(draw))
    }
}

fn can_be_seen(label: &Label, worth: f64) -> bool {
    let effects = label.effects.iter();
    let seen = |hidden: &crate::label::Hidden| {
        let at_work = hidden.effect != "wheel_slip" || !hidden.intervals_s.is_empty();
        at_work && hidden.expected_gain.is_none_or(|gain| gain >= worth)
    };
    let mut effects = effects.map(seen);
    let unknown = label
        .unknown
        .as_ref()
        .and_then(|unknown| unknown.expected_gain);
    effects.all(|seen| seen) && unknown.is_none_or(|gain| gain >= worth)
}

fn scene(wish: &Wish, seed: u64) -> Result<Scene, String> {
    let mut chance = Chance::new(seed, 0);
    let slides = wish.needs(&["wheel_slip", "friction_patch", "load_transfer"]);
    let kinematic = wish.effects.iter().all(|id| OF_SPEEDS.contains(id)) && wish.strange.is_none();
    let control = wish.control.unwrap_or_else(|| control(wish, &mut chance));
    let told = wish
        .told
        .unwrap_or_else(|| told(control, kinematic && !slides, wish, &mut chance));
    let speeds = matches!(told, Told::Twist | Told::WheelSpeed);
    let style = wish.style.unwrap_or_else(|| match chance.unit() {
        _ if slides => Style::Wild,
        ..0.15 if wish.strange.is_none() => Style::Cruise,
        ..0.3 if !speeds => Style::Wild,
        _ => Style::Lively,
    });
    let short = wish.strange.is_none() && !slides && chance.happens(0.1);
    let duration_s = if short {
        chance.between(9.0, 13.0)
    } else {
        chance.between(20.0, 40.0)
    };
    let robots = if control == Control::Platoon { 3 } else { 1 };
    let place = if wish.needs(&["link_delay"]) {
        1 + usize::from(chance.happens(0.5))
    } else {
        (chance.unit() * robots as f64) as usize
    };
    let eyes: Vec<Eye> = (0..robots)
        .map(|i| eye(i == place, wish, &mut chance))
        .collect();
    let mut scene = Scene {
        kind: wish.kind.clone(),
        nominal: nominal(wish, speeds, &mut chance),
        robots: eyes
            .iter()
            .map(|&eye| Actual {
                hidden: Vec::new(),
                strange: None,
                eye,
            })
            .collect(),
        control,
        told,
        style,
        duration_s: (duration_s / 0.5).round() * 0.5,
        imu: wish.needs(&["imu_latency"]) || chance.happens(0.25) && !speeds,
        wandering_n: if wish.wanders {
            chance.in_proportion(0.003, 0.03)
        } else {
            0.0
        },
        step_s: wish.step_s,
        without: if wish.withheld {
            vec![wish.effects[0].to_owned()]
        } else {
            Vec::new()
        },
        seed,
    };
    conceal(wish, &mut scene, place, &mut chance)?;
    Ok(scene)
}

/// Draws what is concealed, where places and times of the undisturbed path matter too.
fn conceal(
    wish: &Wish,
    scene: &mut Scene,
    place: usize,
    chance: &mut Chance,
) -> Result<(), String> {
    let needs_path = wish.needs(&["friction_patch"]) || wish.strange.is_some();
    let path = if needs_path {
        play(scene)?.robots.swap_remove(place).trace.poses
    } else {
        Vec::new()
    };
    let setting = Setting {
        speeds: matches!(scene.told, Told::Twist | Told::WheelSpeed),
        duration_s: scene.duration_s,
        path: &path,
        imu: scene.imu,
        camera: scene.robots[place].eye != Eye::Blind,
    };
    let mut size = || wish.size.unwrap_or_else(|| chance.unit());
    let sizes: Vec<f64> = wish.effects.iter().map(|_| size()).collect();
    let strange_size = size();
    for (id, size) in wish.effects.iter().zip(sizes) {
        scene.robots[place]
            .hidden
            .push(effect(id, size, &setting, chance));
    }
    scene.robots[place].strange = wish
        .strange
        .map(|kind| strange(kind, strange_size, &setting, chance));
    Ok(())
}

fn control(wish: &Wish, chance: &mut Chance) -> Control {
    match chance.unit() {
        _ if wish.needs(&["link_delay"]) => Control::Platoon,
        ..0.55 => Control::Open,
        ..0.87 => Control::Closed,
        _ => Control::Platoon,
    }
}

fn told(control: Control, kinematic: bool, wish: &Wish, chance: &mut Chance) -> Told {
    let limits = wish.needs(&["command_dead_band", "command_saturation"]);
    match chance.unit() {
        _ if control != Control::Open => Told::Torque,
        ..0.25 if kinematic => Told::Twist,
        ..0.4 if kinematic => Told::WheelSpeed,
        ..0.55 if !limits => Told::Voltage,
        _ => Told::Torque,
    }
}

fn eye(concealed: bool, wish: &Wish, chance: &mut Chance) -> Eye {
    let tracked = wish.needs(&[
        "pose_offset",
        "pose_latency",
        "wheel_radius",
        "track_width",
        "encoder_scale",
    ]);
    match chance.unit() {
        _ if concealed && tracked => Eye::Pose,
        ..0.12 => Eye::Blind,
        ..0.2 => Eye::Place,
        _ => Eye::Pose,
    }
}

/// The paper's robot, or one like it; with or without slip.
fn nominal(wish: &Wish, speeds: bool, chance: &mut Chance) -> RobotModel {
    let mut model = RobotModel::default();
    if chance.happens(0.3) {
        let body = &mut model.robot;
        let scale = |value: &mut Option<f64>, chance: &mut Chance| {
            *value = value.map(|value| (value * chance.between(0.8, 1.25) * 1e6).round() / 1e6);
        };
        for value in [
            &mut body.body_mass_kg,
            &mut body.body_yaw_inertia_kg_m2,
            &mut body.wheel_spin_inertia_kg_m2,
            &mut body.com_to_axle_m,
            &mut body.com_to_caster_m,
        ] {
            scale(value, chance);
        }
    }
    let slips = wish.needs(&["load_transfer"]) || chance.happens(0.4);
    if slips && !speeds && !wish.needs(&["wheel_slip"]) {
        model = model.with(
            "wheel_slip",
            &[("friction_static", 0.241), ("friction_kinetic", 0.239)],
        );
    }
    model
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_battery_holds_every_effect_and_nothing() {
        let plan = Plan::battery(1);
        let holds = |id: &str| plan.wishes.iter().any(|wish| wish.effects == [id]);
        assert!(VOCABULARY.into_iter().all(holds));
        assert!(
            plan.wishes
                .iter()
                .filter(|wish| wish.kind.starts_with("null"))
                .count()
                >= 20
        );
        let strange = plan.wishes.iter().filter_map(|wish| wish.strange);
        assert_eq!(strange.max(), Some(STRANGE - 1));
    }

    #[test]
    fn a_seed_is_a_plan() {
        assert_eq!(Plan::sealed(40, 3), Plan::sealed(40, 3));
        assert_ne!(Plan::sealed(40, 3).wishes, Plan::sealed(40, 4).wishes);
        let names: Vec<String> = Plan::sealed(2, 3).cases().map(|case| case.name).collect();
        assert_eq!(names, ["case-0001", "case-0002"]);
        // a longer trial begins as a shorter one
        assert_eq!(Plan::sealed(40, 3).wishes[..10], Plan::sealed(10, 3).wishes);
    }

    #[test]
    fn small_cases_are_as_small_as_asked_for() {
        let wish = Wish {
            deviations: Some(20.0),
            size: Some(0.5),
            told: Some(Told::Torque),
            control: Some(Control::Open),
            ..Wish::new("small", &["viscous_drag"])
        };
        let plan = Plan {
            seed: 1,
            wishes: vec![wish],
        };
        let made = plan.cases().next().unwrap().make().unwrap();
        let gain = made.label.effects[0].expected_gain.unwrap();
        assert!((gain / 200.0 - 1.0).abs() < 0.2, "{gain}");
    }
}
