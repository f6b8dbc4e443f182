//! The loop closed: three boxes with concealed effects drive, the diagnosis of that one recording names each, and the
//! improved models in simulation predict the run.

use crate::common::read_json;
use crate::lab::Lab;

/// What the boxes conceal: a smaller wheel, a slow drive, a floor on which the left wheel slips.
const CONCEALED: [&str; 3] = [
    "wheel_radius = { right_scale = 0.96, left_scale = 1.0 }",
    "actuator_lag = { time_constant_s = 0.15 }",
    "slip_ratio = { ratio = 0.08, asymmetry = 0.0 }",
];

#[test]
fn what_boxes_conceal_is_named_and_the_improved_models_predict_their_run() {
    let mut lab = Lab::of(&CONCEALED);
    let run = [
        "run",
        "circle",
        "--clock",
        "wall",
        "--real",
        "robots.toml",
        "--arm",
    ];
    let out = ["--out", "real.mcap", "--json", "real.json"];
    lab.succeeds(&[&run[..], &out].concat());
    lab.end_boxes();
    let diagnose = [
        "diagnose",
        "real.mcap",
        "--json",
        "found.json",
        "--improved",
        "better.toml",
    ];
    lab.succeeds(&diagnose);
    check_findings(&lab);

    let simulate = |models: &[&str], name: &str| {
        let mut all = vec!["run", "real.mcap", "--json", name, "--no-recording"];
        for model in models {
            all.extend(["--robot", model]);
        }
        lab.succeeds(&all);
        read_json(&lab.file(name))
    };
    let better = [
        "r1=better.r1.toml",
        "r2=better.r2.toml",
        "r3=better.r3.toml",
    ];
    let (before, after) = (
        simulate(&[], "before.json"),
        simulate(&better, "after.json"),
    );
    let real = read_json(&lab.file("real.json"));
    for follower in 1..3 {
        let spacing_cm = |run: &serde_json::Value| {
            100.0
                * run["robots"][follower]["max_spacing_error_m"]
                    .as_f64()
                    .unwrap()
        };
        let [real, before, after] = [&real, &before, &after].map(spacing_cm);
        eprintln!(
            "r{}: spacing error {real:.1} cm; simulated {before:.1}, improved {after:.1}",
            follower + 1
        );
        assert!((after - real).abs() < 3.0 && (after - real).abs() < (before - real).abs() / 5.0);
    }
    let place = |run: &serde_json::Value, robot: usize| {
        [0, 1].map(|i| run["robots"][robot]["final_true"][i].as_f64().unwrap())
    };
    for robot in 0..3 {
        let ([x, y], [u, v]) = (place(&real, robot), place(&after, robot));
        assert!(
            (x - u).hypot(y - v) < 0.05,
            "r{}: {x}, {y} and {u}, {v}",
            robot + 1
        );
    }
}

/// Each robot has its effect, by its number.
fn check_findings(lab: &Lab) {
    let found = read_json(&lab.file("found.json"));
    let findings = found["findings"].as_array().unwrap();
    for (robot, effects, parameter, value, tolerance) in [
        ("r1", &["wheel_radius"][..], "right_scale", 0.96, 0.002),
        ("r2", &["actuator_lag"][..], "time_constant_s", 0.15, 0.01),
        // In one recording a floor on which both wheels slip cannot be told from smaller wheels.
        ("r3", &["slip_ratio", "wheel_radius"][..], "", 0.08, 0.004),
    ] {
        let own = findings.iter().find(|finding| {
            let effect = finding["effect"].as_str().unwrap();
            finding["robot"] == robot && effects.contains(&effect)
        });
        let own = own.unwrap_or_else(|| panic!("{robot}: {found}"));
        let parameters = own["parameters"].as_array().unwrap();
        let estimate = |name: &str| {
            let own = parameters.iter().find(|own| own["name"] == name)?;
            own["estimate"].as_f64()
        };
        let estimate = match parameter {
            "" => estimate("ratio").or_else(|| Some(1.0 - estimate("right_scale")?)),
            name => estimate(name),
        };
        let estimate = estimate.unwrap();
        assert!((estimate - value).abs() < tolerance, "{robot}: {estimate}");
    }
}
