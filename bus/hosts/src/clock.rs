//! Clock of a host: its offset and drift against the clock of the plant's host.
//!
//! The host asks for the time again and again. Four time stamps of one exchange bound the offset: the answer was
//! stamped between question and answer (Mills, RFC 5905, section 8). The bounds of all exchanges hold together, each
//! widened by the largest drift that two clocks can have since, so the offset lies where they overlap (after Marzullo
//! and Owicki, 1983). All times are in ns. No clock is read here.

use std::collections::VecDeque;

use serde::{Deserialize, Serialize};
use slipstream_bus::time::NS_PER_S;

/// Largest drift between two clocks (parts per million). Crystals are off by 50 at most; while NTP corrects a clock, the
/// kernel lets it run faster or slower by up to 500.
const LARGEST_DRIFT_PPM: i64 = 500;
/// Fastest correction of the clock that a host shows to its agents (parts per million).
const SLEW_PPM: i64 = 500;
/// Time in which an error is corrected to a third, unless that is faster than [`SLEW_PPM`] (ns).
const CORRECTION_NS: i128 = 250_000_000;
/// A clock that is further behind was suspended with its host, and jumps forward (ns). It never jumps back.
const LARGEST_LAG_NS: i64 = 10_000_000;
/// Number of exchanges after which a clock is known.
const FIRST_EXCHANGES: u64 = 8;
/// Number of seconds whose best exchanges tell the drift: at most, and at least.
const DRIFT_SECONDS: usize = 60;
const FIRST_DRIFT_SECONDS: usize = 10;
/// No computer runs for so long (ns): 70 years.
const LARGEST_TIME_NS: i64 = i64::MAX / 4;
const PPM: i64 = 1_000_000;

/// Answer to a question for the time.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub struct Stamps {
    /// When the host asked, on its clock.
    pub asked_ns: i64,
    /// When the question came, on the clock of the plant's host.
    pub received_ns: i64,
    /// When the answer left, on the clock of the plant's host.
    pub sent_ns: i64,
}

/// What is known of the clock of a host at one instant.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub struct ClockReport {
    /// The instant, on the clock of the host.
    pub host_ns: i64,
    /// Its clock minus that of the plant's host.
    pub offset_ns: i64,
    /// The true offset differs by at most this.
    pub bound_ns: i64,
    /// How much faster it runs (parts per 10⁹); `None` in the first ten seconds.
    pub drift_ppb: Option<i64>,
    /// Smallest round trip since the last report.
    pub round_trip_ns: i64,
    /// Largest error of the time of the run on the host since the last report: the bound, wider between two
    /// exchanges, and what is left to correct.
    pub error_ns: i64,
}

/// A complete exchange.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct Exchange {
    /// Its middle, on the clock of the host.
    at_ns: i64,
    offset_ns: i64,
    round_trip_ns: i64,
}

/// Interval that holds the offset.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct Interval {
    /// When it holds, on the clock of the host.
    at_ns: i64,
    low_ns: i64,
    high_ns: i64,
}

/// The clock of a host, as the host itself knows it.
#[derive(Debug, Clone, Default)]
pub(crate) struct HostClock {
    interval: Option<Interval>,
    exchanges: u64,
    /// The best exchange since the last report.
    best: Option<Exchange>,
    reported_ns: Option<i64>,
    /// The best exchange of each of the last seconds.
    seconds: VecDeque<Exchange>,
    /// The offset in use, and since when.
    in_use: Option<(i64, i64)>,
    /// Largest error of the offset in use since the last report.
    error_ns: i64,
}

impl HostClock {
    /// Takes an answer that came at `answered_ns` on the clock of the host. One that contradicts itself is dropped.
    pub(crate) fn take(&mut self, stamps: &Stamps, answered_ns: i64) {
        let Some(exchange) = Exchange::new(stamps, answered_ns) else {
            return;
        };
        let is_better = |best: Exchange| exchange.round_trip_ns < best.round_trip_ns;
        if self.best.is_none_or(is_better) {
            self.best = Some(exchange);
        }
        let own = exchange.interval();
        let before = self.interval.map(|known| known.at(own.at_ns));
        // Without an overlap a clock was set or its host suspended: what was known before no longer holds.
        let both = before.and_then(|before| before.overlap(own));
        self.interval = Some(both.unwrap_or(own));
        self.exchanges += 1;
    }

    /// Whether there were enough exchanges to begin with.
    pub(crate) fn is_known(&self) -> bool {
        self.exchanges >= FIRST_EXCHANGES
    }

    /// The offset in use from `now_ns` on. It follows the estimate gradually, so that time does not go backwards.
    pub(crate) fn advance(&mut self, now_ns: i64) -> i64 {
        let Some(estimate_ns) = self.interval.map(Interval::middle_ns) else {
            return 0;
        };
        self.note_error(now_ns);
        let offset_ns = match self.in_use {
            Some((offset_ns, since_ns)) if offset_ns - estimate_ns <= LARGEST_LAG_NS => {
                let passed_ns = now_ns.saturating_sub(since_ns).max(0);
                let largest_ns = share(passed_ns, SLEW_PPM);
                let error_ns = i128::from(estimate_ns) - i128::from(offset_ns);
                let share_ns = error_ns * i128::from(passed_ns).min(CORRECTION_NS) / CORRECTION_NS;
                let largest = i128::from(largest_ns);
                offset_ns + share_ns.clamp(-largest, largest) as i64
            }
            _ => estimate_ns,
        };
        self.in_use = Some((offset_ns, now_ns));
        self.note_error(now_ns);
        offset_ns
    }

    /// Keeps the largest error that the offset in use may have at `now_ns`.
    fn note_error(&mut self, now_ns: i64) {
        let known = self.interval.zip(self.in_use);
        if let Some((interval, (offset_ns, _))) = known {
            let interval = interval.at(now_ns);
            let error_ns = (interval.high_ns - offset_ns).max(offset_ns - interval.low_ns);
            self.error_ns = self.error_ns.max(error_ns);
        }
    }

    /// What is known of the clock, if a second has passed since the last report and a question was answered in it.
    pub(crate) fn report(&mut self, now_ns: i64) -> Option<ClockReport> {
        let &mut reported_ns = self.reported_ns.get_or_insert(now_ns);
        let is_due = now_ns - reported_ns >= NS_PER_S && self.best.is_some();
        is_due.then(|| self.report_now(now_ns)).flatten()
    }

    /// What is known of the clock.
    pub(crate) fn report_now(&mut self, now_ns: i64) -> Option<ClockReport> {
        self.note_error(now_ns);
        let interval = self.interval?.at(now_ns);
        self.reported_ns = Some(now_ns);
        if let Some(best) = self.best.take() {
            if self.seconds.len() == DRIFT_SECONDS {
                self.seconds.pop_front();
            }
            self.seconds.push_back(best);
        }
        Some(ClockReport {
            host_ns: now_ns,
            offset_ns: interval.middle_ns(),
            bound_ns: interval.bound_ns(),
            drift_ppb: drift_ppb(&self.seconds),
            round_trip_ns: self.seconds.back()?.round_trip_ns,
            error_ns: std::mem::take(&mut self.error_ns),
        })
    }
}

impl Exchange {
    fn new(stamps: &Stamps, answered_ns: i64) -> Option<Self> {
        let passed_ns = answered_ns.checked_sub(stamps.asked_ns)?;
        let held_ns = stamps.sent_ns.checked_sub(stamps.received_ns)?;
        let round_trip_ns = passed_ns.checked_sub(held_ns)?;
        if held_ns < 0 || round_trip_ns < 0 {
            return None;
        }
        let there_ns = stamps.asked_ns.checked_sub(stamps.received_ns)?;
        let back_ns = answered_ns.checked_sub(stamps.sent_ns)?;
        let offset_ns = there_ns + back_ns.checked_sub(there_ns)? / 2;
        let is_absurd = offset_ns.saturating_abs().max(round_trip_ns) > LARGEST_TIME_NS;
        (!is_absurd).then_some(Self {
            at_ns: stamps.asked_ns + passed_ns / 2,
            offset_ns,
            round_trip_ns,
        })
    }

    /// The offset lies within half a round trip, and 1 ns for what was rounded.
    fn interval(&self) -> Interval {
        let half_ns = self.round_trip_ns / 2 + 1;
        Interval {
            at_ns: self.at_ns,
            low_ns: self.offset_ns - half_ns,
            high_ns: self.offset_ns + half_ns,
        }
    }
}

impl Interval {
    /// The interval at another instant.
    fn at(self, at_ns: i64) -> Self {
        let drifted_ns = share(
            at_ns.saturating_sub(self.at_ns).saturating_abs(),
            LARGEST_DRIFT_PPM,
        );
        Self {
            at_ns,
            low_ns: self.low_ns - drifted_ns,
            high_ns: self.high_ns + drifted_ns,
        }
    }

    /// What lies in both.
    fn overlap(self, other: Self) -> Option<Self> {
        let (low_ns, high_ns) = (
            self.low_ns.max(other.low_ns),
            self.high_ns.min(other.high_ns),
        );
        (low_ns <= high_ns).then_some(Self {
            at_ns: self.at_ns,
            low_ns,
            high_ns,
        })
    }

    fn middle_ns(self) -> i64 {
        self.low_ns + (self.high_ns - self.low_ns) / 2
    }

    /// Largest distance of its ends from its middle.
    fn bound_ns(self) -> i64 {
        self.high_ns - self.middle_ns()
    }
}

/// Parts per million of a time, rounded up.
fn share(ns: i64, ppm: i64) -> i64 {
    ns / PPM * ppm + (ns % PPM * ppm + PPM - 1) / PPM
}

/// Slope of the line through the offsets of these exchanges by weighted least squares (parts per 10⁹). The error of an
/// offset is in proportion to the round trip.
fn drift_ppb(exchanges: &VecDeque<Exchange>) -> Option<i64> {
    let first = exchanges
        .front()
        .filter(|_| exchanges.len() >= FIRST_DRIFT_SECONDS)?;
    // Differences are small enough to be exact.
    let points = exchanges.iter().map(|own| {
        let weight = (own.round_trip_ns.max(1) as f64).powi(-2);
        let t = (own.at_ns - first.at_ns) as f64;
        (weight, t, (own.offset_ns - first.offset_ns) as f64)
    });
    let (mut weights, mut t_mean, mut offset_mean) = (0.0, 0.0, 0.0);
    for (weight, t, offset) in points.clone() {
        weights += weight;
        t_mean += (t - t_mean) * weight / weights;
        offset_mean += (offset - offset_mean) * weight / weights;
    }
    let (mut covariance, mut variance) = (0.0, 0.0);
    for (weight, t, offset) in points {
        covariance += weight * (t - t_mean) * (offset - offset_mean);
        variance += weight * (t - t_mean).powi(2);
    }
    (variance > 0.0).then(|| (covariance / variance * NS_PER_S as f64).round() as i64)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A host whose clock is `offset_ns` ahead at time 0 of the plant's host and drifts by `drift_ppm`.
    #[derive(Clone, Copy)]
    struct Truth {
        offset_ns: i64,
        drift_ppm: i64,
    }

    impl Truth {
        fn host_ns(self, plant_ns: i64) -> i64 {
            plant_ns + self.offset_at(plant_ns)
        }

        fn offset_at(self, plant_ns: i64) -> i64 {
            self.offset_ns + plant_ns / 1_000_000 * self.drift_ppm
        }
    }

    /// Delays of a network that is often fast and sometimes, on one way alone, very slow.
    struct Delays(u64);

    impl Delays {
        fn next(&mut self) -> i64 {
            let mut uniform = || {
                self.0 = self
                    .0
                    .wrapping_mul(6_364_136_223_846_793_005)
                    .wrapping_add(1_442_695_040_888_963_407);
                (self.0 >> 33) as i64
            };
            let slow = if uniform() % 10 == 0 {
                100_000_000
            } else {
                100_000
            };
            50_000 + uniform() % slow
        }
    }

    /// Exchanges every 20 ms for some seconds. Calls `each` with the reports, the true offsets at their instants, and
    /// the largest error of the offset in use since the last report.
    fn play(truth: Truth, seconds: i64, mut each: impl FnMut(ClockReport, i64, i64)) -> HostClock {
        let (mut clock, mut delays, mut worst_ns) = (HostClock::default(), Delays(7), 0);
        for k in 0..seconds * 50 {
            let asked = k * 20_000_000;
            let received = asked + delays.next();
            let sent = received + 20_000;
            let answered = sent + delays.next();
            let stamps = Stamps {
                asked_ns: truth.host_ns(asked),
                received_ns: received,
                sent_ns: sent,
            };
            let true_ns = truth.offset_at(answered);
            let mut note = |in_use: Option<(i64, i64)>| {
                let error_ns = in_use.map_or(0, |(offset_ns, _)| (offset_ns - true_ns).abs());
                worst_ns = worst_ns.max(error_ns);
            };
            note(clock.in_use);
            clock.take(&stamps, truth.host_ns(answered));
            clock.advance(truth.host_ns(answered));
            note(clock.in_use);
            if let Some(report) = clock.report(truth.host_ns(answered)) {
                each(report, true_ns, std::mem::take(&mut worst_ns));
            }
        }
        clock
    }

    #[test]
    fn the_true_offset_is_within_the_bound_in_every_second() {
        for drift_ppm in [-499, -40, 0, 40, 100, 499] {
            let truth = Truth {
                offset_ns: 1_000 * NS_PER_S,
                drift_ppm,
            };
            let mut windows = 0;
            let mut drift = None;
            play(truth, 125, |report, offset_ns, worst_ns| {
                let error_ns = (report.offset_ns - offset_ns).abs();
                assert!(error_ns <= report.bound_ns, "{report:?} {offset_ns}");
                // Half of a fast round trip is at most 150 µs. Of six in a row one is fast, and clocks drift by 60 µs.
                assert!(report.bound_ns < 250_000, "{report:?}");
                assert!(worst_ns <= report.error_ns, "{report:?} {worst_ns}");
                windows += 1;
                drift = report.drift_ppb;
            });
            assert!(windows > 100, "{windows}");
            let drift = drift.unwrap();
            assert!(
                (drift - drift_ppm * 1000).abs() < 2000,
                "{drift} {drift_ppm}"
            );
        }
    }

    #[test]
    fn the_clock_in_use_follows_without_a_step() {
        let truth = Truth {
            offset_ns: -5 * NS_PER_S,
            drift_ppm: 40,
        };
        let mut largest = 0;
        let mut clock = play(truth, 60, |report, _, _| {
            largest = report.error_ns.max(largest)
        });
        assert!(largest < 400_000, "{largest}");
        // A correction of 1 ms takes 2 s.
        let Some((offset_ns, since_ns)) = clock.in_use else {
            panic!("no offset in use");
        };
        let interval = clock.interval.unwrap();
        let ahead = |by_ns| {
            Some(Interval {
                low_ns: interval.low_ns + by_ns,
                high_ns: interval.high_ns + by_ns,
                ..interval
            })
        };
        clock.interval = ahead(1_000_000);
        let after = clock.advance(since_ns + NS_PER_S);
        assert_eq!(after - offset_ns, 500_000);
        // A host that stood still is behind, and jumps.
        clock.interval = ahead(-NS_PER_S);
        let middle_ns = clock.interval.unwrap().middle_ns();
        assert_eq!(clock.advance(since_ns + NS_PER_S), middle_ns);
    }

    #[test]
    fn a_clock_that_was_set_is_known_again_after_one_exchange() {
        let mut clock = HostClock::default();
        let stamps = |offset_ns: i64, at_ns: i64| Stamps {
            asked_ns: at_ns + offset_ns,
            received_ns: at_ns + 100,
            sent_ns: at_ns + 100,
        };
        for k in 0..8 {
            assert!(!clock.is_known());
            clock.take(&stamps(7, k * 1000), k * 1000 + 200 + 7);
        }
        assert!(clock.is_known());
        assert_eq!(clock.interval.unwrap().middle_ns(), 7);
        clock.take(&stamps(5000, 9000), 9000 + 200 + 5000);
        assert_eq!(clock.interval.unwrap().middle_ns(), 5000);
    }

    #[test]
    fn an_answer_that_contradicts_itself_is_dropped() {
        let mut clock = HostClock::default();
        let stamps = Stamps {
            asked_ns: 0,
            received_ns: 50,
            sent_ns: 40,
        };
        clock.take(&stamps, 100);
        let early = Stamps {
            asked_ns: 0,
            received_ns: 0,
            sent_ns: 200,
        };
        clock.take(&early, 100);
        let absurd = Stamps {
            asked_ns: i64::MIN,
            received_ns: i64::MAX,
            sent_ns: i64::MAX,
        };
        clock.take(&absurd, i64::MAX);
        assert_eq!((clock.exchanges, clock.interval), (0, None));
    }
}
