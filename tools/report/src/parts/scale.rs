//! A range of values on an axis, with round ticks.

use super::number::fixed;

/// Steps between ticks, in powers of ten.
const STEPS: [f64; 4] = [1.0, 2.0, 2.5, 5.0];
/// Steps of angles (degrees) where there is room for them.
const ANGLES: [f64; 5] = [45.0, 90.0, 180.0, 360.0, 720.0];

/// Digits behind the point of a tick at most.
const LONGEST: usize = 4;

/// A range of values.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Scale {
    /// Where the axis begins.
    pub low: f64,
    /// Where it ends.
    pub high: f64,
    step: f64,
}

impl Scale {
    /// The range from `low` to `high`, with about `count` ticks. An empty range gets a width.
    pub fn new(low: f64, high: f64, count: usize) -> Self {
        let (low, high) = widened(low, high);
        Self {
            low,
            high,
            step: step((high - low) / count.max(1) as f64),
        }
    }

    /// The range of all finite values, with 0 among them if `zero`, and a margin of 4 %.
    pub fn around(values: impl IntoIterator<Item = f64>, zero: bool, count: usize) -> Self {
        let start = if zero {
            [0.0, 0.0]
        } else {
            [f64::INFINITY, f64::NEG_INFINITY]
        };
        let finite = values.into_iter().filter(|value| value.is_finite());
        let [low, high] = finite.fold(start, |[low, high], v| [low.min(v), high.max(v)]);
        let (low, high) = widened(low, high);
        let margin = 0.04 * (high - low);
        let end = |value: f64, side: f64| {
            if zero && value == 0.0 {
                0.0
            } else {
                value + side * margin
            }
        };
        Self::new(end(low, -1.0), end(high, 1.0), count)
    }

    /// The same for degrees, with ticks at 45, 90 or 180 where the range is wide.
    pub fn of_degrees(mut self) -> Self {
        // a little finer than asked is better than one tick
        if let Some(step) = ANGLES.into_iter().find(|step| *step >= 0.6 * self.step)
            && self.step > 30.0
        {
            self.step = step;
        }
        self
    }

    /// Place of a value between 0 (`low`) and 1 (`high`).
    pub fn place(&self, value: f64) -> f64 {
        (value - self.low) / (self.high - self.low)
    }

    /// The ticks and their texts.
    pub fn ticks(&self) -> Vec<(f64, String)> {
        let digits = self.digits();
        let first = (self.low / self.step - 1e-9).ceil();
        let last = (self.high / self.step + 1e-9).floor();
        let count = (last - first).clamp(0.0, 1000.0) as usize;
        (0..=count)
            .map(|k| (first + k as f64) * self.step)
            .filter(|value| *value <= self.high + 1e-9 * self.step)
            .map(|value| (value, tick(value, digits)))
            .collect()
    }

    /// Digits behind the point of a tick.
    pub fn digits(&self) -> usize {
        let is_whole = |digits: i32| {
            let scaled = self.step * 10.0_f64.powi(digits);
            (scaled - scaled.round()).abs() < 1e-6 * scaled
        };
        (0..9).find(|digits| is_whole(*digits)).unwrap_or(9) as usize
    }
}

/// Axes of one scale around all points, neither too flat nor too tall.
pub fn floor_scales(points: impl Iterator<Item = (f64, f64)> + Clone) -> [Scale; 2] {
    let range = |of: fn(&(f64, f64)) -> f64| {
        let own = points.clone().map(|p| of(&p)).filter(|v| v.is_finite());
        own.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], v| {
            [low.min(v), high.max(v)]
        })
    };
    let [x, y] = [range(|p| p.0), range(|p| p.1)];
    let width = |range: [f64; 2]| {
        if range[1] > range[0] {
            range[1] - range[0]
        } else {
            0.0
        }
    };
    let longest = width(x).max(width(y)).max(1e-3);
    let ends = |range: [f64; 2]| {
        let middle = if range[0].is_finite() {
            f64::midpoint(range[0], range[1])
        } else {
            0.0
        };
        let half = 0.53 * width(range).max(0.6 * longest);
        (middle - half, middle + half)
    };
    let ticks = |share: f64| if share > 0.9 { 4 } else { 3 };
    [x, y].map(|range| {
        let (low, high) = ends(range);
        Scale::new(low, high, ticks(width(range) / longest))
    })
}

/// The text of a tick; what needs many digits is written with its power of ten.
fn tick(value: f64, digits: usize) -> String {
    if digits <= LONGEST || value == 0.0 {
        return fixed(
            value,
            if value == 0.0 {
                digits.min(LONGEST)
            } else {
                digits
            },
        );
    }
    let text = format!("{value:.1e}").replace(".0e", "e");
    text.replace('-', "−")
}

fn widened(low: f64, high: f64) -> (f64, f64) {
    if !(low.is_finite() && high.is_finite()) {
        return (0.0, 1.0);
    }
    if high - low > 1e-12 * high.abs().max(low.abs()).max(1e-12) {
        return (low, high);
    }
    let half = if low == 0.0 { 0.5 } else { 0.05 * low.abs() };
    (low - half, high + half)
}

/// The round step nearest above `least`.
fn step(least: f64) -> f64 {
    let power = 10.0_f64.powf(least.log10().floor());
    let next = STEPS.into_iter().map(|step| step * power);
    next.into_iter()
        .find(|step| *step >= least * (1.0 - 1e-9))
        .unwrap_or(10.0 * power)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn texts(scale: Scale) -> Vec<String> {
        scale.ticks().into_iter().map(|(_, text)| text).collect()
    }

    #[test]
    fn ticks_are_round() {
        assert_eq!(texts(Scale::new(0.0, 67.6, 6)), ["0", "20", "40", "60"]);
        assert_eq!(texts(Scale::new(-0.6, 0.6, 4)), ["−0.5", "0.0", "0.5"]);
        assert_eq!(
            texts(Scale::new(-540.0, 200.0, 4).of_degrees()),
            ["−540", "−360", "−180", "0", "180"]
        );
    }

    #[test]
    fn small_ticks_are_short() {
        let ticks = texts(Scale::new(-6e-6, 6e-6, 3));
        assert_eq!(ticks, ["−5e−6", "0.0000", "5e−6"]);
    }

    #[test]
    fn any_range_has_a_width() {
        for (low, high) in [
            (0.0, 0.0),
            (3.0, 3.0),
            (f64::NAN, 1.0),
            (f64::INFINITY, 0.0),
        ] {
            let scale = Scale::new(low, high, 4);
            assert!(scale.high > scale.low && scale.place(scale.low) == 0.0);
            assert!(scale.ticks().len() < 20);
        }
    }
}
