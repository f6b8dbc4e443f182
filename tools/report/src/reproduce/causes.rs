//! The causes that explain the paper's final positions, as switches, over printed and computed numbers by figure.

use maud::{Markup, html};
use slipstream_study::reproduce::{Cause, Explanation, FinalPosition, HeldOut};

use crate::parts::{
    Cell, Scale, badge, capital, digits_of, fixed, interval, short, table, with_unit,
};

/// A figure of the paper: its number, and which numbers belong to it.
const FIGURES: [(u32, &str, &str, &str); 4] = [
    (9, "x", "without_limit", "x without the limit"),
    (10, "x", "with_limit", "x with the limit"),
    (11, "y", "without_limit", "y without the limit"),
    (12, "y", "with_limit", "y with the limit"),
];

/// The section.
pub(super) fn section(explanation: &Explanation) -> Markup {
    let off =
        |own: &FinalPosition| [own.before_m, own.after_m].map(|m| 100.0 * (m - own.printed_m));
    let all = explanation.numbers.iter().flat_map(off);
    let tape_cm = 100.0 * explanation.tape_m;
    let scale = Scale::around(all.chain([-tape_cm, tape_cm]), true, 5);
    html! {
        section class="first" id="causes" {
            h2 { "Causes" }
            p class="sub" { "Each number differs from the printed one by what the causes do together. "
                span class="script" { "Switch a cause off to see what it does." } }
            div data-causes="" class="why" { div { (switches(explanation)) } div {
                p class="legend" { span class="cb" { "| as assumed" } span class="ca" { "● with the causes that are on" }
                    span class="cm" { "shaded: the tape, ±" (short(tape_cm)) " cm" } }
                div class="figs" {
                    @for figure in FIGURES { (of_figure(explanation, figure, scale)) }
                }
            } }
            h3 style="margin-top:28px" { "What the other numbers predict" }
            p class="sub" { "An experiment or a robot is left out, the causes are chosen and fitted without it, and predict its numbers." }
            (held_out(&explanation.held_out))
        }
    }
}

fn switches(explanation: &Explanation) -> Markup {
    html! {
        ol class="causes" { @for (place, cause) in explanation.causes.iter().enumerate() { li {
            label { input type="checkbox" checked data-cause=(place) aria-label=(format!("Cause {}: on", place + 1)); " " (badge(place + 1)) " " b { (capital(&cause.sentence)) } " " span class="cm" { (sized(cause)) } }
            p class="sub" { "Without it, " (short(100.0 * cause.without_it_m)) " cm would be left in place of "
                (short(100.0 * explanation.after_m)) " cm (root mean square)."
                @if !cause.rivals.is_empty() { " It could also be that " (cause.rivals.join(", or that ")) "." } }
        } } }
    }
}

/// The interval of a size, in the direction of the sentence.
fn sized(cause: &Cause) -> String {
    let (factor, unit) = match (cause.unit.as_str(), cause.cause.as_str()) {
        ("m", _) => (100.0, "cm"),
        ("rad", _) => (1.0_f64.to_degrees(), "°"),
        ("1", "floor_friction") => (1.0, ""),
        ("1", _) => (100.0, "%"),
        (other, _) => (1.0, other),
    };
    let mut ends = cause.ci95.map(|own| factor * own * cause.estimate.signum());
    ends.sort_by(f64::total_cmp);
    let [low, high] = ends;
    let text = interval(low, high, digits_of(ends));
    format!("95\u{202f}% interval {}", with_unit(&text, unit))
}

fn of_figure(
    explanation: &Explanation,
    (number, axis, experiment, title): (u32, &str, &str, &str),
    scale: Scale,
) -> Markup {
    let at = |cm: f64| format!("left:{:.2}%", 100.0 * scale.place(cm).clamp(0.0, 1.0));
    let tape_cm = 100.0 * explanation.tape_m;
    let band = [-tape_cm, tape_cm].map(|cm| 100.0 * scale.place(cm));
    let own = explanation.numbers.iter().enumerate();
    let own = own.filter(|(_, own)| own.axis == axis && own.experiment == experiment);
    let [low, high] = [scale.low, scale.high];
    html! {
        div {
            h3 { "Fig. " (number) ": final " (title) }
            div class="tw" tabindex="0" role="region" aria-label=(format!("Final {title}")) { table class="ro" {
                thead { tr {
                    th scope="col" { "Robot" } th scope="col" class="num" { "Printed, m" }
                    th scope="col" class="num opt" { "Assumed" } th scope="col" class="num" { "With causes" }
                    th scope="col" class="dotc" { span class="ax" {
                        @for (value, text) in scale.ticks() { span style=(at(value)) { (text) @if value == 0.0 { " cm" } } }
                    } }
                } }
                tbody { @for (place, own) in own {
                    @let by = if own.by == "tape" { "tape" } else { "encoders" };
                    tr {
                        td { (own.robot) ", " (by) }
                        td class="num" { (fixed(own.printed_m, if own.printed_m.abs() < 0.01 { 3 } else { 2 })) }
                        td class="num opt" { (fixed(own.before_m, 3)) }
                        td class="num" data-after=(place) { (fixed(own.after_m, 3)) }
                        td class="dotc" { span class="ig" role="img" data-low=(low) data-high=(high) data-place=(place)
                            aria-label=(format!("{} {axis} by {by}: {} cm off as assumed, {} cm with the causes", own.robot,
                                fixed(100.0 * (own.before_m - own.printed_m), 1), fixed(100.0 * (own.after_m - own.printed_m), 1))) {
                            i class="r" style=(format!("left:{:.2}%;width:{:.2}%", band[0], band[1] - band[0])) {}
                            i class="w" style=(at(100.0 * (own.before_m - own.printed_m))) {}
                            i class="e" style=(at(100.0 * (own.after_m - own.printed_m))) {}
                        } }
                    }
                } }
            } }
        }
    }
}

fn held_out(all: &[HeldOut]) -> Markup {
    let row = |own: &HeldOut| {
        let name = match own.left_out.as_str() {
            "without_limit" => "The experiment without the limit",
            "with_limit" => "The experiment with the limit",
            robot => robot,
        };
        let cm = |m: f64| Cell::number(m, fixed(100.0 * m, 1));
        vec![
            Cell::text(name),
            cm(own.before_m),
            cm(own.after_m),
            Cell::text(capital(&own.causes.join("; "))),
        ]
    };
    let rows: Vec<Vec<Cell>> = all.iter().map(row).collect();
    let heads = [
        "Left out",
        "As assumed, cm",
        "Predicted, cm",
        "Causes that the others show",
    ];
    table(
        "What is left of numbers that were held out, root mean square",
        &heads,
        &rows,
    )
}
