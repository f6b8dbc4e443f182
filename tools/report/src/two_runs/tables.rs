//! Tables of robots and links in both recordings.

use maud::{Markup, html};
use slipstream_recording::two_runs::{LinkPair, RobotPair, Slip, SpacingError};

use crate::parts::{Cell, fixed, table};
use crate::stages::{ms, stage_class, stage_name};

/// A number, or a dash where there is none.
fn number(value: Option<f64>, factor: f64, digits: usize) -> Cell {
    match value {
        Some(value) => Cell::number(value, fixed(factor * value, digits)),
        None => Cell::number(f64::NAN, "–"),
    }
}

/// Paths, spacing and slip of each robot.
pub(super) fn robots(robots: &[RobotPair]) -> Markup {
    let path = |own: &RobotPair| {
        let path = own.path;
        vec![
            Cell::text(&own.robot),
            number(path.map(|own| own.rms_m), 100.0, 1),
            number(path.map(|own| own.largest_m), 100.0, 1),
            number(path.map(|own| own.at_s), 1.0, 1),
            number(path.and_then(|own| own.noise_m), 100.0, 1),
        ]
    };
    let paths: Vec<Vec<Cell>> = robots.iter().map(path).collect();
    let spacings: Vec<Vec<Cell>> = robots.iter().filter_map(spacing).collect();
    let slips: Vec<Vec<Cell>> = robots.iter().map(slip).collect();
    html! {
        h3 { "Paths" }
        (table("Distance between the paths of each robot",
            &["Robot", "Apart, rms, cm", "Largest, cm", "At, s", "Noise alone, rms, cm"], &paths))
        @if !spacings.is_empty() {
            h3 style="margin-top:20px" { "Spacing error" }
            (table("Spacing error of each follower",
                &["Robot", "Behind", "Real, rms, cm", "Largest, cm", "Simulated, rms, cm", "Largest, cm", "Difference, rms, cm", "Largest, cm"],
                &spacings))
            p class="sub" { "Distance along the path that the robot ahead drove, minus the spacing of the formation, from 3 s on." }
        }
        h3 style="margin-top:20px" { "Slip" }
        (table("Way by the wheels and by the poses of each robot",
            &["Robot", "Real, wheels, m", "Poses, m", "Slip, m", "%", "Simulated, wheels, m", "Poses, m", "Slip, m", "%"], &slips))
        p class="sub" { "Sums over windows of 0.5 s of what the wheels roll and of how far the poses move." }
    }
}

fn spacing(own: &RobotPair) -> Option<Vec<Cell>> {
    let spacing = own.spacing.as_ref()?;
    let mut row = vec![Cell::text(&own.robot), Cell::text(&spacing.ahead)];
    for error in [spacing.errors.real, spacing.errors.simulated] {
        let error: Option<SpacingError> = error;
        row.push(number(error.map(|own| own.rms_m), 100.0, 1));
        row.push(number(error.map(|own| own.largest_m), 100.0, 1));
    }
    row.push(number(spacing.rms_difference_m, 100.0, 1));
    row.push(number(spacing.largest_difference_m, 100.0, 1));
    Some(row)
}

fn slip(own: &RobotPair) -> Vec<Cell> {
    let mut row = vec![Cell::text(&own.robot)];
    let slips = own.slip.map(|own| [own.slips.real, own.slips.simulated]);
    for slip in slips.unwrap_or_default() {
        let metres = |of: fn(Slip) -> f64| number(slip.map(of), 1.0, 2);
        row.extend([metres(|own| own.wheels_m), metres(|own| own.poses_m)]);
        row.push(metres(|own| own.slip_m));
        row.push(number(slip.and_then(|own| own.slip_percent), 1.0, 1));
    }
    row
}

/// Stages of each link.
pub(super) fn links(links: &[LinkPair]) -> Markup {
    let row = |(link, stage): (&LinkPair, usize)| {
        let stage = &link.stages[stage];
        let name = html! { i class=(format!("sw {}", stage_class(&stage.stage))) {} " " (stage_name(&stage.stage)) };
        let mut row = vec![
            Cell::text(format!("{} → {}", link.from, link.to)),
            Cell::markup(name),
        ];
        for delay in [stage.delays.real, stage.delays.simulated] {
            for value in [delay.map(|own| own.p50_s), delay.map(|own| own.p95_s)] {
                row.push(value.map_or_else(
                    || Cell::number(f64::NAN, "–"),
                    |value| Cell::number(value, ms(value)),
                ));
            }
        }
        row.push(Cell::text(match stage.changed {
            Some(true) => "changed",
            _ => "",
        }));
        row
    };
    let stages = links
        .iter()
        .flat_map(|link| (0..link.stages.len()).map(move |stage| (link, stage)));
    let rows: Vec<Vec<Cell>> = stages.map(row).collect();
    html! {
        p class="sub" { "From the encoder of the sender to the torque of the receiver, in ms." }
        (table("Delays of each link in both recordings",
            &["Link", "Stage", "Real, p50", "p95", "Simulated, p50", "p95", "Change"], &rows))
    }
}
