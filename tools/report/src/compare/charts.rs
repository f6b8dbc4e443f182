//! The charts of one robot: every quantity measured and simulated, their distance, and the path beside them.

use maud::{Markup, html};
use slipstream_recording::Channel;

use super::apart::Apart;
use crate::parts::{
    Frame, Ink, Points, Row, Rows, Scale, Way, capital, floor_scales, gap_of, short, with_unit,
};

/// Height of a chart.
const HEIGHT_PX: u32 = 78;
/// Share of a quantity's range below which its two lines cannot be told apart.
const COINCIDE: f64 = 0.01;

/// The charts of one robot: distance, channels, and the path beside them.
pub(super) fn robot(
    channels: &[Channel],
    apart: &Apart<'_>,
    place: usize,
    columns: usize,
) -> Markup {
    let own: Vec<&Channel> = channels.iter().filter(|c| c.robot == apart.robot).collect();
    let ends = own
        .iter()
        .flat_map(|c| c.recorded.first().into_iter().chain(c.recorded.last()));
    let [low, high] = ends.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], p| {
        [low.min(p.0), high.max(p.0)]
    });
    let x = Scale::new(low, high, 7);
    let mut rows = Rows::new(format!("c{place}"));
    let has_distance = !apart.distance.is_empty();
    for (index, channel) in own.iter().enumerate() {
        let is_last = index + 1 == own.len() && !has_distance;
        rows = rows.row(channel_row(channel, x, columns, is_last));
    }
    if has_distance {
        rows = rows.row(distance_row(apart, x, columns));
    }
    if let Some((t_s, _)) = Apart::largest(&apart.distance) {
        rows = rows.cursor_at(t_s);
    }
    let find = |name: &str| own.iter().find(|c| c.name == name);
    if let (Some(cx), Some(cy)) = (find("pose x"), find("pose y")) {
        let seen = way(&cx.recorded, &cy.recorded);
        let simulated = way(&within(&cx.simulated, x), &within(&cy.simulated, x));
        let [a, b] =
            [&seen, &simulated].map(|own| own.iter().map(|p| (p.1, p.2)).collect::<Points>());
        let scales = floor_scales(a.iter().chain(&b).copied());
        let mut frame = Frame::floor(
            scales[0],
            scales[1],
            "Measured and simulated path on the floor, in metres",
        )
        .x_axis("m")
        .trail(Ink::Measured, &a)
        .trail(Ink::Before, &b);
        if let Some(start) = a.first() {
            frame = frame.dots(Ink::Measured, &[*start], 7.0).label(
                Ink::Measured,
                [start.0, start.1],
                "start",
            );
        }
        rows = rows.floor(
            frame,
            scales,
            [(Ink::Measured, seen), (Ink::Before, simulated)],
        );
    }
    html! {
        p class="legend" {
            span class="cr" { i class="kl rf" {} "measured" }
            span class="cb" { i class="kl bf" {} "simulated" }
        }
        (rows.markup())
    }
}

fn distance_row(apart: &Apart<'_>, x: Scale, columns: usize) -> Row {
    let y = Scale::around(apart.distance.iter().map(|p| p.1), true, 3);
    let described = "Distance between measured and simulated place, cm";
    let frame = Frame::new(x, y, HEIGHT_PX, described)
        .columns(columns)
        .filled(Ink::Before, &apart.distance)
        .line(Ink::Before, &apart.distance, gap_of(&apart.distance))
        .x_axis("s");
    Row::new("Distance apart", "cm", frame)
        .reads(Ink::Before, "cm", &apart.distance, 1)
        .reads(Ink::Before, "degrees", &apart.heading, 1)
}

/// A quantity, measured and simulated. Where the two lie on each other their difference is drawn.
fn channel_row(channel: &Channel, x: Scale, columns: usize, is_last: bool) -> Row {
    let (factor, unit) = match channel.unit {
        "rad" => (1.0_f64.to_degrees(), "degrees"),
        unit => (1.0, unit),
    };
    let scaled = |points: &[(f64, f64)]| -> Points {
        points.iter().map(|(t, v)| (*t, factor * v)).collect()
    };
    let (recorded, simulated) = (
        scaled(&channel.recorded),
        within(&scaled(&channel.simulated), x),
    );
    let rms = channel.rms_difference().map(|own| factor * own);
    let [low, high] = recorded
        .iter()
        .fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], p| {
            [low.min(p.1), high.max(p.1)]
        });
    let coincide = rms.is_some_and(|rms| rms < COINCIDE * (high - low));
    let differences: Points = scaled(&channel.differences());
    let drawn: Points = match coincide {
        true => differences.clone(),
        false => recorded.iter().chain(&simulated).copied().collect(),
    };
    let y = Scale::around(drawn.iter().map(|p| p.1), true, 3);
    let y = if unit == "degrees" { y.of_degrees() } else { y };
    let name = title(&channel.name);
    let frame = Frame::new(
        x,
        y,
        HEIGHT_PX,
        format!("{name}, measured and simulated over time, {unit}"),
    );
    let mut frame = match coincide {
        true => frame
            .columns(columns)
            .line(Ink::Before, &differences, gap_of(&differences)),
        false => frame
            .columns(columns)
            .line(Ink::Measured, &recorded, gap_of(&recorded))
            .line(Ink::Before, &simulated, f64::INFINITY),
    };
    if is_last {
        frame = frame.x_axis("s");
    }
    let digits = (Scale::around(recorded.iter().map(|p| p.1), true, 3).digits() + 2).min(4);
    let title = if coincide {
        format!("{name}, simulated minus measured")
    } else {
        name
    };
    let said = match rms {
        Some(rms) => {
            let sign = if unit == "degrees" { "°" } else { unit };
            let rms = with_unit(&short(rms), sign);
            format!("{unit}, rms difference {rms}")
        }
        None => unit.to_owned(),
    };
    Row::new(title, said, frame)
        .reads(Ink::Measured, "measured", &recorded, digits)
        .reads(Ink::Before, "simulated", &simulated, digits)
}

/// What a channel is called on the page.
fn title(name: &str) -> String {
    match name {
        "pose x" => "x".to_owned(),
        "pose y" => "y".to_owned(),
        "pose yaw" => "Heading".to_owned(),
        other => capital(other),
    }
}

fn way(x: &[(f64, f64)], y: &[(f64, f64)]) -> Way {
    x.iter()
        .zip(y)
        .map(|((t, x), (_, y))| (*t, *x, *y))
        .collect()
}

fn within(points: &[(f64, f64)], x: Scale) -> Points {
    points
        .iter()
        .copied()
        .filter(|p| p.0 >= x.low && p.0 <= x.high)
        .collect()
}
