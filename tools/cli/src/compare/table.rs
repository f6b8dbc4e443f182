//! Tables of two recordings beside each other for the terminal.

use std::fmt::Write as _;

use slipstream_recording::two_runs::{LinkPair, RobotPair, Slip, SpacingError, TwoRuns};

/// The tables of an answer. Writing to a string cannot fail.
pub(super) fn table(answer: &TwoRuns) -> String {
    let mut text = String::new();
    let _ = writeln!(
        text,
        "\nPaths apart, as measured (cm)       rms   largest    at (s)   noise alone"
    );
    for pair in &answer.robots {
        let _ = writeln!(text, "{}", path(pair));
    }
    if answer.robots.iter().any(|own| own.spacing.is_some()) {
        spacing(&mut text, &answer.robots);
    }
    if answer.robots.iter().any(|own| own.slip.is_some()) {
        slip(&mut text, &answer.robots);
    }
    for link in &answer.links {
        delays(&mut text, link);
    }
    text.push('\n');
    text
}

fn path(pair: &RobotPair) -> String {
    let path = pair.path;
    let rms = number(path.map(|own| own.rms_m), 100.0, 1);
    let largest = number(path.map(|own| own.largest_m), 100.0, 1);
    let at = number(path.map(|own| own.at_s), 1.0, 2);
    let noise = number(path.and_then(|own| own.noise_m), 100.0, 1);
    let robot = &pair.robot;
    format!("  {robot:28} {rms:>8} {largest:>9} {at:>9} {noise:>13}")
}

fn spacing(text: &mut String, robots: &[RobotPair]) {
    let _ = writeln!(
        text,
        "\nSpacing error (cm)                 real           simulated       real − simulated\n{:31}rms  largest      rms  largest        rms  largest",
        ""
    );
    for pair in robots {
        let Some(spacing) = &pair.spacing else {
            continue;
        };
        let errors = [spacing.errors.real, spacing.errors.simulated];
        let [here, there] = errors.map(|own: Option<SpacingError>| {
            let rms = number(own.map(|own| own.rms_m), 100.0, 1);
            let largest = number(own.map(|own| own.largest_m), 100.0, 1);
            format!("{rms:>5} {largest:>8}")
        });
        let rms = signed(spacing.rms_difference_m, 100.0, 1);
        let largest = signed(spacing.largest_difference_m, 100.0, 1);
        let who = format!("{} behind {}", pair.robot, spacing.ahead);
        let _ = writeln!(
            text,
            "  {who:27}{here}   {there}      {rms:>5} {largest:>8}"
        );
    }
}

fn slip(text: &mut String, robots: &[RobotPair]) {
    let _ = writeln!(
        text,
        "\nWay, and slip (m)                  real                        simulated\n{:31}wheels  poses  slip     %     wheels  poses  slip     %",
        ""
    );
    for pair in robots {
        let slips = pair.slip.map(|own| [own.slips.real, own.slips.simulated]);
        let [here, there] = slips.unwrap_or_default().map(|own: Option<Slip>| {
            let metres = |of: fn(&Slip) -> f64| number(own.as_ref().map(of), 1.0, 2);
            let [wheels, poses] = [metres(|own| own.wheels_m), metres(|own| own.poses_m)];
            let slip = signed(own.map(|own| own.slip_m), 1.0, 2);
            let percent = signed(own.and_then(|own| own.slip_percent), 1.0, 1);
            format!("{wheels:>6} {poses:>6} {slip:>5} {percent:>5}")
        });
        let robot = &pair.robot;
        let _ = writeln!(text, "  {robot:28} {here}     {there}");
    }
}

fn delays(text: &mut String, link: &LinkPair) {
    let title = format!("{} → {}, delays (ms)", link.from, link.to);
    let _ = writeln!(
        text,
        "\n{title:35}real           simulated\n{:31}p50      p95      p50      p95",
        ""
    );
    for stage in &link.stages {
        let delays = [stage.delays.real, stage.delays.simulated];
        let [here, there] = delays.map(|own| {
            let p50 = number(own.map(|own| own.p50_s), 1e3, 2);
            let p95 = number(own.map(|own| own.p95_s), 1e3, 2);
            format!("{p50:>8} {p95:>8}")
        });
        let changed = match stage.changed {
            Some(true) => "  changed",
            _ => "",
        };
        let name = &stage.stage;
        let _ = writeln!(text, "  {name:24}{here} {there}{changed}");
    }
}

/// A number, or `-` where there is none.
fn number(value: Option<f64>, factor: f64, digits: usize) -> String {
    value.map_or_else(
        || "-".to_owned(),
        |value| format!("{:.digits$}", factor * value),
    )
}

/// A number with its sign; without one where it is 0 to the last digit.
fn signed(value: Option<f64>, factor: f64, digits: usize) -> String {
    let text = number(value, factor, digits);
    let is_zero = text.bytes().all(|byte| matches!(byte, b'0' | b'.' | b'-'));
    match value {
        Some(_) if is_zero => text.trim_start_matches('-').to_owned(),
        Some(value) if value > 0.0 => format!("+{text}"),
        _ => text,
    }
}
