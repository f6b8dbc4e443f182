//! The pictures of a study: the user's case over the delay, then one factor at a time.

use maud::{Markup, html};
use slipstream_study::delay::{Grid, GridCell, Point, Study};

use crate::parts::{Frame, Ink, Points, Scale, card};

/// Height of the pictures of the case, and of one factor (pixels).
const HEIGHTS_PX: [u32; 2] = [210, 150];

/// Least distance of two names, as a share of the axis.
const LABEL_SHARE: f64 = 0.12;

/// A factor of the grid: what it is called, and the case with each of its values.
struct Factor {
    name: &'static str,
    values: Vec<(String, GridCell)>,
}

/// The section.
pub(super) fn section(study: &Study) -> Markup {
    let Some(case) = study.grid.case() else {
        return html! {};
    };
    let own = study.points_of(&case);
    if own.is_empty() {
        return html! {};
    }
    let factors = factors(&study.grid, &case);
    html! {
        section id="pictures" class="first" {
            h2 { "Against the delay on each link" }
            p class="sub" { (case.conditions()) }
            div class="figs2" { (spacing(&own)) (speed(&own)) }
            @if !factors.is_empty() {
                h3 style="margin-top:28px" { "One factor at a time: largest spacing error, cm" }
                p class="sub" { "All else is as above. Each picture has its own scale." }
                div class="cards" { @for factor in &factors { (of_factor(study, &case, factor)) } }
            }
        }
    }
}

fn line(points: &[&Point], quantity: impl Fn(&Point) -> f64) -> Points {
    let own = points.iter();
    own.map(|own| (1e3 * own.cell.delay_s, quantity(own)))
        .collect()
}

fn delays(points: &[&Point]) -> Scale {
    Scale::around(points.iter().map(|own| 1e3 * own.cell.delay_s), true, 5)
}

fn spacing(points: &[&Point]) -> Markup {
    let errors = line(points, |own| 1e2 * own.max_spacing_error_m);
    let scale = Scale::around(errors.iter().map(|own| own.1), true, 4);
    let frame = Frame::new(
        delays(points),
        scale,
        HEIGHTS_PX[0],
        "Largest spacing error against delay, cm",
    )
    .x_axis("ms")
    .line(Ink::After, &errors, f64::INFINITY)
    .dots(Ink::After, &errors, 8.0);
    card(None, "Largest spacing error", "cm", &frame.markup(), "")
}

fn speed(points: &[&Point]) -> Markup {
    let measured = line(points, |own| own.max_desired_speed_m_s);
    let bound = line(points, |own| own.bound_eq14_m_s);
    let transport = line(points, |own| own.transport_delay_m_s);
    let all = measured.iter().chain(&bound).chain(&transport);
    let scale = Scale::around(all.map(|own| own.1), true, 4);
    let frame = Frame::new(
        delays(points),
        scale,
        HEIGHTS_PX[0],
        "Largest desired speed against delay, m/s",
    )
    .x_axis("ms")
    .line(Ink::Measured, &bound, f64::INFINITY)
    .line(Ink::ContextDashed, &transport, f64::INFINITY)
    .line(Ink::After, &measured, f64::INFINITY)
    .dots(Ink::After, &measured, 8.0);
    html! {
        figure class="card" {
            figcaption { h3 { "Largest desired speed" } "m/s, before limiting" }
            p class="legend" {
                span class="ca" { i class="kl af" {} "simulated" }
                span class="cr" { i class="kl rf" {} "largest bound of Eq. 14" }
                span class="cm" { i class="kl cx da" {} "Eq. 13 as a transport delay" }
            }
            (frame.markup())
        }
    }
}

/// The factors of which the grid has several values.
fn factors(grid: &Grid, case: &GridCell) -> Vec<Factor> {
    let numbers =
        |name, all: &[f64], unit: &str, factor: f64, with: fn(&GridCell, f64) -> GridCell| Factor {
            name,
            values: all
                .iter()
                .map(|&own| (format!("{} {unit}", plain(factor * own)), with(case, own)))
                .collect(),
        };
    let names = |name, all: &[String], with: fn(&GridCell, String) -> GridCell| Factor {
        name,
        values: all
            .iter()
            .map(|own| (own.clone(), with(case, own.clone())))
            .collect(),
    };
    let all = [
        names("Protocol", &grid.protocol, |case, protocol| GridCell {
            protocol,
            ..case.clone()
        }),
        names("Torque limit", &grid.torque_limit, |case, torque_limit| {
            GridCell {
                torque_limit,
                ..case.clone()
            }
        }),
        numbers("Gain k_x", &grid.k_x, "s⁻¹", 1.0, |case, k_x| GridCell {
            k_x,
            ..case.clone()
        }),
        numbers("Jitter", &grid.jitter_s, "ms", 1e3, |case, jitter_s| {
            GridCell {
                jitter_s,
                ..case.clone()
            }
        }),
        numbers("Loss", &grid.loss, "%", 1e2, |case, loss| GridCell {
            loss,
            ..case.clone()
        }),
    ];
    all.into_iter().filter(|own| own.values.len() > 1).collect()
}

fn of_factor(study: &Study, case: &GridCell, factor: &Factor) -> Markup {
    let lines: Vec<(&str, bool, Vec<&Point>)> = factor
        .values
        .iter()
        .map(|(name, cell)| (name.as_str(), cell == case, study.points_of(cell)))
        .collect();
    let all: Vec<&Point> = lines.iter().flat_map(|own| own.2.iter().copied()).collect();
    let errors = |points: &[&Point]| line(points, |own| 1e2 * own.max_spacing_error_m);
    let scale = Scale::around(errors(&all).into_iter().map(|own| own.1), true, 4);
    let described = format!(
        "Largest spacing error against delay by {}, cm",
        factor.name.to_lowercase()
    );
    let mut frame = Frame::new(delays(&all), scale, HEIGHTS_PX[1], described).x_axis("ms");
    let mut ends = Vec::new();
    for (name, is_case, points) in &lines {
        let ink = if *is_case { Ink::After } else { Ink::Context };
        let errors = errors(points);
        frame = frame
            .line(ink, &errors, f64::INFINITY)
            .dots(ink, &errors, 6.0);
        ends.extend(errors.last().map(|&end| (end, ink, *name)));
    }
    // Names of lines that end close to each other are set apart.
    ends.sort_by(|a, b| b.0.1.total_cmp(&a.0.1));
    let least = LABEL_SHARE * (scale.high - scale.low);
    let mut highest = scale.high;
    for ((x, y), ink, name) in ends {
        let own = y.min(highest);
        highest = own - least;
        frame = frame.label(ink, [x, own], name);
    }
    card(None, factor.name, "", &frame.markup(), "")
}

/// A value of a key as it was given, without the digits that a change of unit adds.
fn plain(value: f64) -> String {
    ((value * 1e9).round() / 1e9).to_string()
}
