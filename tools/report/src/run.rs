//! The page of a run: how the formation held, which wheels slipped, what became of the messages.

use maud::{Markup, html};
use slipstream_bus::Experiment;
use slipstream_launch::RunSummary;
use slipstream_launch::summary::{RobotSummary, Stream};
use slipstream_recording::recording::{Recording, Robot};

use crate::parts::{
    Cell, Fact, Frame, Icon, Ink, Page, Points, Row, Rows, Scale, Tone, Way, capital, fixed,
    floor_scales, short, table, verdict,
};

/// Robots that are drawn.
const DRAWN: usize = 6;
/// Time over which a speed on the floor is averaged (s).
const AVERAGED_S: f64 = 0.3;
/// Points of a line at most before it is thinned.
const POINTS: usize = 6000;
/// Height of a chart (pixels).
const HEIGHT_PX: u32 = 84;
/// Columns of each line.
const COLUMNS: usize = 900;

/// What the page shows.
pub struct Run<'a> {
    /// The summary.
    pub summary: &'a RunSummary,
    /// What was run.
    pub experiment: &'a Experiment,
    /// What was recorded.
    pub recording: &'a Recording,
    /// The command that made it.
    pub command_line: String,
    /// Program and files.
    pub facts: Vec<Fact>,
}

/// The HTML file.
pub fn page(run: &Run<'_>) -> String {
    let summary = run.summary;
    let sentence = sentence(summary);
    let lost: u64 = summary.links.iter().map(|own| own.lost).sum();
    let missed: u64 = summary.deadlines.iter().map(|own| own.missed).sum();
    let (chip, tone, icon) = match slip_s(&summary.robots) {
        None => ("Slip is not known", Tone::Part, Icon::Half),
        Some(0.0) => ("No wheel slipped", Tone::Good, Icon::Tick),
        Some(_) => ("Wheels slipped", Tone::Bad, Icon::Apart),
    };
    let sent: u64 = summary.links.iter().map(|own| own.sent).sum();
    let facts = format!(
        "{} · {} robots · {} s · {} positions sent, {lost} lost · {missed} deadlines missed",
        summary.experiment,
        summary.robots.len(),
        short(summary.duration_s),
        fixed(sent as f64, 0)
    );
    let body = html! {
        (verdict(tone, icon, chip, &facts, &sentence, &lead(summary)))
        section class="first" { (charts(run)) }
        section { h2 { "Robots" } (robots(summary)) }
        @if summary.robots.iter().any(|own| own.real.is_some()) {
            section { h2 { "What real robots told and were told" } (real(summary)) }
        }
        section { h2 { "Links" } (links(summary)) }
        @if !summary.deadlines.is_empty() { section { h2 { "Deadlines" } (deadlines(summary)) } }
    };
    let mut facts: Vec<Fact> = vec![(
        "State hash",
        html! { span class="id" { (summary.state_hash) } " (SHA-256 over every plant step)" },
    )];
    facts.extend(run.facts.iter().cloned());
    let page = Page {
        command: "run",
        subject: summary.experiment.clone(),
        summary: sentence,
        body,
        command_line: run.command_line.clone(),
        facts,
        answer: serde_json::to_string(summary).ok(),
        ..Page::default()
    };
    page.html()
}

fn slip_s(robots: &[RobotSummary]) -> Option<f64> {
    let known = robots.iter().filter_map(|own| own.slip_time_s);
    let each = known.map(|[right, left]| right + left);
    each.reduce(|all, own| all + own)
}

fn sentence(summary: &RunSummary) -> String {
    let count = summary.robots.len();
    let who = if count == 1 {
        "One robot".to_owned()
    } else {
        format!("{count} robots")
    };
    let spacing = summary.max_spacing_error_m().unwrap_or(0.0);
    let slip = slip_s(&summary.robots);
    let held = if count > 1 {
        format!(
            " The spacing is off by {} cm at most",
            short(100.0 * spacing)
        )
    } else {
        String::new()
    };
    let slipped = match slip {
        None => "whether wheels slipped is not known".to_owned(),
        Some(0.0) => "no wheel slipped".to_owned(),
        Some(slip) => format!("wheels slipped for {} s in all", short(slip)),
    };
    let rest = if held.is_empty() {
        format!(" {}", capital(&slipped))
    } else {
        format!("{held}; {slipped}")
    };
    format!("{who} drove for {} s.{rest}.", short(summary.duration_s))
}

fn lead(summary: &RunSummary) -> Markup {
    let gaps = summary.robots.iter().filter_map(|own| {
        let (a, b) = (own.final_true?, own.final_odometry?);
        Some((own.robot.as_str(), (a[0] - b[0]).hypot(a[1] - b[1])))
    });
    let worst = gaps.max_by(|a, b| a.1.total_cmp(&b.1));
    html! {
        @match worst {
            Some((robot, gap)) => { "At the end, the odometry of " (robot) " is off by " b class="cb" { (short(100.0 * gap)) " cm" }
                ": what its encoders could not see." }
            None => "The robots have no odometry.",
        }
        @if let Some(sentence) = summary.delay_sentence() { " " (sentence) }
    }
}

/// What is drawn of one robot.
struct DrawnRobot<'a> {
    name: &'a str,
    way: Way,
    by_wheels: Points,
    on_floor: Points,
    /// Distance to the robot ahead, and its name.
    gap: Option<(Points, &'a str)>,
}

fn charts(run: &Run<'_>) -> Markup {
    let seen = run.recording.robots.iter().filter(|own| own.pose.is_some());
    let left = seen.clone().count().saturating_sub(DRAWN);
    let mut drawn: Vec<DrawnRobot<'_>> = Vec::new();
    for robot in seen.take(DRAWN) {
        let way = places(robot);
        let gap = drawn
            .last()
            .map(|ahead| (distances(&ahead.way, &way), ahead.name));
        drawn.push(DrawnRobot {
            name: &robot.name,
            by_wheels: by_wheels(robot),
            on_floor: on_floor(&way),
            gap,
            way,
        });
    }
    let rows = rows(run, &drawn);
    html! {
        @if rows.is_empty() { p class="sub" { "The recording has no poses." } } @else { (rows.markup()) }
        @if left > 0 { p class="sub" { (left) " more robots are in the table." } }
    }
}

fn rows(run: &Run<'_>, drawn: &[DrawnRobot<'_>]) -> Rows {
    let x = Scale::new(0.0, run.summary.duration_s, 7);
    let speeds = drawn
        .iter()
        .flat_map(|own| own.by_wheels.iter().chain(&own.on_floor));
    let speed = Scale::around(speeds.map(|p| p.1), true, 3);
    let spacing_m = run.experiment.settings.formation.spacing_m;
    let gaps = drawn.iter().filter_map(|own| own.gap.as_ref());
    let gaps = gaps.flat_map(|(points, _)| points.iter().map(|p| p.1));
    let gap = Scale::around(gaps.chain([spacing_m]), false, 3);
    let mut rows = Rows::new("run");
    for (index, own) in drawn.iter().enumerate() {
        if let Some((points, ahead)) = &own.gap {
            let described = format!("Distance from {} to {ahead} over time, m", own.name);
            let frame = Frame::new(x, gap, HEIGHT_PX, described)
                .columns(COLUMNS)
                .level(Ink::ContextDashed, spacing_m)
                .line(Ink::Measured, points, f64::INFINITY);
            let asked = format!("spacing asked for, {} m", short(spacing_m));
            rows = rows.row(
                Row::new(format!("{} to {ahead}", own.name), "m", frame)
                    .reads(Ink::Measured, "m", points, 3)
                    .legend(Ink::ContextDashed, asked),
            );
        }
        rows = rows.row(speed_row(own, x, speed, index + 1 == drawn.len()));
    }
    let flat = |own: &DrawnRobot<'_>| own.way.iter().map(|p| (p.1, p.2)).collect::<Points>();
    let trails: Vec<Points> = drawn.iter().map(flat).collect();
    let scales = floor_scales(trails.iter().flatten().copied());
    let mut frame = Frame::floor(
        scales[0],
        scales[1],
        "Paths of the robots on the floor, in metres",
    )
    .x_axis("m");
    let ink = |index: usize| {
        if index == 0 {
            Ink::Measured
        } else {
            Ink::Context
        }
    };
    for (index, trail) in trails.iter().enumerate() {
        frame = frame.trail(ink(index), trail);
    }
    let dots = drawn
        .iter()
        .enumerate()
        .map(|(index, own)| (ink(index), own.way.clone()));
    if drawn.is_empty() {
        rows
    } else {
        rows.floor(frame, scales, dots)
    }
}

fn speed_row(own: &DrawnRobot<'_>, x: Scale, y: Scale, is_last: bool) -> Row {
    let described = format!(
        "Speed of {} over time, by its wheels and on the floor, m/s",
        own.name
    );
    let mut frame = Frame::new(x, y, HEIGHT_PX, described)
        .columns(COLUMNS)
        .line(Ink::Before, &own.by_wheels, f64::INFINITY)
        .line(Ink::Measured, &own.on_floor, f64::INFINITY);
    if is_last {
        frame = frame.x_axis("s");
    }
    Row::new(format!("{} speed", own.name), "m/s", frame)
        .reads(Ink::Before, "by its wheels", &own.by_wheels, 3)
        .reads(Ink::Measured, "on the floor", &own.on_floor, 3)
        .legend(Ink::Before, "by its wheels")
        .legend(Ink::Measured, "on the floor")
}

/// Time (s), x and y (m) of a robot as its camera saw it.
fn places(robot: &Robot) -> Way {
    let Some(pose) = &robot.pose else {
        return Vec::new();
    };
    let stride = pose.t_s.len().div_ceil(POINTS).max(1);
    let rows = pose.t_s.iter().zip(&pose.values.x_m).zip(&pose.values.y_m);
    rows.step_by(stride)
        .map(|((t, x), y)| (*t, *x, *y))
        .collect()
}

fn by_wheels(robot: &Robot) -> Points {
    robot.odometry.as_ref().map_or_else(Vec::new, |own| {
        own.t_s
            .iter()
            .copied()
            .zip(own.values.v_m_s.iter().copied())
            .collect()
    })
}

/// Speed between places some tenths of a second apart, with the sign of none.
fn on_floor(path: &[(f64, f64, f64)]) -> Points {
    let mut from = 0;
    let mut out = Vec::new();
    for to in path {
        while path[from].0 < to.0 - AVERAGED_S {
            from += 1;
        }
        let own = path[from];
        let span = to.0 - own.0;
        if span > 0.5 * AVERAGED_S {
            out.push((
                f64::midpoint(own.0, to.0),
                (to.1 - own.1).hypot(to.2 - own.2) / span,
            ));
        }
    }
    out
}

/// Distance between two robots at the times of the second.
fn distances(ahead: &[(f64, f64, f64)], own: &[(f64, f64, f64)]) -> Points {
    let mut place = 0;
    let mut out = Vec::new();
    for (t, x, y) in own {
        while place + 1 < ahead.len() && ahead[place + 1].0 <= *t {
            place += 1;
        }
        if let Some((_, ax, ay)) = ahead.get(place) {
            out.push((*t, (ax - x).hypot(ay - y)));
        }
    }
    out
}

fn robots(summary: &RunSummary) -> Markup {
    let number = |value: Option<f64>, factor: f64, digits: usize| match value {
        Some(value) => Cell::number(value, fixed(factor * value, digits)),
        None => Cell::number(f64::NAN, "–"),
    };
    let rows: Vec<Vec<Cell>> = summary
        .robots
        .iter()
        .map(|own| {
            let gap = own
                .final_true
                .zip(own.final_odometry)
                .map(|(a, b)| (a[0] - b[0]).hypot(a[1] - b[1]));
            let slip = own.slip_time_s.map(|[right, left]| right + left);
            let fastest = own.max_slip_m_s.map(|[right, left]| right.max(left));
            vec![
                Cell::text(&own.robot),
                number(own.final_true.map(|p| p[0]), 1.0, 3),
                number(own.final_true.map(|p| p[1]), 1.0, 3),
                number(gap, 100.0, 1),
                number(slip, 1.0, 2),
                number(fastest, 1.0, 3),
                number(own.max_spacing_error_m, 100.0, 1),
                number(own.max_desired_speed_m_s, 1.0, 3),
            ]
        })
        .collect();
    let heads = [
        "Robot",
        "Final x, m",
        "Final y, m",
        "Odometry off, cm",
        "Slip, s",
        "Fastest slip, m/s",
        "Spacing error, cm",
        "Largest v_d, m/s",
    ];
    table("What each robot did", &heads, &rows)
}

/// What was heard of real robots, and what they were told.
fn real(summary: &RunSummary) -> Markup {
    let gap = |own: &Stream| match own.messages {
        0 => Cell::number(f64::NAN, "–"),
        _ => Cell::number(own.longest_gap_s, short(1000.0 * own.longest_gap_s)),
    };
    let row = |own: &RobotSummary| {
        let real = own.real.as_ref()?;
        let unreadable = [&real.wheels, &real.poses, &real.odometry, &real.imu];
        let unreadable = unreadable.iter().map(|own| own.unreadable).sum();
        Some(vec![
            Cell::text(&own.robot),
            Cell::count(real.commands),
            Cell::count(real.cut),
            Cell::count(real.stops),
            Cell::count(real.wheels.messages),
            gap(&real.wheels),
            Cell::count(real.poses.messages),
            gap(&real.poses),
            Cell::count(real.jumps),
            Cell::count(unreadable),
        ])
    };
    let rows: Vec<Vec<Cell>> = summary.robots.iter().filter_map(row).collect();
    let heads = [
        "Robot",
        "Commands",
        "Cut by limits",
        "Told to stand",
        "Wheel messages",
        "Longest gap, ms",
        "Poses",
        "Longest gap, ms",
        "Jumps",
        "Unreadable",
    ];
    table("Commands, and what was heard of each robot", &heads, &rows)
}

fn links(summary: &RunSummary) -> Markup {
    let rows: Vec<Vec<Cell>> = summary
        .links
        .iter()
        .map(|own| {
            let mut row = vec![Cell::text(format!("{} → {}", own.from, own.to))];
            row.extend(
                [own.sent, own.delivered, own.lost, own.in_flight, own.stale].map(Cell::count),
            );
            row
        })
        .collect();
    table(
        "Messages of each link",
        &["Link", "Sent", "Delivered", "Lost", "Under way", "Stale"],
        &rows,
    )
}

fn deadlines(summary: &RunSummary) -> Markup {
    let rows: Vec<Vec<Cell>> = summary
        .deadlines
        .iter()
        .map(|own| {
            vec![
                Cell::text(format!("{} {}", own.process, own.name)),
                Cell::count(own.ticks),
                Cell::count(own.missed),
                Cell::number(own.latest_s, short(1000.0 * own.latest_s)),
            ]
        })
        .collect();
    table(
        "Deadlines of each loop",
        &["Loop", "Ticks", "Missed", "Latest, ms"],
        &rows,
    )
}
