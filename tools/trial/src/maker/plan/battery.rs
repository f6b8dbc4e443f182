//! The battery: every effect at several sizes, nulls, pairs, effects outside the vocabulary, other steps,
//! random disturbances, and effects that only the catalogue has.

use super::case_spec::{CaseSpec, PAIRED, WITHHELD};
use crate::maker::draw_effect::{OUTSIDE_KINDS, VOCABULARY};
use crate::maker::manoeuvre::{CommandKind, Style};
use crate::maker::scene::Control;
use slipstream_sim::effects::{CATALOGUE, Domain, ModelSite};

/// Effects that do not vanish as their parameter goes to zero.
const THRESHOLDS: [&str; 6] = [
    "wheel_slip",
    "friction_patch",
    "command_saturation",
    "command_dead_band",
    "load_transfer",
    "link_delay",
];

/// All cases of the battery.
pub(super) fn battery() -> Vec<CaseSpec> {
    [
        sized(),
        pairs(),
        outside(),
        nulls(),
        other_makers(),
        catalogue_only(),
    ]
    .concat()
}

/// Every effect at two sizes that occur on robots and, unless it is a threshold, at two near the detection
/// limit.
fn sized() -> Vec<CaseSpec> {
    let sizes = |id: &&'static str| {
        let id: &'static str = id;
        let large = [0.2, 0.8].map(|size| CaseSpec {
            size: Some(size),
            ..CaseSpec::new("single", &[id])
        });
        let small = [6.0, 30.0].map(|deviations| {
            let deviations = Some(deviations);
            CaseSpec {
                deviations,
                size: Some(0.5),
                ..CaseSpec::new("small", &[id])
            }
        });
        // A lower threshold is not a smaller effect.
        if THRESHOLDS.contains(&id) {
            large.to_vec()
        } else {
            [large, small].concat()
        }
    };
    VOCABULARY.iter().flat_map(sizes).collect()
}

/// Effects of the catalogue that the second simulator does not know, at the smallest and the largest of
/// their probe values. The plant itself simulates them.
fn catalogue_only() -> Vec<CaseSpec> {
    let new = CATALOGUE
        .iter()
        .filter(|info| !VOCABULARY.contains(&info.id) && info.site != ModelSite::Link)
        // a table has no probe values
        .filter(|info| {
            !info
                .parameters
                .iter()
                .any(|p| matches!(p.domain, Domain::List { .. }))
        });
    new.flat_map(|info| {
        [0.0, 1.0].map(|size| CaseSpec {
            by_sim: Some(size),
            ..CaseSpec::new("catalogue", &[info.id])
        })
    })
    .collect()
}

/// Pairs of effects.
fn pairs() -> Vec<CaseSpec> {
    let pair = |at: usize| {
        let partner = |step: usize| PAIRED[(at * 7 + step) % PAIRED.len()];
        CaseSpec {
            size: Some(0.6),
            ..CaseSpec::new("pair", &[partner(0), partner(5)])
        }
    };
    (0..15).map(pair).collect()
}

/// Effects outside the vocabulary, and effects removed from the catalogue.
fn outside() -> Vec<CaseSpec> {
    let control = Some(Control::Open);
    let outside = (0..OUTSIDE_KINDS).flat_map(|kind| [0.4, 0.9].map(|size| (kind, size)));
    let outside = outside.map(|(kind, size)| CaseSpec {
        outside: Some(kind),
        size: Some(size),
        control,
        ..CaseSpec::new("outside", &[])
    });
    let withheld = WITHHELD.into_iter().map(|id| CaseSpec {
        withheld: true,
        size: Some(0.8),
        ..CaseSpec::new("withheld", &[id])
    });
    outside.chain(withheld).collect()
}

/// Cases without a concealed effect.
fn nulls() -> Vec<CaseSpec> {
    let mut specs = Vec::new();
    for style in [Style::Lively, Style::Cruise, Style::Wild] {
        for control in [Control::Open, Control::Closed, Control::Platoon] {
            for disturbed in [false, true] {
                let null = CaseSpec::new(if disturbed { "null, wandering" } else { "null" }, &[]);
                let (style, control) = (Some(style), Some(control));
                specs.push(CaseSpec {
                    style,
                    control,
                    disturbed,
                    ..null
                });
            }
        }
    }
    for command_kind in [
        CommandKind::Voltage,
        CommandKind::Twist,
        CommandKind::WheelSpeed,
    ] {
        let (command_kind, control) = (Some(command_kind), Some(Control::Open));
        specs.push(CaseSpec {
            command_kind,
            control,
            ..CaseSpec::new("null", &[])
        });
    }
    specs
}

/// Random disturbances, and finer and coarser steps of the simulation.
fn other_makers() -> Vec<CaseSpec> {
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
            CaseSpec {
                disturbed: true,
                size: Some(0.7),
                ..CaseSpec::new("wandering", &[id])
            },
            CaseSpec {
                step_s,
                size: Some(0.6),
                ..CaseSpec::new("another step", &[id])
            },
        ]
    };
    ids.into_iter().enumerate().flat_map(both).collect()
}
