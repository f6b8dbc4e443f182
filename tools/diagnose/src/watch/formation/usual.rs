//! Which spacing is usual between two robots.

use super::pair::Bin;

/// Bins of a baseline, at least.
const LEAST: usize = 8;
/// Speeds that differ by this deviation (m/s) say how the spacing depends on them.
const SPEEDS_M_S: f64 = 0.05;
/// A spacing leaves its range beyond so many times the largest difference in the baseline, and no less than this (m).
const TIMES: f64 = 1.5;
const LEAST_M: f64 = 0.02;
/// A range that is wider than this share of the spacing is none.
const WIDEST_RANGE_SHARE: f64 = 0.3;
/// Speeds beyond those of the baseline that are judged as well, as a share.
const BEYOND: f64 = 0.15;

/// The spacing of a pair.
#[derive(Debug, Clone)]
pub(super) struct Usual {
    /// At the mean speed (m).
    pub(super) spacing_m: f64,
    speed_m_s: f64,
    /// How it grows with the speed (s).
    slope_s: f64,
    /// Speeds at which it is known (m/s).
    speeds_m_s: [f64; 2],
    /// Deviation of what is not of the speed (m).
    pub(super) deviation_m: f64,
    /// The widest difference that is no change (m).
    pub(super) range_m: f64,
}

impl Usual {
    /// As these bins say; `None` where there are too few, or they say nothing.
    pub(super) fn of(bins: &[Bin]) -> Option<Self> {
        let count = bins.len() as f64;
        let mean = |of: &dyn Fn(&Bin) -> f64| bins.iter().map(of).sum::<f64>() / count;
        let (spacing_m, speed_m_s) = (mean(&|own| own.spacing_m), mean(&|own| own.speed_m_s));
        let variance = mean(&|own| (own.speed_m_s - speed_m_s).powi(2));
        let both = mean(&|own| (own.speed_m_s - speed_m_s) * (own.spacing_m - spacing_m));
        let speeds = bins.iter().map(|own| own.speed_m_s);
        let least = speeds.clone().fold(f64::INFINITY, f64::min);
        let mut own = Self {
            spacing_m,
            speed_m_s,
            slope_s: if variance.sqrt() > SPEEDS_M_S {
                both / variance
            } else {
                0.0
            },
            speeds_m_s: [least, speeds.fold(0.0, f64::max)],
            deviation_m: 0.0,
            range_m: 0.0,
        };
        let differences: Vec<f64> = bins.iter().map(|bin| own.beside_m(bin)).collect();
        let most = differences
            .iter()
            .fold(0.0_f64, |most, own| most.max(own.abs()));
        let square = differences.iter().map(|own| own * own).sum::<f64>();
        own.deviation_m = (square / count).sqrt();
        own.range_m = (TIMES * most).max(LEAST_M);
        let is_known = bins.len() >= LEAST && own.range_m < WIDEST_RANGE_SHARE * spacing_m;
        is_known.then_some(own)
    }

    /// How much larger than usual a spacing is (m).
    fn beside_m(&self, bin: &Bin) -> f64 {
        bin.spacing_m - self.spacing_m - self.slope_s * (bin.speed_m_s - self.speed_m_s)
    }

    /// The same, where the speed is one at which the spacing is known.
    pub(super) fn judged_m(&self, bin: &Bin) -> Option<f64> {
        let [least, most] = self.speeds_m_s;
        let is_known = (least * (1.0 - BEYOND)..=most * (1.0 + BEYOND)).contains(&bin.speed_m_s);
        is_known.then(|| self.beside_m(bin))
    }
}
