//! What the figures of a report show of a machine that is told speeds or nothing.

use super::claim::{Claim, Value};
use super::figures::{OfRun, curve};
use super::fitted::Fitted;
use super::limits::limits;
use super::scene::Scene;
use super::search::problem;
use crate::answer::{ErrorLine, Figures, LawCurve, Motion, Paths, Profile};
use crate::data::wheel_path::Turned;
use crate::judge::POSE;
use crate::model::streams::{Joint, ROBUST};
use crate::model::wheel_parameters::drive_parameters;
use crate::predict::drawn::Drawn;

/// Places of a line of motion, and the time over which a speed is averaged (s).
const PLACES: f64 = 3000.0;
const AVERAGED_S: f64 = 0.2;
/// The same in intervals of the wheels.
const AVERAGED_ROWS: f64 = 6.0;
/// Sizes of a profile from nothing to what was found.
const SIZES: i32 = 20;

/// The figures of one machine.
pub(crate) fn figures(scene: &Scene<'_>) -> Figures {
    let runs = 0..scene.predictors.len();
    let numbered = || (scene.first_finding..).zip(scene.claims);
    Figures {
        robot: scene.robot.to_owned(),
        spans_s: runs.clone().map(|run| scene.span_s(run)).collect(),
        motion: runs.clone().map(|run| scene.motion(run)).collect(),
        errors: runs.clone().flat_map(|run| scene.lines(run)).collect(),
        paths: runs.filter_map(|run| scene.path(run)).collect(),
        profiles: numbered()
            .filter_map(|(finding, claim)| scene.profile(finding, claim))
            .collect(),
        laws: numbered()
            .filter_map(|(finding, claim)| law(finding, claim))
            .collect(),
        limits: limits(scene),
        ..Figures::default()
    }
}

impl Scene<'_> {
    fn span_s(&self, run: usize) -> [f64; 2] {
        let own = &self.machine.runs[run];
        own.blocks.span_s.map(|t_s| t_s + own.origin_s)
    }

    /// How a run drove, by its wheels.
    fn motion(&self, run: usize) -> Motion {
        let own = &self.machine.runs[run];
        let [from_s, to_s] = own.blocks.span_s;
        let step_s = ((to_s - from_s) / PLACES).max(AVERAGED_S / 2.0);
        let count = ((to_s - from_s) / step_s) as usize;
        let [r, b] = [self.machine.wheel_radius_m, self.machine.half_track_m];
        let local = self.machine.local(run, self.nominal);
        let averaged_s = AVERAGED_S.max(AVERAGED_ROWS * own.wheel_interval_s);
        let half_s = step_s.max(averaged_s) / 2.0;
        let rates = |wheels: &dyn Turned<f64>| {
            let mut hints = [0, 0];
            let each = (0..count).map(|k| {
                let t_s = from_s + step_s * k as f64;
                let before = wheels.angles_at(t_s - half_s, &mut hints[0]);
                let after = wheels.angles_at(t_s + half_s, &mut hints[1]);
                let [right, left] = [0, 1].map(|i| r * (after[i] - before[i]) / (2.0 * half_s));
                let at_s = t_s + own.origin_s;
                let speed = f64::midpoint(right, left);
                ((at_s, speed), (at_s, (right - left) / (2.0 * b)))
            });
            each.unzip()
        };
        let (speed_m_s, turn_rad_s) = own.wheels.turned(drive_parameters(&local), rates);
        Motion {
            run,
            speed_m_s,
            turn_rad_s,
        }
    }

    fn of_run<'b>(&'b self, run: usize, before: &'b Drawn, after: &'b Drawn) -> OfRun<'b> {
        OfRun {
            run,
            before,
            after: (!self.claims.is_empty()).then_some(after),
            origin_s: self.machine.runs[run].origin_s,
        }
    }

    fn lines(&self, run: usize) -> Vec<ErrorLine> {
        let [before, after] = &self.errors[run];
        let angles = self.predictors.iter().all(|own| own.has_angles());
        self.of_run(run, &before.drawn, &after.drawn)
            .lines([angles, true], |channel| self.deviations[run][channel])
    }

    /// The path of a run, whole if it is short; else of the minute that loses most error.
    fn path(&self, run: usize) -> Option<Paths> {
        let predictor = &self.predictors[run];
        predictor.run.pose.as_ref()?;
        let [before, after] = &self.errors[run];
        let own = self.of_run(run, &before.drawn, &after.drawn);
        let span_s = own.span_s(predictor.run.blocks.span_s, 0..POSE + 2);
        let by_wheels = predictor.drive.is_none();
        let windows = if by_wheels {
            vec![span_s]
        } else {
            let all = predictor.windows().into_iter();
            all.filter(|[a, b]| *a >= span_s[0] && *b <= span_s[1] + 1e-9)
                .collect()
        };
        let [before, after] =
            [self.nominal, self.with_all].map(|at| predictor.errors(run, at, &windows).drawn);
        self.of_run(run, &before, &after).path(span_s, by_wheels)
    }

    /// How the fit falls with the size of a claim, along the line from nothing to what was found.
    fn profile(&self, finding: usize, claim: &Claim) -> Option<Profile> {
        let sharp = |value: &Value| value.change.abs() / value.half[0].max(1e-300);
        let main = claim
            .values
            .iter()
            .max_by(|a, b| sharp(a).total_cmp(&sharp(b)))?;
        let nominal = (self.nominal_of)(claim, main.name);
        let Fitted { streams, found } = self.own;
        let fit = &found.selected.fit;
        let joint = Joint::new(streams, &found.nominal, &found.table.weights, ROBUST);
        let problem = problem(&joint, &found.table);
        let all = (-SIZES / 4..=SIZES + SIZES / 2).map(|k| f64::from(k) / f64::from(SIZES));
        let likelihoods = all.map(|share| {
            let mut at = fit.at.clone();
            claim.toggles.iter().for_each(|index| at[*index] *= share);
            let size = main.applied(nominal, share * main.change);
            (size, problem.objective(&at, &fit.free))
        });
        Profile::new(finding, main.name, likelihoods)
    }
}

fn law(finding: usize, claim: &Claim) -> Option<LawCurve> {
    let law = claim.law.as_ref()?;
    let driver = law.table.driver;
    let values = [law.values.as_slice(), &law.half];
    Some(curve(finding, law.quantity(), driver, &law.knots, values))
}
