//! How old the position in use is: a few rounds of it.

use maud::{Markup, html};
use slipstream_trace::{AgeLine, TraceReading, ages_over_time};

use crate::parts::{Frame, Ink, Points, Row, Rows, Scale, fixed};

/// Followers that are shown.
const AGES: usize = 4;
/// Rounds that are shown: of them the second is shaded.
const ROUNDS: f64 = 4.0;

/// The section.
pub(super) fn ages(reading: &TraceReading) -> Markup {
    let all = ages_over_time(&reading.log);
    let followers: Vec<&AgeLine> = all
        .iter()
        .filter(|own| own.to != 0 && own.points.len() > 2)
        .take(AGES)
        .collect();
    let Some(first) = followers.first() else {
        return html! { p class="sub" { "No robot uses the position of another." } };
    };
    let round = NewerPosition::of(first);
    let [low, high] = round.window_s();
    let shown = |own: &AgeLine| -> Points {
        let inside = own.points.iter().filter(|(t, _)| (low..=high).contains(t));
        inside.map(|(t, age)| (*t, 1e3 * age)).collect()
    };
    let y = Scale::around(
        followers.iter().flat_map(|own| shown(own)).map(|own| own.1),
        true,
        4,
    );
    let x = Scale::new(low, high, 4);
    let mut rows = Rows::new("age");
    for (index, own) in followers.iter().enumerate() {
        let points = shown(own);
        let [to, from] = [own.to, own.from].map(|robot| reading.name_of(robot));
        let described = format!("Age of the position that {to} uses over some rounds, ms");
        let mut frame = Frame::new(x, y, 110, described)
            .span(None, round.second_s())
            .line(Ink::Wait, &steps(&points), f64::INFINITY);
        if index + 1 == followers.len() {
            frame = frame.x_axis("s");
        }
        let row = Row::new(format!("{to} of {from}"), "ms", frame);
        rows = rows.row(row.reads(Ink::Wait, "ms old", &points, 1));
    }
    html! {
        p class="sub" { "At each outer tick, since the encoders of the robot ahead were read. "
            @if round.has_waits() {
                "Shaded: one round, " (fixed(1e3 * round.length_s, 0)) " ms, after which a newer position comes. "
                "In a ring each robot hears once in a round; " code { "--set links.protocol=periodic" } " sends at each outer tick."
            } @else { "A newer position comes at each outer tick." }
        }
        (rows.markup())
    }
}

/// How often a newer position comes.
struct NewerPosition {
    begin_s: f64,
    length_s: f64,
    tick_s: f64,
}

impl NewerPosition {
    /// The rounds of a follower: from one newer position to the next, in the median.
    fn of(line: &AgeLine) -> Self {
        let pairs = || line.points.windows(2);
        // With the same position it ages from tick to tick by the time between them.
        let is_newer = |pair: &&[(f64, f64)]| {
            let elapsed_s = pair[1].0 - pair[0].0;
            pair[1].1 - pair[0].1 < 0.5 * elapsed_s
        };
        let newer: Vec<f64> = pairs().filter(is_newer).map(|pair| pair[1].0).collect();
        let tick_s = median(pairs().map(|pair| pair[1].0 - pair[0].0).collect());
        let lengths = newer.windows(2).map(|pair| pair[1] - pair[0]);
        let length_s = median(lengths.collect()).max(tick_s);
        // After the start of the run, where the first positions are under way.
        let begin_s = newer.get(newer.len() / 2).or(newer.first()).copied();
        Self {
            begin_s: begin_s.unwrap_or_else(|| line.points.first().map_or(0.0, |own| own.0)),
            length_s,
            tick_s,
        }
    }

    /// Whether a position is used at several ticks.
    fn has_waits(&self) -> bool {
        self.length_s > 1.5 * self.tick_s
    }

    fn window_s(&self) -> [f64; 2] {
        let length_s = self.length_s.max(4.0 * self.tick_s);
        [self.begin_s, self.begin_s + ROUNDS * length_s]
    }

    fn second_s(&self) -> [f64; 2] {
        [
            self.begin_s + self.length_s,
            self.begin_s + 2.0 * self.length_s,
        ]
    }
}

fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    values.get(values.len() / 2).copied().unwrap_or(0.0)
}

/// A line that holds its value until the next point.
fn steps(points: &[(f64, f64)]) -> Points {
    let mut out = Vec::with_capacity(2 * points.len());
    for pair in points.windows(2) {
        out.push(pair[0]);
        out.push((pair[1].0, pair[0].1));
    }
    out.extend(points.last());
    out
}
