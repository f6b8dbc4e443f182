//! The page of a study of communication delay: what a delay does to the platoon, beside Eq. 13 and 14.

use maud::{Markup, html};
use slipstream_study::delay::{Cell as Key, Point, Study};

use crate::parts::{Cell, Frame, Icon, Ink, Page, Scale, Tone, card, fixed, short, table, verdict};

/// Pictures of each kind at most.
const PICTURES: usize = 12;

/// The HTML file.
pub fn page(study: &Study, command_line: &str) -> String {
    let sentence = sentence(&study.points);
    let grid = &study.grid;
    let beyond = study
        .points
        .iter()
        .filter(|own| own.beyond_bound > 0.0)
        .count();
    let runs = u64::from(grid.runs) * study.points.len() as u64;
    let facts = format!(
        "{} robots · {} points · {} runs",
        grid.robots,
        fixed(study.points.len() as f64, 0),
        fixed(runs as f64, 0)
    );
    let (tone, icon, chip) = if study.interrupted {
        (Tone::Part, Icon::Half, "Interrupted".to_owned())
    } else if beyond == 0 {
        (
            Tone::Good,
            Icon::Tick,
            "Eq. 14 bounds every point".to_owned(),
        )
    } else {
        (
            Tone::Bad,
            Icon::Apart,
            format!(
                "Eq. 14 is exceeded at {beyond} of {} points",
                study.points.len()
            ),
        )
    };
    let lead = html! {
        "Maxima are over the followers' outer ticks from the start of coordination on and over all runs; slip and gains are means over "
        "the runs. In Eq. 13 and 14, τ is the mean age of the position in use."
    };
    let body = html! {
        (verdict(tone, icon, &chip, &facts, &sentence, &lead))
        (pictures(&study.points))
        @if !study.answers.is_empty() {
            section id="answers" {
                h2 { "Questions and answers" }
                @for own in &study.answers { h3 { (own.question) } p { (own.answer) } }
            }
        }
        section id="points" {
            h2 { "Every point" }
            (points(&study.points))
        }
    };
    let page = Page {
        command: "study",
        subject: "delay".to_owned(),
        summary: sentence.clone(),
        anchors: vec![
            ("pictures", "Pictures"),
            ("answers", "Answers"),
            ("points", "Every point"),
            ("made", "Made by"),
        ],
        body,
        command_line: command_line.to_owned(),
        answer: serde_json::to_string(study).ok(),
        ..Page::default()
    };
    page.html()
}

/// What the longest delay does, in a sentence.
fn sentence(points: &[Point]) -> String {
    let Some(first) = points.first() else {
        return "No point was computed.".to_owned();
    };
    let own: Vec<&Point> = points
        .iter()
        .filter(|point| {
            Key {
                delay_s: point.cell.delay_s,
                ..first.cell.clone()
            } == point.cell
        })
        .collect();
    let least = own
        .iter()
        .min_by(|a, b| a.cell.delay_s.total_cmp(&b.cell.delay_s));
    let most = own
        .iter()
        .max_by(|a, b| a.cell.delay_s.total_cmp(&b.cell.delay_s));
    let cm = |point: &Point| short(100.0 * point.max_spacing_error_m);
    match (least, most) {
        (Some(least), Some(most)) if most.cell.delay_s > least.cell.delay_s => {
            let (a, b) = (least.max_spacing_error_m, most.max_spacing_error_m);
            let verb = if b > 1.02 * a {
                "grows"
            } else if b < 0.98 * a {
                "falls"
            } else {
                "stays"
            };
            if verb == "stays" {
                format!(
                    "A delay of {} ms on each link leaves the largest spacing error at {} cm.",
                    short(1000.0 * most.cell.delay_s),
                    cm(most)
                )
            } else {
                format!(
                    "From {} to {} ms of delay on each link, the largest spacing error {verb} from {} to {} cm.",
                    short(1000.0 * least.cell.delay_s),
                    short(1000.0 * most.cell.delay_s),
                    cm(least),
                    cm(most)
                )
            }
        }
        _ => format!(
            "At a delay of {} ms the largest spacing error is {} cm.",
            short(1000.0 * first.cell.delay_s),
            cm(first)
        ),
    }
}

/// For each set of the other keys: desired speed with the bound, and spacing error, over the delay.
fn pictures(points: &[Point]) -> Markup {
    let mut sets: Vec<Key> = Vec::new();
    for point in points {
        let key = Key {
            delay_s: 0.0,
            ..point.cell.clone()
        };
        if !sets.contains(&key) {
            sets.push(key);
        }
    }
    let of = |key: &Key| -> Vec<&Point> {
        let own = points.iter().filter(|p| {
            Key {
                delay_s: 0.0,
                ..p.cell.clone()
            } == *key
        });
        let mut own: Vec<&Point> = own.collect();
        own.sort_by(|a, b| a.cell.delay_s.total_cmp(&b.cell.delay_s));
        own
    };
    let speeds = points
        .iter()
        .flat_map(|p| [p.max_desired_speed_m_s, p.bound_eq14_m_s]);
    let speed = Scale::around(speeds, true, 4);
    let spacing = Scale::around(
        points.iter().map(|p| 100.0 * p.max_spacing_error_m),
        true,
        4,
    );
    let delay = Scale::around(points.iter().map(|p| 1000.0 * p.cell.delay_s), true, 4);
    let left = sets.len().saturating_sub(PICTURES);
    html! {
        section id="pictures" class="first" {
            h2 { "Against the delay on each link" }
            p class="sub" { "Left: largest desired speed before limiting, in m/s. "
                span class="ca" { i class="kl af" {} "measured" } "  "
                span class="cr" { i class="kl rf" {} "bound of Eq. 14" } "  "
                span class="cm" { i class="kl cx da" {} "Eq. 13 as a transport delay" } ". Right: largest true spacing error, in cm." }
            div class="cards" {
                @for key in sets.iter().take(PICTURES) {
                    @let own = of(key);
                    @let line = |quantity: fn(&Point) -> f64| own.iter().map(|p| (1000.0 * p.cell.delay_s, quantity(p))).collect::<Vec<_>>();
                    @let measured = line(|p| p.max_desired_speed_m_s);
                    @let errors = line(|p| 100.0 * p.max_spacing_error_m);
                    (card(None, &other_keys(key), "Desired speed, m/s",
                        &Frame::new(delay, speed, 160, format!("Largest desired speed against delay; {}", other_keys(key)))
                            .x_axis("ms")
                            .line(Ink::Measured, &line(|p| p.bound_eq14_m_s), f64::INFINITY)
                            .line(Ink::ContextDashed, &line(|p| p.transport_delay_m_s), f64::INFINITY)
                            .line(Ink::After, &measured, f64::INFINITY)
                            .dots(Ink::After, &measured, 7.0).markup(), ""))
                    (card(None, &other_keys(key), "Spacing error, cm",
                        &Frame::new(delay, spacing, 160, format!("Largest spacing error against delay; {}", other_keys(key)))
                            .x_axis("ms")
                            .line(Ink::After, &errors, f64::INFINITY)
                            .dots(Ink::After, &errors, 7.0).markup(), ""))
                }
            }
            @if left > 0 { p class="sub" { (left) " more combinations are in the table." } }
        }
    }
}

fn other_keys(key: &Key) -> String {
    format!(
        "{}, k_x {} 1/s, limit {}, jitter {} ms, loss {}\u{202f}%",
        key.protocol,
        short(key.k_x),
        key.torque_limit,
        short(1000.0 * key.jitter_s),
        short(100.0 * key.loss)
    )
}

fn points(points: &[Point]) -> Markup {
    let heads = [
        "Protocol",
        "Limit",
        "k_x, 1/s",
        "Loss, %",
        "Jitter, ms",
        "Delay, ms",
        "Age, ms",
        "Largest v_d, m/s",
        "Eq. 14, m/s",
        "Eq. 13 literal, m/s",
        "Transport, m/s",
        "Slip, s",
        "Spacing error, cm",
        "String gain",
    ];
    let rows: Vec<Vec<Cell>> = points
        .iter()
        .map(|p| {
            let key = &p.cell;
            let number = |value: f64| Cell::number(value, short(value));
            let mut row = vec![Cell::text(&key.protocol), Cell::text(&key.torque_limit)];
            row.extend(
                [
                    key.k_x,
                    100.0 * key.loss,
                    1000.0 * key.jitter_s,
                    1000.0 * key.delay_s,
                    1000.0 * p.age_s,
                ]
                .map(number),
            );
            let sizes = [
                p.max_desired_speed_m_s,
                p.bound_eq14_m_s,
                p.literal_eq13_m_s,
                p.transport_delay_m_s,
                p.slip_time_s,
            ];
            row.extend(sizes.map(|value| Cell::number(value, fixed(value, 3))));
            row.push(Cell::number(
                p.max_spacing_error_m,
                fixed(100.0 * p.max_spacing_error_m, 1),
            ));
            row.push(p.string_gain.map_or_else(
                || Cell::number(f64::NAN, "–"),
                |gain| Cell::number(gain, fixed(gain, 2)),
            ));
            row
        })
        .collect();
    table("Every point of the study", &heads, &rows)
}
