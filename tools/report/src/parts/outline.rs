//! A line of any length as the path of an SVG: per column the first, lowest, highest and last point.

use super::scale::Scale;

/// Units of a frame across and up.
pub(super) const ACROSS: f64 = 4000.0;
pub(super) const UP: f64 = 1000.0;

/// A step that breaks a line: five times the median step.
pub fn gap_of(points: &[(f64, f64)]) -> f64 {
    let pairs = points.windows(2).map(|pair| pair[1].0 - pair[0].0);
    let mut steps: Vec<f64> = pairs.filter(|step| *step > 0.0).collect();
    steps.sort_by(f64::total_cmp);
    let median = steps.get(steps.len() / 2);
    median.map_or(f64::INFINITY, |median| 5.0 * median)
}

/// Bytes of all lines of a page together, of a column of one, and how many columns a line may have.
const LINE_BYTES: usize = 420_000;
const COLUMN_BYTES: usize = 24;
const COLUMNS: [usize; 2] = [60, 1800];

/// How many columns of each line are told apart on a page of so many lines.
pub fn columns_of(lines: usize) -> usize {
    let [least, most] = COLUMNS;
    (LINE_BYTES / COLUMN_BYTES / lines.max(1)).clamp(least, most)
}

/// Commands of an SVG path through points that are sorted by their horizontal value. A point that is not finite,
/// or a step of more than `gap`, breaks the line. No more than four points remain of each of `columns`.
pub(super) fn outline(
    points: &[(f64, f64)],
    x: &Scale,
    y: &Scale,
    columns: usize,
    gap: f64,
) -> String {
    let mut pen = Pen::default();
    let mut column = PixelColumn::default();
    let mut last_x = f64::NEG_INFINITY;
    for (own_x, own_y) in points {
        if !own_x.is_finite() || !own_y.is_finite() {
            column.flush(&mut pen);
            pen.lift();
            continue;
        }
        if *own_x - last_x > gap {
            column.flush(&mut pen);
            pen.lift();
        }
        last_x = *own_x;
        let at = [x.place(*own_x) * ACROSS, (1.0 - y.place(*own_y)) * UP];
        let number = (x.place(*own_x) * columns as f64).floor();
        if column.number != Some(number) {
            column.flush(&mut pen);
            column.number = Some(number);
        }
        column.add(at);
    }
    column.flush(&mut pen);
    pen.lift();
    pen.text
}

/// A path on the floor: points in any direction, those too near to the one before left out, so that no more than
/// [`MOST`] remain.
pub(super) fn trail(points: &[(f64, f64)], x: &Scale, y: &Scale) -> String {
    let at = |(own_x, own_y): &(f64, f64)| {
        let is_seen = own_x.is_finite() && own_y.is_finite();
        is_seen.then(|| [x.place(*own_x) * ACROSS, (1.0 - y.place(*own_y)) * UP])
    };
    let all: Vec<Option<[f64; 2]>> = points.iter().map(at).collect();
    let mut least = LEAST;
    let mut kept = apart(&all, least);
    while kept.len() > MOST {
        least *= 2.0;
        kept = apart(&kept, least);
    }
    let mut pen = Pen::default();
    for own in kept {
        match own {
            Some(at) => pen.to(at),
            None => pen.lift(),
        }
    }
    pen.lift();
    pen.text
}

/// Points of a path at most, and how far they have to be apart across; up it is a quarter.
const MOST: usize = 6000;
const LEAST: f64 = 3.0;

/// Points that lie so far from the one kept before, the last one before each gap, and one of each row of gaps.
fn apart(points: &[Option<[f64; 2]>], least: f64) -> Vec<Option<[f64; 2]>> {
    let mut kept: Vec<Option<[f64; 2]>> = Vec::new();
    for (place, own) in points.iter().enumerate() {
        let is_last = points.get(place + 1).is_none_or(Option::is_none);
        let keep = match (own, kept.last()) {
            (Some(own), Some(Some(last))) => {
                let far =
                    (own[0] - last[0]).abs() > least || (own[1] - last[1]).abs() > least / 4.0;
                far || (is_last && least == LEAST)
            }
            (None, Some(None)) => false,
            _ => true,
        };
        if keep {
            kept.push(*own);
        }
    }
    kept
}

/// A closed area between two lines over the same points.
pub(super) fn area(low: &[(f64, f64)], high: &[(f64, f64)], x: &Scale, y: &Scale) -> String {
    let around: Vec<(f64, f64)> = low
        .iter()
        .chain(high.iter().rev())
        .map(|(across, up)| (*across, up.clamp(y.low, y.high)))
        .collect();
    if around.is_empty() {
        return String::new();
    }
    trail(&around, x, y) + "z"
}

/// What is kept of the points of a column.
#[derive(Default)]
struct PixelColumn {
    number: Option<f64>,
    points: Vec<[f64; 2]>,
}

impl PixelColumn {
    fn add(&mut self, at: [f64; 2]) {
        // first, lowest, highest, last: a fifth point replaces what is no longer extreme
        self.points.push(at);
        if self.points.len() > 4 {
            let ys = |pick: fn(f64, f64) -> bool| {
                let mut best = 0;
                for (i, point) in self.points.iter().enumerate() {
                    if pick(point[1], self.points[best][1]) {
                        best = i;
                    }
                }
                best
            };
            let mut kept = [0, ys(|a, b| a < b), ys(|a, b| a > b), 4];
            kept.sort_unstable();
            let mut kept = kept.to_vec();
            kept.dedup();
            self.points = kept.into_iter().map(|i| self.points[i]).collect();
        }
    }

    fn flush(&mut self, pen: &mut Pen) {
        for point in self.points.drain(..) {
            pen.to(point);
        }
        self.number = None;
    }
}

/// Writes whole numbers, relative to the point before.
#[derive(Default)]
struct Pen {
    text: String,
    at: [i64; 2],
    down: bool,
    /// Whether a relative line was begun, so that the letter need not be repeated.
    line: bool,
}

impl Pen {
    fn lift(&mut self) {
        if self.down && !self.line {
            // a single point: a dot by the round cap of the stroke
            self.text.push_str("h0");
        }
        self.down = false;
        self.line = false;
    }

    fn to(&mut self, at: [f64; 2]) {
        // far outside of the frame nothing is seen
        let at = [
            at[0].clamp(-ACROSS, 2.0 * ACROSS).round() as i64,
            at[1].clamp(-2.0 * UP, 3.0 * UP).round() as i64,
        ];
        let step = [at[0] - self.at[0], at[1] - self.at[1]];
        if !self.down {
            self.text.push_str(&format!("M{} {}", at[0], at[1]));
        } else if step == [0, 0] {
            return;
        } else {
            self.text.push(if self.line { ' ' } else { 'l' });
            if self.line && step[0] < 0 {
                self.text.pop();
            }
            self.text.push_str(&step[0].to_string());
            if step[1] >= 0 {
                self.text.push(' ');
            }
            self.text.push_str(&step[1].to_string());
            self.line = true;
        }
        self.at = at;
        self.down = true;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn scales() -> (Scale, Scale) {
        (Scale::new(0.0, 1.0, 4), Scale::new(0.0, 1.0, 4))
    }

    #[test]
    fn a_line_is_relative_and_whole() {
        let (x, y) = scales();
        let points = [(0.0, 0.0), (0.5, 1.0), (1.0, 0.5)];
        assert_eq!(
            outline(&points, &x, &y, 900, 1e9),
            "M0 1000l2000-1000 2000 500"
        );
    }

    #[test]
    fn gaps_break_the_line() {
        let (x, y) = scales();
        let points = [
            (0.0, 0.0),
            (0.1, f64::NAN),
            (0.2, 0.0),
            (0.3, 0.0),
            (0.9, 0.0),
        ];
        assert_eq!(
            outline(&points, &x, &y, 900, 0.5),
            "M0 1000h0M800 1000l400 0M3600 1000h0"
        );
    }

    #[test]
    fn a_path_of_many_turns_is_thinned() {
        let turns: Vec<(f64, f64)> = (0..1_000_000)
            .map(|k| 0.01 * f64::from(k))
            .map(|a| (0.5 + 0.4 * a.cos(), 0.5 + 0.4 * a.sin()))
            .collect();
        let (x, y) = scales();
        let text = trail(&turns, &x, &y);
        assert!(text.len() < 80_000, "{}", text.len());
        assert!(text.len() > 1000);
    }

    #[test]
    fn extremes_survive_however_long_the_line_is() {
        let (x, y) = scales();
        let mut points: Vec<(f64, f64)> = (0..1_000_000)
            .map(|k| (f64::from(k) * 1e-6, 0.5 + 0.1 * f64::from(k % 7) / 7.0))
            .collect();
        points[123_456].1 = 0.99;
        points[765_432].1 = 0.01;
        let text = outline(&points, &x, &y, 900, 1e9);
        assert!(text.len() < 60_000, "{}", text.len());
        // from 0.99 down: 10 of 1000 units from the top
        let mut at = 0_i64;
        let (mut top, mut bottom) = (i64::MAX, i64::MIN);
        let start = text.find('l').unwrap();
        for (place, step) in numbers(&text[..start]).chunks(2).map(|p| p[1]).enumerate() {
            assert_eq!(place, 0);
            at = step;
        }
        for step in numbers(&text[start..]).chunks(2) {
            at += step[1];
            top = top.min(at);
            bottom = bottom.max(at);
        }
        assert_eq!((top, bottom), (10, 990));
    }

    fn numbers(text: &str) -> Vec<i64> {
        let spaced: String = text
            .chars()
            .flat_map(|c| match c {
                '-' => vec![' ', '-'],
                'M' | 'l' => vec![' '],
                c => vec![c],
            })
            .collect();
        spaced
            .split_whitespace()
            .map(|n| n.parse().unwrap())
            .collect()
    }
}
