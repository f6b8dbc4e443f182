//! The page of a study of communication delay: what a delay does to the platoon, beside Eq. 13 and 14.

mod pictures;

use maud::{Markup, html};
use slipstream_study::delay::{Point, Study, Table};

use crate::parts::{Cell, Icon, Page, Tone, fixed, short, table, verdict};

/// The HTML file.
pub fn page(study: &Study, command_line: &str) -> String {
    let sentence = study.sentence();
    let grid = &study.grid;
    let beyond = study.points.iter().map(|own| own.beyond_bound).sum::<f64>();
    let beyond_percent = 100.0 * beyond / study.points.len().max(1) as f64;
    let runs = u64::from(grid.runs) * study.points.len() as u64;
    let facts = format!(
        "{} robots · {} points · {} runs",
        grid.robots,
        fixed(study.points.len() as f64, 0),
        fixed(runs as f64, 0)
    );
    let (tone, icon, chip) = if study.interrupted {
        (Tone::Part, Icon::Half, "Interrupted".to_owned())
    } else {
        let icon = if beyond == 0.0 {
            Icon::Tick
        } else {
            Icon::Half
        };
        let tone = if beyond == 0.0 {
            Tone::Good
        } else {
            Tone::Part
        };
        let chip = match beyond == 0.0 {
            true => "Eq. 14 bounds every tick".to_owned(),
            false => format!(
                "Eq. 14 is exceeded at {}\u{202f}% of the ticks",
                short(beyond_percent)
            ),
        };
        (tone, icon, chip)
    };
    let lead = html! {
        "Maxima are over the followers' outer ticks from the start of coordination on and over all runs; slip and gains are means over "
        "the runs. In Eq. 13 and 14, τ is the mean age of the position in use."
    };
    let body = html! {
        (verdict(tone, icon, &chip, &facts, &sentence, &lead))
        (pictures::section(study))
        @if !study.answers.is_empty() {
            section id="answers" class="answers" {
                h2 { "Questions and answers" }
                @for own in &study.answers {
                    h3 { (own.question) } p { (own.answer) }
                    @if let Some(own) = &own.table { (answer_table(own)) }
                }
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

fn answer_table(own: &Table) -> Markup {
    let heads: Vec<&str> = own.heads.iter().map(String::as_str).collect();
    let cell = |text: &String| match text.parse::<f64>() {
        Ok(value) => Cell::number(value, text.replace('-', "−")),
        Err(_) => Cell::text(text),
    };
    let rows: Vec<Vec<Cell>> = own
        .rows
        .iter()
        .map(|row| row.iter().map(cell).collect())
        .collect();
    table("What the answer says, as a table", &heads, &rows)
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
