//! Section 4: the platoon without and with the torque limit (Fig. 9 to 12, final positions).

use super::printed::{FINALS, Finals};
use super::recorded_run::RecordedRun;
use super::row::PaperRow;

const FINAL: &str = "final positions, section 4";
const SPACINGS: &str = "\"the inter-vehicular spacings are maintained better\", section 4";
const WHICH: [&str; 2] = ["without_limit", "with_limit"];
/// The assumptions that change a straight run; `limit` only a run with the torque limit.
const ASSUMPTIONS: [&str; 5] = ["profile", "gains", "motor", "friction", "limit"];

fn assumptions(which: &str) -> &'static [&'static str] {
    if which == WHICH[0] {
        &ASSUMPTIONS[..4]
    } else {
        &ASSUMPTIONS
    }
}

/// Rows for the final positions, then for the claims about the figures.
pub(super) fn rows(runs: &[RecordedRun; 2]) -> Vec<PaperRow> {
    let mut rows = Vec::new();
    for ((run, printed), which) in runs.iter().zip(&FINALS).zip(WHICH) {
        rows.extend(finals(run, printed, which));
    }
    for ((run, printed), which) in runs.iter().zip(&FINALS).zip(WHICH) {
        rows.extend(gaps(run, printed, which));
    }
    rows.extend(claims(runs));
    rows
}

fn finals(run: &RecordedRun, printed: &Finals, which: &str) -> Vec<PaperRow> {
    let mut rows = Vec::new();
    for (i, (truth, agent)) in run
        .reports
        .plant
        .robots
        .iter()
        .zip(&run.reports.agents)
        .enumerate()
        .take(3)
    {
        for (axis, name) in [(0, "x"), (1, "y")] {
            for (by, paper, computed) in [
                ("encoder", printed.encoder[i], agent.final_odometry),
                ("true", printed.measured[i], truth.final_true),
            ] {
                let quantity = format!("final_{name}_r{}_{by}_{which}_m", i + 1);
                let row = PaperRow::printed(quantity, FINAL, paper[axis], computed[axis]);
                rows.push(if axis == 0 {
                    row.note("the way is that of the assumed profile")
                        .depending_on(assumptions(which))
                } else {
                    row.note("zero by symmetry: see the causes")
                        .depending_on(&["symmetry"])
                });
            }
        }
    }
    rows
}

fn gaps(run: &RecordedRun, printed: &Finals, which: &str) -> Vec<PaperRow> {
    let robots = run.robots();
    let signed = (0..robots)
        .map(|robot| run.final_gap_m(robot, 0))
        .sum::<f64>()
        / f64::from(robots);
    vec![
        PaperRow::printed(
            format!("mean_gap_x_{which}_m"),
            FINAL,
            printed.mean_gap_m(0),
            mean_gap_m(run, 0),
        )
        .note(format!(
            "encoder against truth. Here the encoders are {:.3} m {} on average; the paper's printed \
             encoders are behind in both experiments, against its own section 3, where slip puts \
             them ahead: sliding while braking or a wheel radius that is off would do that",
            signed.abs(),
            if signed >= 0.0 { "ahead" } else { "behind" }
        ))
        .depending_on(assumptions(which)),
        PaperRow::printed(
            format!("mean_gap_y_{which}_m"),
            FINAL,
            printed.mean_gap_m(1),
            mean_gap_m(run, 1),
        )
        .note("zero by symmetry: see the causes")
        .depending_on(&["symmetry"]),
        PaperRow::printed(
            format!("final_spacing_error_{which}_m"),
            FINAL,
            printed.largest_spacing_error_m(),
            run.final_spacing_error_m(),
        )
        .note(
            "the larger of the two, from final true positions. The paper's own measured positions \
             are better spaced at the end without the limit than with it, though its text says that \
             the limit maintains the spacing better",
        )
        .depending_on(assumptions(which)),
    ]
}

/// A claim of the paper that a number is smaller with the torque limit.
struct LimitClaim {
    quantity: &'static str,
    source: &'static str,
    /// What the number is, with its unit.
    meaning: String,
    number: fn(&RecordedRun) -> f64,
}

/// The claims about the torque limit: each holds if its number is smaller with the limit.
fn claims(runs: &[RecordedRun; 2]) -> Vec<PaperRow> {
    let row = |claim: LimitClaim| {
        let [without, with] = runs.each_ref().map(claim.number);
        PaperRow::claim(claim.quantity, claim.source, with / without, with < without)
            .note(format!(
                "{}: {without:.4} without, {with:.4} with the limit",
                claim.meaning
            ))
            .depending_on(&ASSUMPTIONS)
    };
    claims_of_paper(runs).into_iter().map(row).collect()
}

/// Mean over the robots of the distance between encoders and truth at the end, along an axis (m).
fn mean_gap_m(run: &RecordedRun, axis: usize) -> f64 {
    let gaps = (0..run.robots()).map(|robot| run.final_gap_m(robot, axis).abs());
    gaps.sum::<f64>() / f64::from(run.robots())
}

fn claims_of_paper(runs: &[RecordedRun; 2]) -> [LimitClaim; 6] {
    [
        LimitClaim {
            quantity: "encoder_gap_with_over_without_limit",
            source: "\"errors in both x and y are much smaller\", section 4",
            meaning: "encoder against truth, mean (m)".to_owned(),
            number: |run| mean_gap_m(run, 0),
        },
        LimitClaim {
            quantity: "final_spacing_error_with_over_without_limit",
            source: SPACINGS,
            meaning: "largest true spacing error at the end (m)".to_owned(),
            number: RecordedRun::final_spacing_error_m,
        },
        LimitClaim {
            quantity: "rms_spacing_error_with_over_without_limit",
            source: SPACINGS,
            meaning: "root mean square of the true spacing errors from 3 s on (m)".to_owned(),
            number: RecordedRun::rms_spacing_error_m,
        },
        LimitClaim {
            quantity: "max_spacing_error_with_over_without_limit",
            source: SPACINGS,
            meaning: format!(
                "largest true spacing error from 3 s on (m), at {:.2} s without and {:.2} s with the \
                 limit: a transient, in which whoever may not accelerate as hard falls back further",
                runs[0].worst_spacing_at_s(),
                runs[1].worst_spacing_at_s()
            ),
            number: RecordedRun::max_spacing_error_m,
        },
        LimitClaim {
            quantity: "roughness_of_x_with_over_without_limit",
            source: "\"the positions change more smoothly\", Fig. 9 and 10",
            meaning: "root mean square jerk of x by odometry over the outer ticks (m/s³)"
                .to_owned(),
            number: RecordedRun::roughness_m_s3,
        },
        LimitClaim {
            quantity: "slip_time_with_over_without_limit",
            source: "\"wheel slip is avoided\", section 4",
            meaning: "all robots, both wheels together (s)".to_owned(),
            number: RecordedRun::slip_time_s,
        },
    ]
}
