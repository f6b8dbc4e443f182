//! One picture for each finding: how the fit falls with its assumed size, or the law that was found.

use maud::{Markup, html};
use slipstream_answer::{Figures, Finding, LawCurve, Profile};
use slipstream_bus::RobotModel;

use super::diagnosis::Diagnosis;
use crate::effect_words::{Shown, driver, name, scale_of, shown, unit_of};
use crate::parts::{Frame, Ink, Points, Scale, card, short, with_unit};

/// Height of a picture (pixels).
const HEIGHT_PX: u32 = 200;

/// The section; empty without findings that have a picture.
pub(super) fn section(diagnosis: &Diagnosis<'_>, machines: &[&Figures]) -> Markup {
    let numbered = diagnosis.numbered();
    let of = |index: usize| numbered.iter().find(|(_, own, _)| *own == index);
    let mut all: Vec<(usize, Markup)> = Vec::new();
    for own in machines {
        for profile in &own.profiles {
            if let Some((number, _, finding)) = of(profile.finding) {
                let model = diagnosis.model(&finding.robot);
                let card = profile_card(model.as_ref(), *number, finding, profile);
                all.push((*number, card));
            }
        }
        for law in &own.laws {
            if let Some((number, ..)) = of(law.finding) {
                all.push((*number, law_card(*number, law)));
            }
        }
    }
    all.sort_by_key(|(number, _)| *number);
    html! {
        @if !all.is_empty() {
            section id="why" aria-labelledby="h-why" {
                h2 id="h-why" { @if all.len() == 1 { "Why this" } @else { "Why these" } }
                p class="sub" { "How much worse the whole recording fits with each assumed size, everything else as found. The "
                    "interval is shaded; it is wider than this curve tells, as it lets everything else move too." }
                div class="cards" { @for (_, card) in &all { (card) } }
            }
        }
    }
}

fn profile_card(
    model: Option<&RobotModel>,
    number: usize,
    finding: &Finding,
    profile: &Profile,
) -> Markup {
    let native = unit_of(&finding.effect, profile.parameter);
    let (factor, unit) = scale_of(&finding.effect, profile.parameter, native, model);
    let points = profile.points.iter();
    let points: Points = points
        .map(|(size, worse)| (factor * size, *worse))
        .collect();
    let parameter = finding
        .parameters
        .iter()
        .find(|own| own.name == profile.parameter);
    let own = parameter.and_then(|own| shown(&finding.effect, own, model));
    let mut claim = name(&finding.effect).to_owned();
    if let Some(own) = &own {
        claim = format!("{claim}, {}: {}", own.label, own.is_words());
    }
    let drawn = "Standard deviations from the best fit, against the assumed size";
    let (frame, words) = profile_frame(&points, own.as_ref(), unit, &format!("{drawn}: {claim}"));
    card(Some(number), &claim, drawn, &frame.markup(), &words)
}

/// The curve with the model's value, the estimate and its interval; and what it says in words.
fn profile_frame(
    points: &[(f64, f64)],
    own: Option<&Shown>,
    unit: &str,
    described: &str,
) -> (Frame, String) {
    let x = Scale::around(points.iter().map(|p| p.0), false, 4);
    let y = Scale::around(points.iter().map(|p| p.1), true, 4);
    let nearest = |size: f64| {
        let near = points.iter().copied();
        near.min_by(|a, b| (a.0 - size).abs().total_cmp(&(b.0 - size).abs()))
    };
    let mut frame =
        Frame::new(x, y, HEIGHT_PX, described)
            .x_axis(unit)
            .line(Ink::After, points, f64::INFINITY);
    let mut words = String::new();
    let Some(own) = own else {
        return (frame, words);
    };
    frame = frame.span(None, own.interval);
    let was = own
        .was
        .filter(|was| *was >= x.low && *was <= x.high)
        .and_then(nearest);
    if let Some(was) = was {
        frame =
            frame
                .dots(Ink::Before, &[was], 9.0)
                .label(Ink::Before, [was.0, was.1], "the model");
        words = format!(
            "With the model's value it fits worse by {} standard deviations.",
            short(was.1)
        );
    }
    if let Some(is) = nearest(own.is) {
        frame = frame.dots(Ink::After, &[(own.is, is.1)], 9.0);
    }
    (frame, words)
}

fn law_card(number: usize, law: &LawCurve) -> Markup {
    let all = law.curve.iter().chain(&law.band[0]).chain(&law.band[1]);
    let x = Scale::around(law.curve.iter().map(|p| p.0), true, 4);
    let y = Scale::around(all.map(|p| p.1), true, 4);
    let (of, of_unit) = driver(law.driver);
    let mut sizes = law.curve.clone();
    sizes.sort_by(|a, b| b.1.abs().total_cmp(&a.1.abs()));
    let claim = sizes.first().map_or_else(String::new, |(at, value)| {
        let largest = with_unit(&short(*value), law.unit);
        format!(
            "A {} that follows {of}: {largest} at {} {of_unit}",
            law.quantity,
            short(*at)
        )
    });
    let frame = Frame::new(x, y, HEIGHT_PX, claim.clone())
        .x_axis(of_unit)
        .y_unit(law.unit)
        .band(&law.band[0], &law.band[1])
        .level(Ink::Before, 0.0)
        .line(Ink::After, &law.curve, f64::INFINITY)
        .dots(Ink::After, &law.curve, 7.0);
    let drawn = format!("Free curve with its 95 % band, against {of}; the model has none");
    let words = "Dots are the knots of the table that the improved model lists.";
    card(Some(number), &claim, &drawn, &frame.markup(), words)
}
