//! How far a robot is behind the one that it follows.

use std::collections::VecDeque;

use super::path::Path;

/// Poses that wait for those of the other robot, at most.
const MOST_WAITING: usize = 1024;
/// Time that goes back by more (s) begins anew.
const BREAK_S: f64 = 1.0;
/// Spacings are taken together over so long (s).
const BIN_S: f64 = 0.5;
/// Poses within that, at least.
const LEAST: usize = 3;
/// Both drive steadily where their speeds changed by less than this share and this much (m/s), for so many bins.
const STEADY: f64 = 0.1;
const STEADY_M_S: f64 = 0.02;
const STEADY_BINS: usize = 4;
/// A robot drives that is faster than this (m/s).
const DRIVES_M_S: f64 = 0.05;

/// A pose: when (s), x, y (m) and heading (rad).
pub(super) type Pose = (f64, [f64; 3]);

/// A spacing while both robots drove steadily.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Bin {
    /// When it begins (s).
    pub(super) t_s: f64,
    pub(super) spacing_m: f64,
    pub(super) speed_m_s: f64,
}

/// A robot ahead and one behind it.
#[derive(Debug, Clone, Default)]
pub(super) struct Pair {
    ahead: VecDeque<Pose>,
    behind: VecDeque<Pose>,
    path: Path,
    /// The last place of the robot ahead: when (s), and the way up to there (m).
    last: Option<(f64, f64)>,
    /// Times (s), spacings and ways of the robot ahead (m) of a bin that is not complete.
    open: Vec<[f64; 3]>,
    /// Speed and spacing of the last bins (m/s, m).
    speeds: VecDeque<[f64; 2]>,
}

impl Pair {
    /// Hears poses of both; what they say of the spacing.
    pub(super) fn hear(&mut self, ahead: &[Pose], behind: &[Pose]) -> Vec<Bin> {
        if let (Some((first_s, _)), Some((last_s, _))) = (ahead.first(), self.last)
            && *first_s < last_s - BREAK_S
        {
            *self = Self::default();
        }
        self.ahead.extend(ahead);
        self.behind.extend(behind);
        let mut bins = Vec::new();
        while let Some((t_s, pose)) = self.ahead.pop_front() {
            let way_m = self.path.drive(pose);
            let (before_s, before_m) = *self.last.get_or_insert((t_s, way_m));
            while let Some((at_s, [x_m, y_m, _])) = self.behind.front().copied() {
                if at_s > t_s {
                    break;
                }
                self.behind.pop_front();
                if at_s < before_s {
                    continue;
                }
                let share = if t_s > before_s {
                    (at_s - before_s) / (t_s - before_s)
                } else {
                    1.0
                };
                let ahead_m = before_m + share * (way_m - before_m);
                let spacing_m = self.path.place_m([x_m, y_m]).map(|own| ahead_m - own);
                bins.extend(self.add([at_s, spacing_m.unwrap_or(f64::NAN), ahead_m]));
            }
            self.last = Some((t_s, way_m));
        }
        for rows in [&mut self.ahead, &mut self.behind] {
            let excess = rows.len().saturating_sub(MOST_WAITING);
            rows.drain(..excess);
        }
        bins
    }

    /// Adds a spacing; the bin that ends before it, if both robots drove steadily.
    fn add(&mut self, row: [f64; 3]) -> Option<Bin> {
        let number = |t_s: f64| (t_s / BIN_S).floor();
        let is_same = |own: &[f64; 3]| number(own[0]) == number(row[0]);
        if self.open.last().is_none_or(is_same) {
            self.open.push(row);
            return None;
        }
        let rows = std::mem::replace(&mut self.open, vec![row]);
        let bin = bin(&rows);
        let Some(bin) = bin else {
            self.speeds.clear();
            return None;
        };
        self.speeds.push_back([bin.speed_m_s, bin.spacing_m]);
        if self.speeds.len() > STEADY_BINS {
            self.speeds.pop_front();
        }
        self.is_steady().then_some(bin)
    }

    /// Whether both robots drive, and did so without changing their speeds much.
    fn is_steady(&self) -> bool {
        let ahead = self.speeds.iter().map(|own| own[0]);
        let (least, most) = ahead.fold((f64::INFINITY, 0.0_f64), |(least, most), own| {
            (least.min(own), most.max(own))
        });
        self.speeds.len() == STEADY_BINS
            && least > DRIVES_M_S
            && most - least < STEADY * most + STEADY_M_S
    }
}

/// What the rows of a bin say; `None` where they are too few, or one robot does not follow.
fn bin(rows: &[[f64; 3]]) -> Option<Bin> {
    let (first, last) = (rows.first()?, rows.last()?);
    let mut spacings: Vec<f64> = rows.iter().map(|own| own[1]).collect();
    let is_known = spacings.iter().all(|own| own.is_finite());
    if !is_known || rows.len() < LEAST || last[0] <= first[0] {
        return None;
    }
    spacings.sort_by(f64::total_cmp);
    Some(Bin {
        t_s: first[0],
        spacing_m: spacings[spacings.len() / 2],
        speed_m_s: (last[2] - first[2]) / (last[0] - first[0]),
    })
}
