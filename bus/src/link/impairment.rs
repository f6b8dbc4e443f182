//! Link impairment as in netem: delay with jitter, Gilbert–Elliott loss, replayed round-trip times.
//!
//! What happens to message k depends only on the seed of the run, the link and k, and so not on
//! when the receiver polls.

use chacha20::ChaCha8Rng;
use rand::{RngExt, SeedableRng};
use rand_distr::{Distribution as _, LogNormal, Normal, Uniform};

use crate::experiment::{Distribution, LinkSettings};
use crate::message::RobotIndex;
use crate::time::ns_from_s;

/// The random delays and losses of a link, drawn message by message in the order of sending.
#[derive(Debug)]
pub struct LinkImpairment {
    rng: ChaCha8Rng,
    jitter: Jitter,
    delay_ns: i64,
    loss: LossModel,
    in_burst: bool,
    half_round_trips_ns: Vec<Option<i64>>,
    /// Number of messages drawn so far.
    drawn: usize,
}

#[derive(Debug, Clone)]
enum Jitter {
    None,
    Normal(Normal<f64>),
    Uniform(Uniform<f64>),
    Lognormal(LogNormal<f64>),
}

/// Loss model. Bursts follow the Gilbert–Elliott model without losses in the good state and with
/// certain loss in the bad state.
#[derive(Debug, Clone, Copy)]
enum LossModel {
    Independent {
        probability: f64,
    },
    /// Transition probabilities per message: good to bad, bad to good.
    Bursts {
        begin: f64,
        end: f64,
    },
}

impl LinkImpairment {
    /// The impairment of the link `from` → `to` in a run with this seed.
    ///
    /// Requires valid settings ([`crate::experiment::Settings::validate`]); a distribution with
    /// invalid parameters counts as no jitter.
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
            loss: LossModel::new(links),
            in_burst: false,
            half_round_trips_ns: half_round_trips_ns.to_vec(),
            drawn: 0,
        }
    }

    /// Draws the delay of the next message (ns); `None` if it is lost. Advances the random
    /// generator equally in both cases.
    pub fn draw(&mut self) -> Option<i64> {
        let lost = self.draw_loss();
        let delay_ns = self.jitter.draw(&mut self.rng).unwrap_or(self.delay_ns);
        let replayed_ns = match self.half_round_trips_ns.len() {
            0 => Some(0),
            rows => self.half_round_trips_ns[self.drawn % rows],
        };
        self.drawn += 1;
        if lost {
            None
        } else {
            Some(delay_ns + replayed_ns?)
        }
    }

    fn draw_loss(&mut self) -> bool {
        let uniform: f64 = self.rng.random();
        match self.loss {
            LossModel::Independent { probability } => uniform < probability,
            LossModel::Bursts { begin, end } => {
                self.in_burst = if self.in_burst {
                    uniform >= end
                } else {
                    uniform < begin
                };
                self.in_burst
            }
        }
    }
}

impl Jitter {
    fn new(links: &LinkSettings) -> Self {
        let (mean_s, sd_s) = (links.delay_s, links.jitter_s);
        if sd_s == 0.0 {
            return Self::None;
        }
        match links.distribution {
            Distribution::Normal => Normal::new(mean_s, sd_s).map_or(Self::None, Self::Normal),
            Distribution::Uniform => {
                let half_s = 3f64.sqrt() * sd_s;
                Uniform::new(mean_s - half_s, mean_s + half_s).map_or(Self::None, Self::Uniform)
            }
            Distribution::Lognormal => {
                LogNormal::from_mean_cv(mean_s, sd_s / mean_s).map_or(Self::None, Self::Lognormal)
            }
        }
    }

    /// Draws a delay, clipped at 0 (ns); `None` without jitter.
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

impl LossModel {
    fn new(links: &LinkSettings) -> Self {
        if links.burst == 0.0 || links.loss == 0.0 {
            return Self::Independent {
                probability: links.loss,
            };
        }
        let end = 1.0 / links.burst;
        Self::Bursts {
            begin: end * links.loss / (1.0 - links.loss),
            end,
        }
    }
}
