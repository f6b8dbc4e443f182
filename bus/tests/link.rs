//! Links seen from outside: statistics of delay and loss, and the order in which messages arrive.

#![allow(clippy::unwrap_used, reason = "a test may panic")]

use slipstream_bus::Settings;
use slipstream_bus::experiment::{Distribution, LinkSettings};
use slipstream_bus::link::{DelayLine, LinkImpairment};
use slipstream_bus::message::Position;
use slipstream_bus::time::s_from_ns;

fn impairment(change: impl Fn(&mut LinkSettings)) -> LinkImpairment {
    let mut links = Settings::default().links;
    change(&mut links);
    LinkImpairment::new(&links, &[], 7, 0, 1)
}

fn position(seq: u32, sent_ns: i64) -> Position {
    Position {
        seq,
        sampled_ns: sent_ns,
        sent_ns,
        ..Position::default()
    }
}

/// Over 20,000 messages: the mean within five standard errors, the deviation within 5 %.
#[test]
fn delays_have_the_configured_mean_and_deviation() {
    for distribution in [
        Distribution::Normal,
        Distribution::Uniform,
        Distribution::Lognormal,
    ] {
        let mut impairment = impairment(|links| {
            links.delay_s = 0.1;
            links.jitter_s = 0.02;
            links.distribution = distribution;
        });
        let n = 20_000;
        let delays: Vec<f64> = (0..n)
            .map(|_| s_from_ns(impairment.draw().unwrap()))
            .collect();
        let mean = delays.iter().sum::<f64>() / f64::from(n);
        let sd = (delays.iter().map(|d| (d - mean).powi(2)).sum::<f64>() / f64::from(n)).sqrt();
        assert!(
            (mean - 0.1).abs() < 5.0 * 0.02 / f64::from(n).sqrt(),
            "{distribution:?} {mean}"
        );
        assert!((sd - 0.02).abs() < 0.001, "{distribution:?} {sd}");
    }
}

#[test]
fn bursts_have_the_configured_loss_and_mean_length() {
    let mut impairment = impairment(|links| {
        links.loss = 0.1;
        links.burst = 5.0;
    });
    let (mut lost, mut bursts, mut before) = (0.0, 0.0, false);
    let n = 200_000;
    for _ in 0..n {
        let now = impairment.draw().is_none();
        lost += f64::from(u8::from(now));
        bursts += f64::from(u8::from(now && !before));
        before = now;
    }
    assert!((lost / f64::from(n) - 0.1).abs() < 0.01, "{lost}");
    assert!((lost / bursts - 5.0_f64).abs() < 0.25, "{bursts}");
}

#[test]
fn each_link_and_seed_has_its_own_random_numbers() {
    let links = LinkSettings {
        jitter_s: 0.01,
        delay_s: 0.1,
        ..Settings::default().links
    };
    let draw = |seed, to| LinkImpairment::new(&links, &[], seed, 0, to).draw();
    assert_eq!(draw(1, 1), draw(1, 1));
    assert_ne!(draw(1, 1), draw(1, 2));
    assert_ne!(draw(1, 1), draw(2, 1));
}

#[test]
fn a_trace_adds_half_of_each_round_trip_to_the_delay() {
    let links = LinkSettings {
        delay_s: 1e-6,
        ..Settings::default().links
    };
    let mut impairment = LinkImpairment::new(&links, &[Some(5), None, Some(7)], 7, 0, 1);
    let delays: Vec<_> = (0..4).map(|_| impairment.draw()).collect();
    assert_eq!(delays, [Some(1005), None, Some(1007), Some(1005)]);
}

#[test]
fn an_overtaken_message_is_stale_and_overtaking_can_be_excluded() {
    let links = LinkSettings {
        delay_s: 0.0,
        ..Settings::default().links
    };
    let slow_first = [Some(100), Some(20)];
    let line = |reorder| DelayLine::new(LinkImpairment::new(&links, &slow_first, 1, 0, 1), reorder);

    let mut overtaking = line(true);
    assert_eq!(overtaking.push(position(0, 0)), Some(100));
    assert_eq!(overtaking.push(position(1, 10)), Some(30));
    let arrivals: Vec<_> = std::iter::from_fn(|| overtaking.poll(200))
        .map(|a| (a.message.position.seq, a.stale))
        .collect();
    assert_eq!(arrivals, [(1, false), (0, true)]);
    assert_eq!(overtaking.counts().stale, 1);

    let mut in_order = line(false);
    in_order.push(position(0, 0));
    assert_eq!(in_order.push(position(1, 10)), Some(100));
    assert_eq!(in_order.poll(99), None);
}

#[test]
fn a_message_is_delivered_after_the_instant_of_sending() {
    let mut line = DelayLine::new(impairment(|_| {}), true);
    assert_eq!(line.push(position(0, 50)), Some(50));
    assert_eq!(line.poll(50), None);
    assert!(line.poll(51).is_some());
}

#[test]
fn messages_that_the_network_lost_are_those_left_out() {
    let mut line = DelayLine::new(impairment(|_| {}), true);
    // A restarted receiver does not know what came before, and a restarted sender may repeat a number.
    for (seq, missing) in [(7, 0), (8, 0), (11, 2), (11, 2), (12, 2), (20, 9)] {
        line.push(position(seq, i64::from(seq)));
        assert_eq!(line.counts().missing, missing, "{seq}");
    }
    assert_eq!(line.counts().received, 6);
}

/// From a time on messages are later; what they draw is the same.
#[test]
fn a_link_becomes_slower_for_messages_that_are_sent_from_then_on() {
    let change = |links: &mut LinkSettings| {
        links.delay_s = 0.1;
        links.jitter_s = 0.02;
        links.loss = 0.1;
    };
    let mut usual = DelayLine::new(impairment(change), true);
    let mut slower = DelayLine::new(impairment(change), true).with_later(vec![
        (500_000_000, 200_000_000),
        (800_000_000, -10_000_000_000),
    ]);
    for seq in 0..20 {
        let sent_ns = 50_000_000 * i64::from(seq);
        let [before, after] = [&mut usual, &mut slower].map(|own| own.push(position(seq, sent_ns)));
        let expected = before.map(|own| match sent_ns {
            ..500_000_000 => own,
            500_000_000..800_000_000 => own + 200_000_000,
            _ => sent_ns,
        });
        assert_eq!(after, expected, "message {seq}");
    }
}
