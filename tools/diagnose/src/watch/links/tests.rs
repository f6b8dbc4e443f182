//! Links with simulated delays.

use std::sync::Arc;

use slipstream_recording::recording::{LinkMessage, Links as Sent};

use super::*;
use crate::watch::alarm::State;

const RATE_HZ: f64 = 20.0;

/// Numbers that look random.
struct Draws(u64);

impl Draws {
    fn uniform(&mut self) -> f64 {
        let mut own = self.0;
        own ^= own << 13;
        own ^= own >> 7;
        own ^= own << 17;
        self.0 = own;
        ((own >> 11) as f64 + 0.5) / (1_u64 << 53) as f64
    }

    fn normal(&mut self) -> f64 {
        let radius = (-2.0 * self.uniform().ln()).sqrt();
        radius * (std::f64::consts::TAU * self.uniform()).cos()
    }
}

/// A link that may become slower.
#[derive(Clone, Copy)]
struct Case {
    median_s: f64,
    /// Deviation of the logarithm of the delay.
    spread: f64,
    loss: f64,
    /// How much later messages come from a time (s) on (s).
    later: (f64, f64),
}

const STEADY: Case = Case {
    median_s: 0.08,
    spread: 0.0,
    loss: 0.0,
    later: (f64::INFINITY, 0.0),
};

/// Overtaking: neighbours differ by more than the interval of sending.
const RESTLESS: Case = Case {
    spread: 0.8,
    loss: 0.1,
    ..STEADY
};

impl Case {
    fn message(self, number: u32, draws: &mut Draws) -> LinkMessage {
        let t_sent_s = f64::from(number) / RATE_HZ;
        let mut delay_s = self.median_s * (self.spread * draws.normal()).exp();
        if t_sent_s >= self.later.0 {
            delay_s += self.later.1;
        }
        let arrived = draws.uniform() >= self.loss;
        LinkMessage {
            t_sent_s,
            t_received_s: arrived.then_some(t_sent_s + delay_s),
            from: Arc::from("r1"),
            to: Arc::from("r2"),
            x_m: 0.0,
            y_m: 0.0,
            yaw_rad: 0.0,
            v_m_s: 0.0,
            w_rad_s: 0.0,
        }
    }

    /// Messages from one number up to another, in the order of sending.
    fn piece(self, numbers: std::ops::Range<u32>, draws: &mut Draws) -> Recording {
        let messages = numbers.map(|number| self.message(number, draws)).collect();
        let links = Sent {
            messages,
            ..Sent::default()
        };
        Recording {
            links: Some(links),
            ..Recording::default()
        }
    }

    /// What is said within so many seconds beside a baseline of a minute.
    fn watched(self, seconds: u32, seed: u64) -> Vec<Event> {
        let mut draws = Draws(seed);
        let usual = Self {
            later: STEADY.later,
            ..self
        };
        let baseline = usual.piece(0..60 * 20, &mut draws);
        let mut links = Links::new(&[baseline], &[], 4.0);
        let pieces = (0..seconds * 2).map(|k| self.piece(k * 10..(k + 1) * 10, &mut draws));
        pieces.flat_map(|piece| links.hear(&piece)).collect()
    }
}

fn changes(events: &[Event]) -> Vec<&Change> {
    let all = events.iter().map(|own| match own {
        Event::Change(change) => &**change,
        Event::Fault(_, warning) => panic!("{}", warning.statement),
    });
    all.collect()
}

/// Asserts that a slower link is raised and confirmed; how long it took (s).
fn assert_found(case: Case, seed: u64) -> f64 {
    let (onset_s, by_s) = case.later;
    let events = case.watched(60, seed);
    let all = changes(&events);
    let states: Vec<State> = all.iter().map(|own| own.state).collect();
    assert_eq!(states, [State::Raised, State::Confirmed], "seed {seed}");
    for own in &all {
        assert_eq!(
            (own.robot.as_str(), own.finding.effect.as_str()),
            ("r2", EFFECT)
        );
        assert_eq!(own.finding.place.condition, "link r1 to r2");
        assert!(
            (own.onset_s - onset_s).abs() < 1.0,
            "since {} s",
            own.onset_s
        );
    }
    let delay = &all[1].finding.parameters[0];
    let ([low, high], truth) = (delay.ci95.unwrap(), case.median_s + by_s);
    let wide = high - low;
    assert!(
        low - wide / 2.0 < truth && truth < high + wide / 2.0,
        "{truth}: {low} to {high}"
    );
    all[0].t_s - onset_s
}

#[test]
fn a_slower_link_is_found_with_its_onset_and_size() {
    for (spread, loss, by_s, most_s) in [
        (0.0, 0.0, 0.2, 1.0),
        (0.0, 0.0, 0.012, 1.0),
        (0.3, 0.1, 0.2, 1.5),
        (0.8, 0.1, 0.2, 4.0),
        (0.3, 0.1, -0.03, 3.0),
    ] {
        let case = Case {
            spread,
            loss,
            later: (20.0, by_s),
            ..STEADY
        };
        let times = (1..20).map(|seed| assert_found(case, 77 * seed));
        let longest_s = times.fold(0.0, f64::max);
        assert!(
            longest_s < most_s,
            "{by_s} s later: found after {longest_s} s"
        );
    }
}

#[test]
fn the_interval_holds_the_size() {
    let case = Case {
        later: (20.0, 0.2),
        ..RESTLESS
    };
    let held = (1..=200).filter(|seed| {
        let events = case.watched(40, 31 * seed);
        let all = changes(&events);
        let [low, high] = all[1].finding.parameters[0].ci95.unwrap();
        (low..=high).contains(&(case.median_s + 0.2))
    });
    let held = held.count();
    assert!((180..=200).contains(&held), "{held} of 200");
}

#[test]
fn jitter_loss_and_overtaking_are_no_change() {
    let cases = [
        STEADY,
        RESTLESS,
        Case {
            spread: 0.3,
            ..RESTLESS
        },
    ];
    for (case, seed) in cases.into_iter().zip(1..) {
        let events = case.watched(hours(1), 911 * seed);
        assert_eq!(changes(&events).len(), 0, "case {seed}");
    }
}

#[test]
#[ignore = "takes a minute; see `just watch`"]
fn false_alarms_are_as_rare_as_said() {
    let alarms = (1..=20_u64).map(|seed| {
        let events = RESTLESS.watched(hours(10), 911 * seed);
        changes(&events)
            .iter()
            .filter(|own| own.state == State::Raised)
            .count()
    });
    // one in ten hours is shared by four
    let alarms: usize = alarms.sum();
    println!("{alarms} false alarms in 200 h");
    assert!(alarms <= 5, "{alarms} in 200 h");
}

fn hours(count: u32) -> u32 {
    3600 * count
}

#[test]
fn what_goes_back_at_once_is_withdrawn() {
    let mut draws = Draws(5);
    let slow = Case {
        median_s: 0.3,
        ..STEADY
    };
    let mut links = Links::new(&[STEADY.piece(0..600, &mut draws)], &[], 4.0);
    let parts = [(STEADY, 0..100), (slow, 100..140), (STEADY, 140..400)];
    let events: Vec<Event> = parts
        .into_iter()
        .flat_map(|(case, numbers)| links.hear(&case.piece(numbers, &mut draws)))
        .collect();
    let states: Vec<State> = changes(&events).iter().map(|own| own.state).collect();
    assert_eq!(states, [State::Raised, State::Withdrawn]);
}

#[test]
fn a_link_that_falls_silent_is_said_once_and_when_it_is_back() {
    let mut draws = Draws(6);
    let mut links = Links::new(&[RESTLESS.piece(0..600, &mut draws)], &[], 4.0);
    let nothing = Case {
        loss: 1.0,
        ..RESTLESS
    };
    let parts = [
        (RESTLESS, 0..200),
        (nothing, 200..300),
        (RESTLESS, 300..500),
    ];
    let mut said = Vec::new();
    for (case, numbers) in parts {
        for begin in numbers.step_by(10) {
            said.extend(links.hear(&case.piece(begin..begin + 10, &mut draws)));
        }
    }
    let ids: Vec<(f64, String)> = said
        .iter()
        .map(|own| match own {
            Event::Fault(t_s, warning) => (*t_s, warning.id.clone()),
            Event::Change(change) => panic!("{}", change.finding.statement),
        })
        .collect();
    assert_eq!(ids.len(), 2, "{ids:?}");
    assert_eq!(
        (ids[0].1.as_str(), ids[1].1.as_str()),
        ("link_silent", "link_back")
    );
    assert!((10.5..13.0).contains(&ids[0].0), "{ids:?}");
}
