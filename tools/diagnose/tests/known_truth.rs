//! What the diagnosis says of recordings whose truth is known.

#![expect(
    clippy::unwrap_used,
    reason = "a test that cannot go on says so and stops"
)]

mod made;

use slipstream_bus::RobotModel;
use slipstream_diagnose::{Answer, Request, Verdict, diagnose};

fn answer(truth: &RobotModel, nominal: &RobotModel, seed: u64) -> (Answer, RobotModel) {
    let (answer, mut improved) = diagnose(&Request {
        recordings: &[made::record(truth, made::gentle, 12.0, seed)],
        model_of: &|_| Some(nominal.clone()),
        excluded: &[],
        excluded_s: &[],
        progress: &|_| (),
    })
    .unwrap();
    (answer, improved.remove(0).1)
}

#[test]
fn a_model_that_is_right_matches() {
    let model = RobotModel::default();
    let (answer, _) = answer(&model, &model, 1);
    assert_eq!(
        answer.verdict,
        Verdict::Match,
        "{}",
        serde_json::to_string(&answer).unwrap()
    );
}

#[test]
fn what_is_left_out_is_named_and_measured_and_then_matches() {
    let nominal = RobotModel::default();
    let truth = nominal
        .clone()
        .with("rolling_resistance", &[("coefficient", 0.008)]);
    let (first, improved) = answer(&truth, &nominal, 2);
    let text = serde_json::to_string(&first).unwrap();
    assert_eq!(first.verdict, Verdict::Explained, "{text}");
    let found: Vec<&str> = first.findings.iter().map(|f| f.effect.as_str()).collect();
    assert_eq!(found, ["rolling_resistance"], "{text}");
    let estimate = first.findings[0].parameters[0].estimate.unwrap();
    assert!((estimate - 0.008).abs() < 0.05 * 0.008, "{text}");
    assert!(
        first.held_out.nrmse_after < 0.5 * first.held_out.nrmse_before,
        "{text}"
    );
    let (again, _) = answer(&truth, &improved, 2);
    assert_eq!(
        again.verdict,
        Verdict::Match,
        "{}",
        serde_json::to_string(&again).unwrap()
    );
}
