//! The search for what is left out: the effect that pays most, fitted together with those found
//! before, until none pays.

use slipstream_bus::RobotModel;
use slipstream_sim::{Listed, read_effects};

use crate::fit::{Fit, Free, GLOBALS, Problem};
use crate::hypothesis::Hypothesis;
use crate::track::Track;
use crate::window::{LOCALS, Window};

/// Level below which a residual counts as noise whatever it is: the differences of two integrators.
pub(crate) const FLOOR: f64 = 0.8;

/// Rounds of the fit in which a hypothesis shows whether it is worth fitting to the end.
const GLANCE: usize = 4;
/// Rounds of a full fit.
const FULL: usize = 40;
/// Hypotheses that are fitted to the end.
const BEST: usize = 7;

/// Δ(−2 ln L) that one more effect has to bring, and for each parameter more.
const PAY: [f64; 2] = [24.0, 6.0];
/// Share of what was gained so far that one more effect has to bring.
const PAY_SHARE: f64 = 0.02;
/// Estimate over deviation that each effect has to keep in one of its parameters.
const SIGMAS: f64 = 4.2;

/// A model that explains a track, with what was found beyond the nominal one.
#[derive(Debug, Clone)]
pub(crate) struct Found {
    pub(crate) hypotheses: Vec<Hypothesis>,
    pub(crate) fit: Fit,
    /// Gain of each effect: Δ ln L of all against all without it.
    pub(crate) gains: Vec<f64>,
    /// Effects that fit as well in place of each one.
    pub(crate) twins: Vec<Vec<&'static str>>,
}

/// Effects as the plant takes them, and which of their numbers are fitted from which values.
struct Setting {
    list: Vec<Listed<f64>>,
    free: Vec<Free>,
    values: Vec<f64>,
}

/// One track with its nominal model.
pub(crate) struct Search<'a> {
    pub(crate) track: &'a Track,
    pub(crate) windows: &'a [Window],
    pub(crate) model: &'a RobotModel,
}

impl Search<'_> {
    /// Fits the nominal model and these effects.
    pub(crate) fn fit(
        &self,
        hypotheses: &[Hypothesis],
        starts: &[[f64; LOCALS]],
        rounds: usize,
    ) -> Option<Fit> {
        let Setting { list, free, values } = self.listed(hypotheses)?;
        let problem = Problem {
            track: self.track,
            windows: self.windows,
            model: self.model,
            list: &list,
            free: &free,
        };
        problem.fit(&values, starts, rounds)
    }

    fn listed(&self, hypotheses: &[Hypothesis]) -> Option<Setting> {
        let mut model = self.model.clone();
        let known = model.effects.len();
        model
            .effects
            .extend(hypotheses.iter().map(Hypothesis::spec));
        let list = read_effects(&model).ok()?;
        let mut free = Vec::new();
        let mut values = Vec::new();
        for (i, hypothesis) in hypotheses.iter().enumerate() {
            for &(name, value) in &hypothesis.values {
                free.push((known + i, name));
                values.push(value);
            }
        }
        (free.len() <= GLOBALS).then_some(Setting { list, free, values })
    }

    /// Searches from the nominal model on. `progress` is told what is being done.
    pub(crate) fn run(&self, all: &[Hypothesis], progress: &mut dyn FnMut(&str)) -> Option<Found> {
        let [radius, half_track] = [
            self.model.robot.wheel_radius_m,
            self.model.robot.half_track_m,
        ];
        let starts: Vec<_> = self
            .windows
            .iter()
            .map(|w| w.guess(self.track, radius, half_track))
            .collect();
        progress("nominal model");
        let nominal = self.fit(&[], &starts, FULL)?;
        let begin = nominal.misfit.deviance(FLOOR);
        let mut found = Found {
            hypotheses: Vec::new(),
            fit: nominal,
            gains: Vec::new(),
            twins: Vec::new(),
        };
        while let Some(next) = self.next(all, &found, begin, progress) {
            found = self.prune(next, progress);
        }
        Some(self.weigh(found, all, progress))
    }

    fn taken(found: &Found, hypothesis: &Hypothesis) -> bool {
        let same = |known: &Hypothesis| {
            known.info.id == hypothesis.info.id && known.text == hypothesis.text
        };
        found.hypotheses.iter().any(same)
    }

    /// The best extension by one effect, if it pays.
    fn next(
        &self,
        all: &[Hypothesis],
        found: &Found,
        begin: f64,
        progress: &mut dyn FnMut(&str),
    ) -> Option<Found> {
        let so_far = found.fit.misfit.deviance(FLOOR);
        let candidates: Vec<&Hypothesis> = all.iter().filter(|h| !Self::taken(found, h)).collect();
        let mut glances = self.try_each(&candidates, found, GLANCE, progress);
        glances.sort_by(|a, b| {
            a.1.misfit
                .deviance(FLOOR)
                .total_cmp(&b.1.misfit.deviance(FLOOR))
        });
        let mut best: Vec<&Hypothesis> = Vec::new();
        for (hypotheses, _) in &glances {
            let own = hypotheses.last()?;
            if !best
                .iter()
                .any(|known| known.info.id == own.info.id && known.text == own.text)
            {
                best.push(own);
            }
        }
        best.truncate(BEST);
        let mut full = self.try_each(&best, found, FULL, progress);
        full.sort_by(|a, b| {
            a.1.misfit
                .deviance(FLOOR)
                .total_cmp(&b.1.misfit.deviance(FLOOR))
        });
        full.into_iter().find_map(|(hypotheses, fit)| {
            let own = hypotheses.last()?;
            let gain = so_far - fit.misfit.deviance(FLOOR);
            let parameters = own.values.len();
            let due = PAY[0] + PAY[1] * (parameters as f64 - 1.0);
            let pays = gain > due.max(PAY_SHARE * (begin - so_far));
            let clear = self.is_clear(&hypotheses, &fit, hypotheses.len() - 1);
            (pays && clear).then(|| Found {
                hypotheses,
                fit,
                gains: Vec::new(),
                twins: Vec::new(),
            })
        })
    }

    /// Whether an effect differs from nothing by its own uncertainty.
    fn is_clear(&self, hypotheses: &[Hypothesis], fit: &Fit, which: usize) -> bool {
        let first: usize = hypotheses[..which].iter().map(|h| h.values.len()).sum();
        let own = &hypotheses[which];
        own.values.iter().enumerate().any(|(i, (name, _))| {
            let nothing = if name.ends_with("scale") || *name == "right" || *name == "left" {
                1.0
            } else {
                0.0
            };
            (fit.values[first + i] - nothing).abs() > SIGMAS * fit.deviations[first + i]
        })
    }

    /// Fits `found` and each candidate, on all cores.
    fn try_each(
        &self,
        candidates: &[&Hypothesis],
        found: &Found,
        rounds: usize,
        progress: &mut dyn FnMut(&str),
    ) -> Vec<(Vec<Hypothesis>, Fit)> {
        let cores = std::thread::available_parallelism().map_or(1, |n| n.get());
        let mut tried = Vec::new();
        for group in candidates.chunks(cores) {
            let names: Vec<&str> = group.iter().map(|h| h.info.id).collect();
            progress(&names.join(", "));
            let results: Vec<_> = std::thread::scope(|scope| {
                let threads: Vec<_> = group
                    .iter()
                    .map(|candidate| {
                        scope.spawn(|| {
                            let mut hypotheses = self.settled(found);
                            hypotheses.push((*candidate).clone());
                            let fit = self.fit(&hypotheses, &found.fit.starts, rounds)?;
                            Some((hypotheses, fit))
                        })
                    })
                    .collect();
                threads
                    .into_iter()
                    .map(|thread| thread.join().ok().flatten())
                    .collect()
            });
            tried.extend(results.into_iter().flatten());
        }
        tried
    }

    /// The effects found so far at the values that their fit gave.
    fn settled(&self, found: &Found) -> Vec<Hypothesis> {
        let mut values = found.fit.values.iter();
        let mut hypotheses = found.hypotheses.clone();
        for hypothesis in &mut hypotheses {
            for (_, value) in &mut hypothesis.values {
                if let Some(fitted) = values.next() {
                    *value = *fitted;
                }
            }
        }
        hypotheses
    }

    /// Takes out what no longer pays beside what came later.
    fn prune(&self, mut found: Found, progress: &mut dyn FnMut(&str)) -> Found {
        let mut at = 0;
        while found.hypotheses.len() > 1 && at < found.hypotheses.len() {
            let mut without = self.settled(&found);
            let removed = without.remove(at);
            progress(&format!("without {}", removed.info.id));
            let due = PAY[0] + PAY[1] * (removed.values.len() as f64 - 1.0);
            match self.fit(&without, &found.fit.starts, FULL) {
                Some(fit)
                    if fit.misfit.deviance(FLOOR) - found.fit.misfit.deviance(FLOOR) < due =>
                {
                    found = Found {
                        hypotheses: without,
                        fit,
                        gains: Vec::new(),
                        twins: Vec::new(),
                    };
                    at = 0;
                }
                _ => at += 1,
            }
        }
        found
    }

    /// What each effect brings, and which other one would fit as well in its place.
    fn weigh(&self, mut found: Found, all: &[Hypothesis], progress: &mut dyn FnMut(&str)) -> Found {
        let whole = found.fit.misfit.deviance(FLOOR);
        let mut kinds: Vec<&Hypothesis> = Vec::new();
        for hypothesis in all.iter().filter(|h| !Self::taken(&found, h)) {
            kinds.push(hypothesis);
        }
        for at in 0..found.hypotheses.len() {
            let mut without = found.clone();
            without.hypotheses = self.settled(&found);
            without.hypotheses.remove(at);
            let gone = self.fit(&without.hypotheses, &found.fit.starts, FULL);
            let Some(gone) = gone else { continue };
            found
                .gains
                .push((gone.misfit.deviance(FLOOR) - whole) / 2.0);
            without.fit = gone;
            let mut twins: Vec<&'static str> = Vec::new();
            let glances = self.try_each(&kinds, &without, GLANCE, progress);
            let gained = without.fit.misfit.deviance(FLOOR) - whole;
            for (hypotheses, fit) in glances {
                let Some(own) = hypotheses.last() else {
                    continue;
                };
                let near = fit.misfit.deviance(FLOOR) - whole < (0.05 * gained).max(60.0);
                if !near || twins.contains(&own.info.id) {
                    continue;
                }
                let full = self.fit(&hypotheses, &fit.starts, FULL);
                if full.is_some_and(|f| f.misfit.deviance(FLOOR) - whole < 9.0) {
                    twins.push(own.info.id);
                }
            }
            found.twins.push(twins);
        }
        found
    }
}
