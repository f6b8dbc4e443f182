//! A link from one robot to the next: the delay line, its chances, and what became of messages.
//!
//! The line stands at the receiver. What happens to message k depends on the run's seed, the link
//! and k alone, so that it does not matter when the receiver looks. A message used at an instant
//! was sent at an earlier one.

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution as _, LogNormal, Normal, Uniform};
use serde::{Deserialize, Serialize};

use crate::experiment::{Distribution, LinkSettings};
use crate::message::{Position, RobotIndex};
use crate::time::ns_from_s;

/// What is drawn for each message of a link, in the order of sending.
#[derive(Debug, Clone)]
pub struct LinkImpairment {
    rng: ChaCha8Rng,
    jitter: Jitter,
    delay_ns: i64,
    loss: Loss,
    in_burst: bool,
    half_round_trips_ns: Vec<Option<i64>>,
    drawn: usize,
}

#[derive(Debug, Clone)]
enum Jitter {
    None,
    Normal(Normal<f64>),
    Uniform(Uniform<f64>),
    Lognormal(LogNormal<f64>),
}

/// Gilbert–Elliott: no loss in the good state, nothing but loss in the bad one.
#[derive(Debug, Clone, Copy)]
enum Loss {
    Independent { share: f64 },
    Bursts { begin: f64, end: f64 },
}

impl LinkImpairment {
    /// The chances of the link `from` → `to` in a run with this seed.
    ///
    /// The settings must have been judged ([`crate::experiment::Settings::validate`]); a
    /// distribution that cannot be built counts as no jitter.
    pub fn new(
        links: &LinkSettings,
        half_round_trips_ns: &[Option<i64>],
        seed: u64,
        from: RobotIndex,
        to: RobotIndex,
    ) -> Self {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        rng.set_stream(u64::from(from) << 32 | u64::from(to));
        Self {
            rng,
            jitter: Jitter::new(links),
            delay_ns: ns_from_s(links.delay_s),
            loss: Loss::new(links),
            in_burst: false,
            half_round_trips_ns: half_round_trips_ns.to_vec(),
            drawn: 0,
        }
    }

    /// The delay of the next message (ns), or `None` when it is lost. Draws the same amount of
    /// chance either way.
    pub fn draw(&mut self) -> Option<i64> {
        let lost = self.draw_loss();
        let delay_ns = self.jitter.draw(&mut self.rng).unwrap_or(self.delay_ns);
        let traced = match self.half_round_trips_ns.len() {
            0 => Some(0),
            rows => self.half_round_trips_ns[self.drawn % rows],
        };
        self.drawn += 1;
        if lost { None } else { Some(delay_ns + traced?) }
    }

    fn draw_loss(&mut self) -> bool {
        let chance: f64 = self.rng.random();
        match self.loss {
            Loss::Independent { share } => chance < share,
            Loss::Bursts { begin, end } => {
                self.in_burst = if self.in_burst {
                    chance >= end
                } else {
                    chance < begin
                };
                self.in_burst
            }
        }
    }
}

impl Jitter {
    fn new(links: &LinkSettings) -> Self {
        let (mean, sd) = (links.delay_s, links.jitter_s);
        if sd == 0.0 {
            return Self::None;
        }
        match links.distribution {
            Distribution::Normal => Normal::new(mean, sd).map_or(Self::None, Self::Normal),
            Distribution::Uniform => {
                let half = 3f64.sqrt() * sd;
                Uniform::new(mean - half, mean + half).map_or(Self::None, Self::Uniform)
            }
            Distribution::Lognormal => {
                LogNormal::from_mean_cv(mean, sd / mean).map_or(Self::None, Self::Lognormal)
            }
        }
    }

    /// A delay (ns), none below 0; `None` where there is no jitter.
    fn draw(&self, rng: &mut ChaCha8Rng) -> Option<i64> {
        let delay_s = match self {
            Self::None => return None,
            Self::Normal(normal) => normal.sample(rng),
            Self::Uniform(uniform) => uniform.sample(rng),
            Self::Lognormal(lognormal) => lognormal.sample(rng),
        };
        Some(ns_from_s(delay_s.max(0.0)))
    }
}

impl Loss {
    fn new(links: &LinkSettings) -> Self {
        if links.burst == 0.0 || links.loss == 0.0 {
            return Self::Independent { share: links.loss };
        }
        let end = 1.0 / links.burst;
        Self::Bursts {
            begin: end * links.loss / (1.0 - links.loss),
            end,
        }
    }
}

/// What became of the messages of a link.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct LinkCounts {
    /// Taken from the bus by the receiver's end.
    pub received: u64,
    /// Left the delay line at the receiver.
    pub delivered: u64,
    /// Lost on the way.
    pub lost: u64,
    /// Delivered when a position sampled later had already come.
    pub stale: u64,
}

/// A message on its way, or just arrived.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct InFlight {
    /// The message.
    pub position: Position,
    /// When it leaves the delay line (ns).
    pub available_ns: i64,
}

/// The receiver's end of a link.
#[derive(Debug, Clone)]
pub struct DelayLine {
    impairment: LinkImpairment,
    reorder: bool,
    /// In the order of arrival; ties in the order of sending.
    in_flight: Vec<InFlight>,
    last_available_ns: i64,
    newest_sampled_ns: i64,
    counts: LinkCounts,
}

/// Messages that the line holds without growing. A run that has more under way grows it once.
const ROOM: usize = 1024;

/// A message that left the line.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Arrival {
    /// The message and its time.
    pub message: InFlight,
    /// A position sampled later had come before.
    pub stale: bool,
}

impl DelayLine {
    /// An empty line.
    pub fn new(impairment: LinkImpairment, reorder: bool) -> Self {
        Self {
            impairment,
            reorder,
            in_flight: Vec::with_capacity(ROOM),
            last_available_ns: 0,
            newest_sampled_ns: i64::MIN,
            counts: LinkCounts::default(),
        }
    }

    /// Puts a message in, in the order of sending. Says when it will be available (ns), `None` when
    /// it is lost.
    pub fn put(&mut self, position: Position) -> Option<i64> {
        self.counts.received += 1;
        let Some(delay_ns) = self.impairment.draw() else {
            self.counts.lost += 1;
            return None;
        };
        let mut available_ns = position.sent_ns.saturating_add(delay_ns);
        if !self.reorder {
            available_ns = available_ns.max(self.last_available_ns);
            self.last_available_ns = available_ns;
        }
        let place = self
            .in_flight
            .partition_point(|other| other.available_ns <= available_ns);
        self.in_flight.insert(
            place,
            InFlight {
                position,
                available_ns,
            },
        );
        Some(available_ns)
    }

    /// Takes out the next message that has arrived by `now_ns` and was sent before.
    pub fn take(&mut self, now_ns: i64) -> Option<Arrival> {
        let ready = |m: &InFlight| m.available_ns <= now_ns && m.position.sent_ns < now_ns;
        let place = self.in_flight.iter().position(ready)?;
        let message = self.in_flight.remove(place);
        let stale = message.position.sampled_ns < self.newest_sampled_ns;
        self.newest_sampled_ns = self.newest_sampled_ns.max(message.position.sampled_ns);
        self.counts.delivered += 1;
        self.counts.stale += u64::from(stale);
        Some(Arrival { message, stale })
    }

    /// What became of the messages so far.
    pub fn counts(&self) -> LinkCounts {
        self.counts
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::experiment::Settings;

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

    /// Mean and standard deviation (s) over 20000 messages: within five standard errors.
    #[test]
    fn delays_have_the_mean_and_deviation_that_were_asked_for() {
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
                .map(|_| crate::time::s_from_ns(impairment.draw().unwrap()))
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
    fn bursts_keep_the_share_and_have_the_length_that_were_asked_for() {
        let mut impairment = impairment(|links| {
            links.loss = 0.1;
            links.burst = 5.0;
        });
        let (mut lost, mut runs, mut before) = (0.0, 0.0, false);
        let n = 200_000;
        for _ in 0..n {
            let now = impairment.draw().is_none();
            lost += f64::from(u8::from(now));
            runs += f64::from(u8::from(now && !before));
            before = now;
        }
        assert!((lost / f64::from(n) - 0.1).abs() < 0.01, "{lost}");
        assert!((lost / runs - 5.0_f64).abs() < 0.25, "{runs}");
    }

    #[test]
    fn each_link_has_chances_of_its_own() {
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
    fn a_trace_gives_half_of_each_round_trip_plus_the_delay() {
        let links = LinkSettings {
            delay_s: 1e-6,
            ..Settings::default().links
        };
        let mut impairment = LinkImpairment::new(&links, &[Some(5), None, Some(7)], 7, 0, 1);
        let delays: Vec<_> = (0..4).map(|_| impairment.draw()).collect();
        assert_eq!(delays, [Some(1005), None, Some(1007), Some(1005)]);
    }

    #[test]
    fn the_newest_sampling_time_wins_and_older_arrivals_are_stale() {
        let links = LinkSettings {
            delay_s: 0.0,
            ..Settings::default().links
        };
        let slow_first = [Some(100), Some(20)];
        let line =
            |reorder| DelayLine::new(LinkImpairment::new(&links, &slow_first, 1, 0, 1), reorder);

        let mut overtaking = line(true);
        assert_eq!(overtaking.put(position(0, 0)), Some(100));
        assert_eq!(overtaking.put(position(1, 10)), Some(30));
        let arrivals: Vec<_> = std::iter::from_fn(|| overtaking.take(200))
            .map(|a| (a.message.position.seq, a.stale))
            .collect();
        assert_eq!(arrivals, [(1, false), (0, true)]);
        assert_eq!(overtaking.counts().stale, 1);

        let mut in_order = line(false);
        in_order.put(position(0, 0));
        assert_eq!(in_order.put(position(1, 10)), Some(100));
        assert_eq!(in_order.take(99), None);
    }

    #[test]
    fn what_was_sent_at_an_instant_is_used_at_a_later_one() {
        let mut line = DelayLine::new(impairment(|_| {}), true);
        assert_eq!(line.put(position(0, 50)), Some(50));
        assert_eq!(line.take(50), None);
        assert!(line.take(51).is_some());
    }
}
