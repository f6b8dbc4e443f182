//! The paper's experiments: expected results, and the completeness of the comparison.
#![allow(clippy::unwrap_used, clippy::panic, reason = "a test may panic")]

use slipstream_study::reproduce::{Comparison, Extension, PaperRow, PaperRuns, reproduce};

#[test]
fn every_row_is_present_with_a_note() {
    let reproduction = reproduce().unwrap();
    let comparison = &reproduction.comparison;
    let row = |name: &str| -> &PaperRow {
        let found = comparison.rows.iter().find(|row| row.quantity == name);
        found.unwrap_or_else(|| panic!("no row {name}"))
    };
    let computed = |name: &str| row(name).computed.unwrap();
    assert!((computed("torque_limit_nm") - 0.0920).abs() < 5e-5);
    assert_eq!(row("torque_limit_nm").agrees, Some(true));
    assert!((computed("wheel_acceleration_rad_s2") - 40.9).abs() < 0.05);
    assert_eq!(row("wheel_acceleration_rad_s2").agrees, Some(false));
    // Section 3: with the limit encoder and camera match, without it they do not.
    assert!(computed("single_gap_without_limit_m") > 0.1);
    assert!(computed("single_gap_with_limit_m").abs() < 0.01);
    assert!(computed("single_slip_after_torque_ends_s") > 0.1);
    // The claims about the torque limit.
    for name in [
        "encoder_gap_with_over_without_limit",
        "final_spacing_error_with_over_without_limit",
        "roughness_of_x_with_over_without_limit",
        "slip_time_with_over_without_limit",
    ] {
        assert!(computed(name) < 1.0, "{name}");
        assert_eq!(row(name).agrees, Some(true), "{name}");
    }
    // All 24 final coordinates that the paper prints.
    let finals = comparison
        .rows
        .iter()
        .filter(|row| row.quantity.starts_with("final_x_r"));
    assert_eq!(finals.count(), 12);
    for row in &comparison.rows {
        assert!(!row.note.is_empty(), "{}", row.quantity);
        for name in &row.depends_on {
            let mut assumed = comparison.assumptions.iter().map(|one| &one.assumed.name);
            assert!(assumed.any(|assumed| assumed == name), "{name}");
        }
    }
    turning(&comparison.extensions);
    let text = serde_json::to_string(comparison).unwrap();
    assert_eq!(
        text,
        serde_json::to_string(&reproduce().unwrap().comparison).unwrap(),
    );
    let again: Comparison = serde_json::from_str(&text).unwrap();
    assert_eq!(again, *comparison);
    assert_eq!(serde_json::to_string(&again).unwrap(), text);
}

/// A row that changes with an assumption's keys names the assumption; rows that are zero by symmetry,
/// up to the resolution of the encoders, change by less than a centimetre.
#[test]
fn rows_name_what_they_depend_on() {
    let before = PaperRuns::new(&[]).unwrap().rows().unwrap();
    let slower = "[0.0, 0.2, 0.2, 0.66, 0.66, 0.0]";
    for (name, other) in [
        ("profile", &[("profile.speeds_m_s", slower)][..]),
        ("gains", &[("control.k_x", "1.3"), ("control.k_p", "0.05")]),
        (
            "motor",
            &[
                ("control.torque_max_nm", "0.11"),
                ("open_loop.torque_nm", "0.11"),
            ],
        ),
    ] {
        let after = PaperRuns::new(other).unwrap().rows().unwrap();
        let mut changed = 0;
        for (before, after) in before.iter().zip(&after) {
            let [was, is] = [before, after].map(|row| row.computed.unwrap());
            if (was - is).abs() > 0.01 {
                assert!(
                    before.depends_on.iter().any(|one| one == name),
                    "{name}: {before:?} {is}"
                );
                changed += 1;
            }
        }
        assert!(changed >= 3, "{name}: {changed}");
    }
}

/// The turns need more traction than the floor has: every limit reduces slip, and the law that takes
/// the lateral force into account reduces it most.
fn turning(extensions: &[Extension]) {
    let of = |experiment: &str, law: &str, limit: &str| -> &Extension {
        let is = |one: &&Extension| {
            [&*one.experiment, &*one.law, &*one.torque_limit] == [experiment, law, limit]
        };
        extensions.iter().find(is).unwrap()
    };
    for experiment in ["circle", "figure_eight", "lane_change"] {
        let none = of(experiment, "paper", "none");
        let fixed = ["inner", "outer"].map(|limit| of(experiment, "paper", limit));
        for limited in fixed {
            assert!(
                limited.slip_time_s < 0.85 * none.slip_time_s,
                "{limited:?} {none:?}"
            );
            assert!(
                limited.mean_final_gap_m < 0.7 * none.mean_final_gap_m,
                "{limited:?} {none:?}"
            );
        }
        let computed = of(experiment, "computed_torque", "inner");
        assert!(
            computed.slip_time_s < 0.1 * fixed[0].slip_time_s,
            "{computed:?} {fixed:?}"
        );
        assert!(
            computed.mean_final_gap_m < 0.1 * fixed[0].mean_final_gap_m,
            "{computed:?}"
        );
        // No robot falls back by more than a quarter of the spacing.
        assert!(computed.max_spacing_error_m < 0.15, "{computed:?}");
    }
    let all = ["circle", "figure_eight", "lane_change"].map(|name| of(name, "paper", "inner"));
    assert!(all[0].slip_time_s < all[1].slip_time_s && all[2].slip_time_s < all[0].slip_time_s);
}
