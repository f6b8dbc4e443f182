//! Three robots on a circle, one behind the other.

use slipstream_recording::recording::{LinkMessage, Links, Pose as Poses, Stream};

use super::*;
use crate::answer::{Evidence, Finding, ParameterEstimate, Place};

const RADIUS_M: f64 = 3.0;
const SPACING_M: f64 = 0.6;

/// How far r2 and r3 are behind, beyond the usual (m), at a time (s).
type Beyond = fn(f64) -> [f64; 2];

/// The way of r1 (m): it stands for 2 s, drives, and stops at 56 s.
fn way_m(t_s: f64) -> f64 {
    0.4 * (t_s.clamp(2.0, 56.0) - 2.0) + 0.02 * (0.3 * t_s.clamp(2.0, 56.0)).sin()
}

fn noise(seed: f64) -> f64 {
    4e-3 * ((seed * 12.9898).sin() * 43758.5453).rem_euclid(1.0) - 2e-3
}

fn robot(number: usize, [from_s, to_s]: [f64; 2], beyond: Beyond, seed: f64) -> Robot {
    let mut robot = Robot::named(format!("r{}", number + 1));
    let mut rows = Poses {
        x_m: Vec::new(),
        y_m: Vec::new(),
        yaw_rad: Some(Vec::new()),
    };
    let first = (from_s * 20.0).round() as u32;
    let last = (to_s * 20.0).round() as u32;
    let mut t_s = Vec::new();
    for row in first..last {
        let at_s = f64::from(row) / 20.0 + 0.01 * number as f64;
        let [second, third] = beyond(at_s);
        let behind_m = [0.0, SPACING_M + second, 2.0 * SPACING_M + second + third][number];
        let angle = (way_m(at_s) - behind_m) / RADIUS_M;
        let of = |part: f64| noise(f64::from(row) + part + 0.1 * number as f64 + seed);
        rows.x_m.push(RADIUS_M * angle.sin() + of(0.3));
        rows.y_m.push(RADIUS_M * (1.0 - angle.cos()) + of(0.7));
        rows.yaw_rad.get_or_insert_default().push(angle);
        t_s.push(at_s);
    }
    robot.pose = Some(Stream {
        t_s,
        values: rows,
        unknown: Vec::new(),
    });
    robot
}

fn piece(span_s: [f64; 2], beyond: Beyond, seed: f64) -> Recording {
    let message = |from: &str, to: &str| LinkMessage {
        t_sent_s: span_s[0],
        t_received_s: Some(span_s[0]),
        from: Arc::from(from),
        to: Arc::from(to),
        x_m: 0.0,
        y_m: 0.0,
        yaw_rad: 0.0,
        v_m_s: 0.0,
        w_rad_s: 0.0,
    };
    let messages = vec![
        message("r1", "r2"),
        message("r2", "r3"),
        message("r3", "r1"),
    ];
    Recording {
        robots: (0..3).map(|own| robot(own, span_s, beyond, seed)).collect(),
        links: Some(Links {
            messages,
            ..Links::default()
        }),
        ..Recording::default()
    }
}

fn formation() -> Formation {
    Formation::new(&[piece([0.0, 60.0], |_| [0.0; 2], 0.0)])
}

/// Warnings of a minute; a slower link is said at 31 s if it is there.
fn said(formation: &mut Formation, beyond: Beyond, has_cause: bool) -> Vec<(f64, Warning)> {
    let mut said = Vec::new();
    for k in 0..120 {
        let begin_s = 0.5 * f64::from(k);
        let mut events = Vec::new();
        if has_cause && k == 62 {
            events.push(slower());
        }
        formation.hear(&piece([begin_s, begin_s + 0.5], beyond, 0.05), &mut events);
        said.extend(events.into_iter().filter_map(|own| match own {
            Event::Fault(t_s, warning) => Some((t_s, warning)),
            Event::Change(_) => None,
        }));
    }
    said
}

/// The link from r1 to r2 is 200 ms slower since 30 s.
fn slower() -> Event {
    let finding = Finding {
        robot: "r2".to_owned(),
        effect: "link_delay".to_owned(),
        statement: String::new(),
        parameters: vec![ParameterEstimate {
            name: "delay_s".to_owned(),
            unit: "s".to_owned(),
            nominal: Some(0.0),
            nominal_ci95: None,
            estimate: Some(0.2),
            ci95: Some([0.199, 0.201]),
            text: None,
        }],
        place: Place {
            channel: "link".to_owned(),
            intervals_s: Vec::new(),
            condition: "link r1 to r2".to_owned(),
        },
        runs: None,
        confused_with: Vec::new(),
        evidence: Evidence {
            log_likelihood_gain: 30.0,
            p_value: 0.0,
        },
        shape: None,
        driver: None,
        actions: Vec::new(),
    };
    Event::Change(Box::new(Change {
        t_s: 31.0,
        onset_s: 30.0,
        robot: "r2".to_owned(),
        finding,
        state: State::Raised,
    }))
}

#[test]
fn followers_are_those_behind_from_the_front() {
    let formation = formation();
    let names: Vec<(&str, &str)> = formation
        .followers
        .iter()
        .map(|own| (&*own.ahead, &*own.name))
        .collect();
    assert_eq!(names, [("r1", "r2"), ("r2", "r3")]);
    for own in &formation.followers {
        assert!((own.usual.spacing_m - SPACING_M).abs() < 0.01, "{own:?}");
        assert!(own.usual.range_m < 0.03, "{own:?}");
    }
}

#[test]
fn a_spacing_that_does_not_change_is_not_said() {
    let mut formation = formation();
    assert_eq!(said(&mut formation, |_| [0.0; 2], true).len(), 0);
}

/// Grows within two seconds from `from_s` on, and goes at `to_s`.
fn grows(t_s: f64, from_s: f64, to_s: f64) -> f64 {
    0.12 * ((t_s - from_s) / 2.0).clamp(0.0, 1.0) * ((to_s - t_s) / 2.0).clamp(0.0, 1.0)
}

#[test]
fn a_spacing_that_leaves_its_range_is_said_with_its_cause_and_when_it_is_back() {
    let mut formation = formation();
    let all = said(&mut formation, |t_s| [grows(t_s, 30.0, 42.0), 0.0], true);
    let ids: Vec<&str> = all.iter().map(|own| own.1.id.as_str()).collect();
    assert_eq!(ids, ["spacing", "spacing_back"], "{all:?}");
    let (t_s, first) = &all[0];
    assert_eq!(first.robot.as_deref(), Some("r2"));
    assert!((31.0..34.0).contains(t_s), "{t_s}");
    let begin = "since 30.5 s it keeps 0.1";
    let end = "m): messages come 200 ms later on the link r1 to r2, since 30.0 s";
    assert!(first.statement.starts_with(begin), "{}", first.statement);
    assert!(
        first
            .statement
            .contains(" m too much distance from r1 (baseline 0.60 ± 0.01")
    );
    assert!(first.statement.ends_with(end), "{}", first.statement);
}

#[test]
fn the_first_that_left_is_named_where_no_cause_is_known() {
    let mut formation = formation();
    let both: Beyond = |t_s| [grows(t_s, 30.0, 70.0), grows(t_s, 31.0, 70.0)];
    let all = said(&mut formation, both, false);
    let of = |name: &str| all.iter().find(|own| own.1.robot.as_deref() == Some(name));
    let (second, third) = (of("r2").unwrap(), of("r3").unwrap());
    assert!(
        second.1.statement.ends_with("no cause is known"),
        "{}",
        second.1.statement
    );
    let end = "the spacing of r2 left its range first, at 30.5 s";
    assert!(third.1.statement.ends_with(end), "{}", third.1.statement);
    assert_eq!(all.len(), 2, "{all:?}");
}
