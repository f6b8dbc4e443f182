//! Section 4: the platoon without and with the torque limit (Fig. 9 to 12, final positions).

use super::printed::{FINALS, Finals};
use super::row::Row;
use super::trial::Trial;

const FINAL: &str = "final positions, section 4";
const SPACINGS: &str = "\"the inter-vehicular spacings are maintained better\", section 4";
const WHICH: [&str; 2] = ["without_limit", "with_limit"];
/// What a straight run depends on: without the limit all but the last.
const ALL: [&str; 5] = ["profile", "gains", "motor", "friction", "limit"];

fn assumptions(which: &str) -> &'static [&'static str] {
    if which == WHICH[0] { &ALL[..4] } else { &ALL }
}

/// Final positions, then what the figures claim.
pub(super) fn rows(trials: &[Trial; 2]) -> Vec<Row> {
    let mut rows = Vec::new();
    for ((trial, printed), which) in trials.iter().zip(&FINALS).zip(WHICH) {
        rows.extend(finals(trial, printed, which));
    }
    for ((trial, printed), which) in trials.iter().zip(&FINALS).zip(WHICH) {
        rows.extend(gaps(trial, printed, which));
    }
    rows.extend(claims(trials));
    rows
}

fn finals(trial: &Trial, printed: &Finals, which: &str) -> Vec<Row> {
    let mut rows = Vec::new();
    for (i, (truth, agent)) in trial
        .reports
        .plant
        .robots
        .iter()
        .zip(&trial.reports.agents)
        .enumerate()
        .take(3)
    {
        for (axis, name) in [(0, "x"), (1, "y")] {
            for (by, paper, computed) in [
                ("encoder", printed.encoder[i], agent.final_odometry),
                ("true", printed.measured[i], truth.final_true),
            ] {
                let quantity = format!("final_{name}_r{}_{by}_{which}_m", i + 1);
                let row = Row::printed(quantity, FINAL, paper[axis], computed[axis]);
                rows.push(if axis == 0 {
                    row.note("the way is that of the assumed profile")
                        .on(assumptions(which))
                } else {
                    row.note("zero by symmetry: see the rows asymmetry_…")
                        .on(&["symmetry"])
                });
            }
        }
    }
    rows
}

fn gaps(trial: &Trial, printed: &Finals, which: &str) -> Vec<Row> {
    let robots = trial.robots();
    let mean = |axis: usize| {
        let gaps = (0..robots).map(|robot| trial.final_gap_m(robot, axis).abs());
        gaps.sum::<f64>() / f64::from(robots)
    };
    let signed = (0..robots)
        .map(|robot| trial.final_gap_m(robot, 0))
        .sum::<f64>()
        / f64::from(robots);
    vec![
        Row::printed(
            format!("mean_gap_x_{which}_m"),
            FINAL,
            printed.mean_gap_m(0),
            mean(0),
        )
        .note(format!(
            "encoder against truth. Here the encoders are {:.3} m {} on average; the paper's printed \
             encoders are behind in both experiments, against its own section 3, where slip puts \
             them ahead: sliding while braking or a wheel radius that is off would do that",
            signed.abs(),
            if signed >= 0.0 { "ahead" } else { "behind" }
        ))
        .on(assumptions(which)),
        Row::printed(
            format!("mean_gap_y_{which}_m"),
            FINAL,
            printed.mean_gap_m(1),
            mean(1),
        )
        .note("zero by symmetry: see the rows asymmetry_…")
        .on(&["symmetry"]),
        Row::printed(
            format!("final_spacing_error_{which}_m"),
            FINAL,
            printed.largest_spacing_error_m(),
            trial.final_spacing_error_m(),
        )
        .note(
            "the larger of the two, from final true positions. The paper's own measured positions \
             are better spaced at the end without the limit than with it, though its text says that \
             the limit maintains the spacing better",
        )
        .on(assumptions(which)),
    ]
}

/// What the limit is said to do: each a number without and with, and whether it is smaller with.
fn claims(trials: &[Trial; 2]) -> Vec<Row> {
    let mean_gap = |trial: &Trial| {
        let gaps = (0..trial.robots()).map(|robot| trial.final_gap_m(robot, 0).abs());
        gaps.sum::<f64>() / f64::from(trial.robots())
    };
    let pairs = [
        (
            "encoder_gap_with_over_without_limit",
            "\"errors in both x and y are much smaller\", section 4",
            "encoder against truth, mean (m)".to_owned(),
            trials.each_ref().map(mean_gap),
        ),
        (
            "final_spacing_error_with_over_without_limit",
            SPACINGS,
            "largest true spacing error at the end (m)".to_owned(),
            trials.each_ref().map(Trial::final_spacing_error_m),
        ),
        (
            "rms_spacing_error_with_over_without_limit",
            SPACINGS,
            "root mean square of the true spacing errors from 3 s on (m)".to_owned(),
            trials.each_ref().map(Trial::rms_spacing_error_m),
        ),
        (
            "max_spacing_error_with_over_without_limit",
            SPACINGS,
            format!(
                "largest true spacing error from 3 s on (m), at {:.2} s without and {:.2} s with the \
                 limit: a transient, in which whoever may not accelerate as hard falls back further",
                trials[0].worst_spacing_at_s(),
                trials[1].worst_spacing_at_s()
            ),
            trials.each_ref().map(Trial::max_spacing_error_m),
        ),
        (
            "roughness_of_x_with_over_without_limit",
            "\"the positions change more smoothly\", Fig. 9 and 10",
            "root mean square jerk of x by odometry over the outer ticks (m/s³)".to_owned(),
            trials.each_ref().map(Trial::roughness_m_s3),
        ),
        (
            "slip_time_with_over_without_limit",
            "\"wheel slip is avoided\", section 4",
            "all robots, both wheels together (s)".to_owned(),
            trials.each_ref().map(Trial::slip_time_s),
        ),
    ];
    pairs
        .into_iter()
        .map(|(quantity, source, what, [without, with])| {
            Row::claim(quantity, source, with / without, with < without)
                .note(format!(
                    "{what}: {without:.4} without, {with:.4} with the limit"
                ))
                .on(&ALL)
        })
        .collect()
}
