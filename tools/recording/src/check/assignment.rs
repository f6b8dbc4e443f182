//! Which wheel is which: one regression over all that a machine drove, for every assignment of sides and signs.
//!
//! An assignment says which measured wheel is the right one and which way each counts. It predicts the forward
//! speed v = c1 (R + L) and the yaw rate w = c2 (R - L) with c1, c2 > 0. Their ratio is the effective half
//! track: without a bound on it, wheels that differ a little on a straight drive explain any speed. Squares of
//! what is left are in units of each channel's own size, so that neither metres nor radians prevail.

/// The effective half track over the model's: down to a half, and what skid steering makes of it at most.
const TRACK_SHARE: [f64; 2] = [0.5, 4.0];
/// Half tracks of robots whose size is not known (m).
const ANY_TRACK_M: [f64; 2] = [0.02, 2.0];
/// A rim that turns this share as fast as the robot drives is the least that counts as turning, and likewise
/// for driving: below, noise would tell sides.
const LEAST_SHARE: f64 = 0.1;
/// Pieces of time that have to agree.
const PIECES: usize = 10;
/// A piece with a smaller share of the motion says nothing.
const LEAST_PIECE: f64 = 0.02;
/// Least share of the pieces that agree.
const AGREEMENT: f64 = 0.8;
/// Fewest windows with wheels and reference.
const LEAST_WINDOWS: usize = 10;
/// Another assignment explains most: it leaves at most this share. The given one leaves at least as much again
/// and so many times more than the other.
const MOST_LEFT: f64 = 0.4;
const LEAST_LEFT: f64 = 0.5;
const RATIO: f64 = 3.0;

/// One of eight assignments.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Assignment {
    pub(super) swapped: bool,
    /// Whether the wheel that drives the right side counts backwards, and the left one.
    pub(super) backwards: [bool; 2],
}

impl Assignment {
    /// As the recording says.
    pub(super) const GIVEN: Self = Self {
        swapped: false,
        backwards: [false; 2],
    };

    fn all() -> impl Iterator<Item = Self> {
        (0..8_u8).map(|bits| Self {
            swapped: bits & 1 > 0,
            backwards: [bits & 2 > 0, bits & 4 > 0],
        })
    }

    /// Sum and difference of the wheels.
    fn parts(self, row: &WindowRow) -> [f64; 2] {
        let [right, left] = if self.swapped {
            [row.left, row.right]
        } else {
            [row.right, row.left]
        };
        let sign = |backwards: bool| if backwards { -1.0 } else { 1.0 };
        let [right, left] = [
            right * sign(self.backwards[0]),
            left * sign(self.backwards[1]),
        ];
        [right + left, right - left]
    }
}

/// A window: both wheels (rad/s or counts/s), forward speed (m/s) and yaw rate (rad/s).
#[derive(Debug, Clone, Copy)]
struct WindowRow {
    right: f64,
    left: f64,
    v: f64,
    w: f64,
}

/// The windows of a machine in which wheels and a reference are known.
pub(super) struct Regression {
    rows: Vec<WindowRow>,
    /// Weights of the squares of both channels.
    weights: [f64; 2],
    tracks_m: [f64; 2],
}

impl Regression {
    /// From values of each window; `half_track_m` of the model, if known. `None` with too few windows, or without
    /// motion.
    pub(super) fn new(
        [right, left]: [&[f64]; 2],
        [v, w]: [&[f64]; 2],
        half_track_m: Option<f64>,
    ) -> Option<Self> {
        let wheels = right.iter().zip(left);
        let all = wheels.zip(v.iter().zip(w));
        let all = all.map(|((&right, &left), (&v, &w))| WindowRow { right, left, v, w });
        let known = |row: &WindowRow| {
            [row.right, row.left, row.v, row.w]
                .iter()
                .all(|x| x.is_finite())
        };
        let rows: Vec<WindowRow> = all.filter(known).collect();
        let sum = |of: fn(&WindowRow) -> f64| rows.iter().map(of).sum::<f64>();
        let (driven, turned) = (sum(|row| row.v * row.v), sum(|row| row.w * row.w));
        let arm_m = half_track_m.unwrap_or((ANY_TRACK_M[0] * ANY_TRACK_M[1]).sqrt());
        let least = LEAST_SHARE * LEAST_SHARE;
        let sizes = [
            driven.max(least * turned * arm_m * arm_m),
            turned.max(least * driven / (arm_m * arm_m)),
        ];
        let tracks_m = half_track_m.map_or(ANY_TRACK_M, |b| TRACK_SHARE.map(|share| share * b));
        (rows.len() >= LEAST_WINDOWS && sizes.iter().all(|size| *size > 0.0)).then(|| Self {
            rows,
            weights: sizes.map(f64::recip),
            tracks_m,
        })
    }

    /// The assignment that explains the motion where the given one does not, beyond doubt.
    pub(super) fn other(&self) -> Option<Assignment> {
        let given = self.fitted(Assignment::GIVEN);
        let fits = Assignment::all().map(|own| (own, self.fitted(own)));
        let (best, fit) = fits.min_by(|a, b| a.1.left.total_cmp(&b.1.left))?;
        let clear = fit.left < MOST_LEFT
            && given.left > LEAST_LEFT
            && given.left > RATIO * fit.left
            && self.agree((best, fit.factors), given.factors);
        (clear && best != Assignment::GIVEN).then_some(best)
    }

    /// Share of the motion that the best assignment leaves.
    pub(super) fn least_left(&self) -> f64 {
        let fits = Assignment::all().map(|own| self.fitted(own).left);
        fits.fold(f64::INFINITY, f64::min)
    }

    /// Best positive factors of an assignment, and the share of squares that they leave.
    fn fitted(&self, own: Assignment) -> AssignmentFit {
        let [mut ss, mut vs, mut dd, mut wd, mut total] = [0.0; 5];
        let [of_v, of_w] = self.weights;
        for row in &self.rows {
            let [s, d] = own.parts(row);
            ss += of_v * s * s;
            vs += of_v * row.v * s;
            dd += of_w * d * d;
            wd += of_w * row.w * d;
            total += of_v * row.v * row.v + of_w * row.w * row.w;
        }
        let left = |[a, b]: [f64; 2]| total - 2.0 * (a * vs + b * wd) + a * a * ss + b * b * dd;
        let free = [
            vs / ss.max(f64::MIN_POSITIVE),
            wd / dd.max(f64::MIN_POSITIVE),
        ];
        let [least_m, most_m] = self.tracks_m;
        let inside = free.iter().all(|c| *c > 0.0)
            && (least_m * free[1]..=most_m * free[1]).contains(&free[0]);
        let bound = |track_m: f64| {
            let a = (vs + wd / track_m) / (ss + dd / (track_m * track_m)).max(f64::MIN_POSITIVE);
            [a.max(0.0), a.max(0.0) / track_m]
        };
        let bounds = [bound(least_m), bound(most_m)];
        let factors = if inside {
            free
        } else if left(bounds[0]) < left(bounds[1]) {
            bounds[0]
        } else {
            bounds[1]
        };
        AssignmentFit {
            factors,
            left: left(factors) / total,
        }
    }

    /// Whether nearly all pieces of time that move say so by themselves.
    fn agree(&self, best: (Assignment, [f64; 2]), given: [f64; 2]) -> bool {
        let length = self.rows.len().div_ceil(PIECES);
        let squares = |rows: &[WindowRow], (own, factors): (Assignment, [f64; 2])| {
            let each = rows.iter().map(|row| {
                let [s, d] = own.parts(row);
                let [v, w] = [row.v - factors[0] * s, row.w - factors[1] * d];
                self.weights[0] * v * v + self.weights[1] * w * w
            });
            each.sum::<f64>()
        };
        let still = (Assignment::GIVEN, [0.0; 2]);
        let total = squares(&self.rows, still);
        let pieces = self.rows.chunks(length);
        let moving: Vec<&[WindowRow]> = pieces
            .filter(|piece| squares(piece, still) > LEAST_PIECE * total)
            .collect();
        let given = (Assignment::GIVEN, given);
        let agree = moving
            .iter()
            .filter(|piece| squares(piece, best) < squares(piece, given));
        agree.count() as f64 >= AGREEMENT * moving.len() as f64
    }
}

/// Factors of an assignment, and the share of the motion that it leaves.
#[derive(Debug, Clone, Copy)]
struct AssignmentFit {
    factors: [f64; 2],
    left: f64,
}

#[cfg(test)]
mod tests {
    use super::*;

    const B: f64 = 0.2;

    /// Forty windows of wheels (m/s at the rim) with speed and yaw rate, as `change` makes of the wheels.
    fn regression(
        motion: impl Fn(f64) -> [f64; 2],
        change: impl Fn([f64; 2]) -> [f64; 2],
    ) -> Regression {
        let motions: Vec<[f64; 2]> = (0..40).map(|k| motion(f64::from(k) * 0.5)).collect();
        let wheels = motions.iter().map(|[v, w]| change([v + B * w, v - B * w]));
        let wheels: Vec<[f64; 2]> = wheels.collect();
        let column = |all: &[[f64; 2]], i: usize| all.iter().map(|x| x[i]).collect::<Vec<f64>>();
        let [r, l] = [0, 1].map(|i| column(&wheels, i));
        let [v, w] = [0, 1].map(|i| column(&motions, i));
        Regression::new([&r, &l], [&v, &w], Some(B)).unwrap()
    }

    fn curves(t: f64) -> [f64; 2] {
        [0.3 + 0.1 * (0.9 * t).sin(), 0.8 * (0.5 * t).sin()]
    }

    #[test]
    fn every_assignment_is_told_by_curves() {
        type Case = (fn([f64; 2]) -> [f64; 2], Option<(bool, [bool; 2])>);
        let cases: [Case; 6] = [
            (|x| x, None),
            (|[r, l]| [r, -l], Some((false, [false, true]))),
            (|[r, l]| [-r, l], Some((false, [true, false]))),
            (|[r, l]| [l, r], Some((true, [false, false]))),
            (|[r, l]| [-r, -l], Some((false, [true, true]))),
            (|[r, l]| [-l, -r], Some((true, [true, true]))),
        ];
        for (change, wanted) in cases {
            let found = regression(curves, change).other();
            let found = found.map(|own| (own.swapped, own.backwards));
            assert_eq!(found, wanted);
        }
    }

    #[test]
    fn a_straight_drive_that_pulls_to_a_side_says_nothing() {
        let straight = |t: f64| {
            [
                0.4 + 0.05 * (0.3 * t).sin(),
                0.004 + 0.003 * (1.7 * t).sin(),
            ]
        };
        // the wheels differ by what a carpet takes of one side
        let found = regression(straight, |[r, l]| [1.05 * r, 0.95 * l]).other();
        assert_eq!(found, None);
        assert_eq!(regression(straight, |[r, l]| [l, r]).other(), None);
    }

    #[test]
    fn a_side_that_is_dragged_backwards_for_a_while_is_not_reversed() {
        let count = std::cell::Cell::new(0);
        let dragged = regression(curves, |[r, l]| {
            count.set(count.get() + 1);
            if count.get() % 10 < 3 {
                [r, -l]
            } else {
                [r, l]
            }
        });
        assert_eq!(dragged.other(), None);
    }
}
