//! What the figures of a report show of a machine that is told speeds or nothing.

use super::claim::{Claim, Value};
use super::drawn_span::drawn_span;
use super::limits::limits;
use super::prediction::{CHANNELS, Errors};
use super::scene::{Scene, some_windows};
use crate::answer::{ErrorLine, Figures, LawCurve, Motion, Paths, Point, Profile};
use crate::data::streams::WheelKind;
use crate::data::wheel_path::Turned;
use crate::judge::{self, HEADING, PLACE};
use crate::model::from_wheels::drive_parameters;

/// Names of the pose's channels in the figures: as seen from the robot.
const SEEN_FROM_ROBOT: [(&str, &str); 3] = [
    ("pose_x", "forward"),
    ("pose_y", "sideways"),
    ("pose_yaw", "heading"),
];
/// Places of a line of motion, and the time over which a speed is averaged (s).
const PLACES: f64 = 3000.0;
const AVERAGED_S: f64 = 0.2;
/// The same in intervals of the wheels.
const AVERAGED_ROWS: f64 = 6.0;
/// Sizes of a profile, and windows at most by which it is predicted.
const SIZES: i32 = 20;
const WINDOWS: usize = 20;
/// A gap between pieces of a line.
const GAP: Point = (f64::NAN, f64::NAN);

/// The figures of one machine.
pub(crate) fn figures(scene: &Scene<'_>) -> Figures {
    let runs = 0..scene.predictors.len();
    Figures {
        robot: scene.robot.to_owned(),
        runs: Vec::new(),
        spans_s: runs.clone().map(|run| scene.span_s(run)).collect(),
        motion: runs.clone().map(|run| scene.motion(run)).collect(),
        errors: runs.clone().flat_map(|run| scene.lines(run)).collect(),
        forces: Vec::new(),
        paths: runs.filter_map(|run| scene.path(run)).collect(),
        profiles: scene.profiles(),
        laws: scene.laws(),
        limits: limits(scene),
    }
}

impl Scene<'_> {
    fn origin_s(&self, run: usize) -> f64 {
        self.machine.runs[run].origin_s
    }

    fn span_s(&self, run: usize) -> [f64; 2] {
        let own = &self.machine.runs[run];
        own.blocks.span_s.map(|t_s| t_s + own.origin_s)
    }

    fn motion(&self, run: usize) -> Motion {
        let own = &self.machine.runs[run];
        let [from_s, to_s] = own.blocks.span_s;
        let step_s = ((to_s - from_s) / PLACES).max(AVERAGED_S / 2.0);
        let count = ((to_s - from_s) / step_s) as usize;
        let [r, b] = [self.machine.wheel_radius_m, self.machine.half_track_m];
        let local = self.machine.local(run, self.nominal);
        let averaged_s = AVERAGED_S.max(AVERAGED_ROWS * own.wheel_interval_s);
        let half_s = step_s.max(averaged_s) / 2.0;
        own.wheels
            .turned(drive_parameters(&local), |wheels: &dyn Turned<f64>| {
                let mut hints = [0, 0];
                let mut motion = Motion {
                    run,
                    speed_m_s: Vec::with_capacity(count),
                    turn_rad_s: Vec::with_capacity(count),
                };
                for k in 0..count {
                    let t_s = from_s + step_s * k as f64;
                    let before = wheels.angles_at(t_s - half_s, &mut hints[0]);
                    let after = wheels.angles_at(t_s + half_s, &mut hints[1]);
                    let [right, left] = [0, 1].map(|i| r * (after[i] - before[i]) / (2.0 * half_s));
                    let at_s = t_s + own.origin_s;
                    motion.speed_m_s.push((at_s, f64::midpoint(right, left)));
                    motion.turn_rad_s.push((at_s, (right - left) / (2.0 * b)));
                }
                motion
            })
    }

    fn lines(&self, run: usize) -> Vec<ErrorLine> {
        let [before, after] = &self.errors[run];
        CHANNELS
            .into_iter()
            .filter_map(|channel| {
                let name = judge::name(channel);
                let before = line(before, channel, self.origin_s(run));
                let after = match self.claims {
                    [] => Vec::new(),
                    _ => line(after, channel, self.origin_s(run)),
                };
                (!before.is_empty()).then(|| ErrorLine {
                    run,
                    quantity: quantity(name),
                    unit: self.unit(name),
                    deviation: self.deviations[run][channel],
                    before,
                    after,
                })
            })
            .collect()
    }

    fn unit(&self, channel: &str) -> &'static str {
        let kinds = self.predictors.iter().filter_map(|own| own.drive);
        let speeds = kinds
            .into_iter()
            .any(|drive| drive.wheels.kind == WheelKind::Speed);
        match channel {
            "pose_x" | "pose_y" => "m",
            "imu_gz" => "rad/s",
            "wheel_right" | "wheel_left" if speeds => "rad/s",
            _ => "rad",
        }
    }

    /// The path of a run, whole if it is short; else of the minute that loses most error.
    fn path(&self, run: usize) -> Option<Paths> {
        let predictor = &self.predictors[run];
        predictor.run.pose.as_ref()?;
        let by_wheels = predictor.drive.is_none();
        let sides = self.errors[run].iter().zip([1.0, -1.0]);
        let squares = sides.flat_map(|(errors, sign)| {
            let own = errors
                .residuals
                .iter()
                .filter(|(_, channel, _)| *channel <= 3);
            own.map(move |(t_s, _, residual)| (*t_s, sign * residual * residual))
        });
        let span_s = drawn_span(predictor.run.blocks.span_s, squares);
        let windows = if by_wheels {
            vec![span_s]
        } else {
            let all = predictor.windows().into_iter();
            all.filter(|[a, b]| *a >= span_s[0] && *b <= span_s[1] + 1e-9)
                .collect()
        };
        let drawn = |at: &[f64]| predictor.errors(run, at, &windows, true);
        let before = drawn(self.nominal);
        if before.seen.is_empty() {
            return None;
        }
        let after = match self.claims {
            [] => Vec::new(),
            _ => drawn(self.with_all).predicted,
        };
        Some(Paths {
            run,
            span_s: span_s.map(|t_s| t_s + self.origin_s(run)),
            in_pieces: !by_wheels,
            by_wheels,
            seen: before.seen,
            before: before.predicted,
            after,
        })
    }

    fn profiles(&self) -> Vec<Profile> {
        let numbered = self.claims.iter().enumerate();
        numbered
            .filter_map(|(k, claim)| self.profile(self.first_finding + k, claim))
            .collect()
    }

    /// Error against the size of a claim, along the line from nothing to what was found.
    fn profile(&self, finding: usize, claim: &Claim) -> Option<Profile> {
        let sharp = |value: &Value| value.change.abs() / value.half[0].max(1e-300);
        let main = claim
            .values
            .iter()
            .max_by(|a, b| sharp(a).total_cmp(&sharp(b)))?;
        let nominal = (self.nominal_of)(claim, main.name);
        let at = |share: f64| {
            let mut at = self.at.clone();
            claim.toggles.iter().for_each(|index| at[*index] *= share);
            self.own.machine_at(&at)
        };
        let all = (-SIZES / 4..=SIZES + SIZES / 2).map(|k| f64::from(k) / f64::from(SIZES));
        let worth: Vec<(f64, Errors)> = all.map(|share| (share, self.sum(&at(share)))).collect();
        let kinds = ["m", "rad", "wheel"];
        let at_share = |share: f64, unit: &str| {
            let near = worth.iter().find(|(s, _)| (s - share).abs() < 1e-9);
            near.and_then(|(_, errors)| root_mean(errors, unit))
        };
        let lost = |unit: &str| {
            let pair = at_share(0.0, unit).zip(at_share(1.0, unit));
            pair.map_or(0.0, |(before, after)| before / after.max(1e-12))
        };
        let unit = kinds
            .into_iter()
            .max_by(|a, b| lost(a).total_cmp(&lost(b)))?;
        let points: Vec<Point> = worth
            .iter()
            .filter_map(|(share, errors)| {
                let size = main.applied(nominal, share * main.change);
                Some((size, root_mean(errors, unit)?))
            })
            .collect();
        (!points.is_empty()).then_some(Profile {
            finding,
            parameter: main.name,
            unit,
            points,
        })
    }

    /// Errors of some windows of all runs.
    fn sum(&self, at: &[f64]) -> Errors {
        let each = self.predictors.iter().enumerate().map(|(run, predictor)| {
            let windows = some_windows(predictor, WINDOWS.div_ceil(self.predictors.len()));
            predictor.errors(run, at, &windows, false)
        });
        each.fold(Errors::default(), Errors::and)
    }

    fn laws(&self) -> Vec<LawCurve> {
        let numbered = self.claims.iter().enumerate();
        numbered
            .filter_map(|(k, claim)| {
                let law = claim.law.as_ref()?;
                let curve = |sign: f64| {
                    let values = law.values.iter().zip(&law.half);
                    let values = values.map(|(value, half)| value + sign * half);
                    law.knots.iter().copied().zip(values).collect()
                };
                let (quantity, unit) = law.quantity();
                Some(LawCurve {
                    finding: self.first_finding + k,
                    quantity,
                    unit,
                    driver: law.table.driver,
                    curve: curve(0.0),
                    band: [curve(-1.0), curve(1.0)],
                })
            })
            .collect()
    }
}

/// Root mean square error of place (m), heading (rad), or wheels.
fn root_mean(errors: &Errors, unit: &str) -> Option<f64> {
    match unit {
        "m" => errors.score.mean_square(PLACE).map(f64::sqrt),
        "rad" => errors.score.mean_square(HEADING).map(f64::sqrt),
        _ => {
            let both = [0, 1].map(|wheel| errors.score.mean_square(wheel));
            let [right, left] = both;
            right.zip(left).map(|(a, b)| f64::midpoint(a, b).sqrt())
        }
    }
}

fn quantity(channel: &'static str) -> &'static str {
    let own = SEEN_FROM_ROBOT.iter().find(|(name, _)| *name == channel);
    own.map_or(channel, |(_, quantity)| quantity)
}

/// Errors of one channel in time order, in its unit; a gap after each window.
fn line(errors: &Errors, channel: usize, origin_s: f64) -> Vec<Point> {
    let own = errors.residuals.iter().filter(|(_, c, _)| *c == channel);
    let mut points: Vec<Point> = own.map(|(t_s, _, r)| (t_s + origin_s, *r)).collect();
    points.sort_by(|a, b| a.0.total_cmp(&b.0));
    if points.iter().all(|(_, r)| !r.is_finite()) {
        return Vec::new();
    }
    points.push(GAP);
    points
}
