//! The page of the reproduction: which causes explain the paper's final positions, and every number beside the computed one.

mod causes;

use maud::{Markup, html};
use slipstream_study::reproduce::{PaperRow, RecordedRun, Reproduction};

use crate::parts::{
    Cell, Frame, Icon, Ink, Page, Row, Rows, Scale, Tone, fixed, floor_scales, short, table,
    verdict,
};

/// The HTML file.
pub fn page(reproduction: &Reproduction, command_line: &str) -> String {
    let comparison = &reproduction.comparison;
    let explanation = &comparison.explanation;
    let judged = comparison.rows.iter().filter_map(|row| row.agrees);
    let (yes, all) = judged.fold((0, 0), |(yes, all), own| (yes + usize::from(own), all + 1));
    let within = explanation
        .numbers
        .iter()
        .filter(|own| own.is_within(own.after_m));
    let explained = format!(
        "{} of {} explained",
        within.count(),
        explanation.numbers.len()
    );
    let lead = html! {
        @if explanation.remains.is_empty() { "Nothing remains." } @else { "What remains: " (explanation.remains) ". " }
        "The paper: Konduri, Torres, Pagilla, Effect of Wheel Slip in the Coordination of Wheeled Mobile Robots."
    };
    let facts = format!(
        "{yes} of {all} numbers and claims agree as assumed · {} assumptions · {} experiments beyond the paper",
        comparison.assumptions.len(),
        comparison.extensions.len()
    );
    let (tone, icon) = if explanation.remains.is_empty() {
        (Tone::Good, Icon::Tick)
    } else {
        (Tone::Part, Icon::Half)
    };
    let body = html! {
        (verdict(tone, icon, &explained, &facts, &explanation.sentence, &lead))
        (causes::section(explanation))
        section id="numbers" { h2 { "Every number and claim" } (numbers(&comparison.rows)) }
        section id="open" { h2 { "What the paper leaves open" } (assumptions(reproduction)) }
        (figures(reproduction))
        section id="beyond" { h2 { "Beyond the paper" } (beyond(reproduction)) }
    };
    let page = Page {
        command: "reproduce",
        subject: "the paper".to_owned(),
        summary: explanation.sentence.clone(),
        anchors: vec![
            ("causes", "Causes"),
            ("numbers", "Numbers"),
            ("open", "Assumptions"),
            ("figures", "Figures"),
            ("beyond", "Beyond"),
            ("made", "Made by"),
        ],
        body,
        command_line: command_line.to_owned(),
        answer: serde_json::to_string(comparison).ok(),
        ..Page::default()
    };
    page.html()
}

fn numbers(rows: &[PaperRow]) -> Markup {
    let number = |value: Option<f64>| match value {
        Some(value) => Cell::number(value, fixed(value, 4)),
        None => Cell::number(f64::NAN, "–"),
    };
    let rows: Vec<Vec<Cell>> = rows
        .iter()
        .map(|row| {
            let (class, word) = match row.agrees {
                Some(true) => ("ca", "yes"),
                Some(false) => ("cb", "no"),
                None => ("cm", "–"),
            };
            vec![
                Cell::markup(html! { (row.name) div class="id" { (row.quantity) } }),
                Cell::text(row.source.as_ref()),
                number(row.paper),
                number(row.computed),
                Cell::markup(html! { b class=(class) { (word) } }),
                Cell::text(&row.note),
                Cell::text(row.depends_on.join(", ")),
            ]
        })
        .collect();
    table(
        "Every number of the paper",
        &[
            "Quantity",
            "Source",
            "Paper",
            "Computed",
            "Agrees",
            "Why",
            "Depends on",
        ],
        &rows,
    )
}

fn assumptions(reproduction: &Reproduction) -> Markup {
    let rows: Vec<Vec<Cell>> = reproduction
        .comparison
        .assumptions
        .iter()
        .map(|own| {
            let keys: Vec<String> = own
                .assumed
                .keys
                .iter()
                .map(|(key, value)| format!("{key} = {value}"))
                .collect();
            vec![
                Cell::text(own.experiment.as_ref()),
                Cell::text(&own.assumed.name),
                Cell::markup(html! { span class="id" { (keys.join(", ")) } }),
                Cell::text(&own.assumed.reason),
            ]
        })
        .collect();
    table(
        "Assumptions",
        &["Experiment", "Assumption", "Value", "Why"],
        &rows,
    )
}

/// True and counted values of some robots over time.
fn rows(id: &str, run: &RecordedRun, axis: usize, name: &str) -> Markup {
    let count = run.robots().min(3);
    let mut rows = Rows::new(id);
    let end = run.experiment.settings.duration_s;
    let all: Vec<[Vec<(f64, f64)>; 2]> = (0..count)
        .map(|robot| [run.true_line(robot, axis), run.odometry_line(robot, axis)])
        .collect();
    let y = Scale::around(all.iter().flatten().flatten().map(|p| p.1), true, 3);
    for (robot, [seen, counted]) in all.iter().enumerate() {
        let mut frame = Frame::new(
            Scale::new(0.0, end, 7),
            y,
            84,
            format!("{name} of r{} over time, true and by odometry", robot + 1),
        )
        .line(Ink::Measured, seen, f64::INFINITY)
        .line(Ink::ContextDashed, counted, f64::INFINITY);
        if robot + 1 == all.len() {
            frame = frame.x_axis("s");
        }
        rows = rows.row(
            Row::new(format!("r{} {name}", robot + 1), "m", frame)
                .reads(Ink::Measured, "true", seen, 3)
                .reads(Ink::Context, "by odometry", counted, 3)
                .legend(Ink::Measured, "true")
                .legend(Ink::ContextDashed, "by odometry"),
        );
    }
    rows.markup()
}

fn figures(reproduction: &Reproduction) -> Markup {
    let runs = &reproduction.runs;
    let profile = &runs.platoon[0].experiment.settings.profile;
    let end = runs.platoon[0].experiment.settings.duration_s;
    let corners = profile
        .times_s
        .iter()
        .copied()
        .zip(profile.speeds_m_s.iter().copied());
    let corners: Vec<(f64, f64)> = corners
        .chain(profile.speeds_m_s.last().map(|v| (end, *v)))
        .collect();
    let speed = Frame::new(
        Scale::new(0.0, end, 7),
        Scale::around(corners.iter().map(|p| p.1), true, 3),
        84,
        "Assumed speed of the front robot over time",
    )
    .x_axis("s")
    .line(Ink::Measured, &corners, f64::INFINITY);
    html! {
        section id="figures" {
            h2 { "The paper's figures" }
            h3 { "Fig. 5: single robot without the limit" } (rows("f5", &runs.single[0], 0, "x"))
            h3 { "Fig. 6: with the limit" } (rows("f6", &runs.single[1], 0, "x"))
            h3 { "Fig. 8: the assumed velocity profile, m/s" } figure { (speed.markup()) }
            h3 { "Fig. 9: platoon without the limit, x" } (rows("f9", &runs.platoon[0], 0, "x"))
            h3 { "Fig. 10: with the limit, x" } (rows("f10", &runs.platoon[1], 0, "x"))
            h3 { "Fig. 11: without the limit, y" } (rows("f11", &runs.platoon[0], 1, "y"))
            h3 { "Fig. 12: with the limit, y" } (rows("f12", &runs.platoon[1], 1, "y"))
        }
    }
}

fn beyond(reproduction: &Reproduction) -> Markup {
    let rows: Vec<Vec<Cell>> = reproduction
        .comparison
        .extensions
        .iter()
        .map(|own| {
            let number = |value: f64| Cell::number(value, fixed(value, 3));
            vec![
                Cell::text(own.experiment.as_ref()),
                Cell::text(own.law.as_ref()),
                Cell::text(own.torque_limit.as_ref()),
                number(own.slip_time_s),
                number(own.max_spacing_error_m),
                number(own.mean_final_gap_m),
                own.brisk_at_s
                    .map_or_else(|| Cell::text("never"), |t| Cell::number(t, short(t))),
            ]
        })
        .collect();
    let heads = [
        "Experiment",
        "Law",
        "Limit",
        "Slip, s",
        "Spacing error, m",
        "Odometry error, m",
        "0.6 m/s at, s",
    ];
    let paths = reproduction
        .figure_eight
        .iter()
        .zip(["paper", "computed_torque"]);
    html! {
        p class="sub" { "Turns, and the platoon over a disc of friction 0.1 (centre at x = 2.5 m, radius 1.5 m), under every torque limit. "
            "The fixed limits assume a friction of 0.24; the adaptive limit starts at 0.5 and estimates it. Eq. 11, which limits the paper's "
            "law, does not consider turns; the law computed_torque limits traction to what the floor carries beside the turn." }
        (table("Experiments beyond the paper", &heads, &rows))
        div class="cards" style="margin-top:24px" {
            @for (run, law) in paths { (eight(run, law)) }
        }
    }
}

fn eight(run: &RecordedRun, law: &str) -> Markup {
    let last = run.robots().saturating_sub(1);
    let (seen, counted) = (run.true_path(last), run.odometry_path(last));
    let [x, y] = floor_scales(seen.iter().chain(&counted).copied());
    let frame = Frame::floor(
        x,
        y,
        format!("Figure eight of the last robot under law {law}, true and by odometry"),
    )
    .x_axis("m")
    .trail(Ink::Measured, &seen)
    .trail(Ink::ContextDashed, &counted);
    html! {
        figure class="card" {
            figcaption { h3 { "Figure eight, law " (law) } "The last robot, limit inner" }
            p class="legend" { span class="cr" { i class="kl rf" {} "true" } span class="cm" { i class="kl cx da" {} "by odometry" } }
            (frame.markup())
        }
    }
}
