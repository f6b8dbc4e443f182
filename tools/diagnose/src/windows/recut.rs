//! Where no window should begin in a model that is on the way.

use slipstream_sim::effects::{Info, When, find};

use crate::windows::bench::Node;
use crate::windows::hypothesis::{Hypothesis, slides};
use crate::windows::located;
use crate::windows::search::Search;
use crate::windows::window::{AFTER_S, PULSE_S, Window};

/// How long the end of a slide is looked for beyond the window that it began in (s).
const BEYOND_S: f64 = 0.6;
/// How much longer than in a model that is not yet right a patch may act, and how far around a push
/// a slide may reach that it stands for (s).
const EDGE_S: f64 = 0.5;

impl Search<'_> {
    /// When the wheels slide in a model that slips and does not yet reach the noise, or its gears are
    /// apart, if a window begins there, unless that is known already. A push that explains all where a
    /// window begins may be such a slide.
    pub(crate) fn slides(&self, node: &Node) -> Option<Vec<[f64; 2]>> {
        if !self.cuts {
            return None;
        }
        let noise = self.bench.is_noise(node);
        let mut times_s = Vec::new();
        if !noise && self.has(node, |info| info.acts == When::Apart) {
            times_s.extend(located::apart(self.bench));
        }
        let pushes = if noise && self.slips(node) {
            self.begun_by_push(node)
        } else {
            Vec::new()
        };
        if self.slips(node) && (!noise || !pushes.is_empty()) {
            times_s.extend(pushes);
            times_s.extend(self.sliding_times(node));
        }
        self.begins_in(&times_s).then_some(times_s)
    }

    /// When wheels slide in a model, with some time around patches: where one ends is not known well
    /// while a window begins on it.
    fn sliding_times(&self, node: &Node) -> Vec<[f64; 2]> {
        let edge_s = if node.hypotheses.iter().any(Hypothesis::is_placed) {
            EDGE_S
        } else {
            0.0
        };
        let slides = located::sliding(self.bench, node, None, BEYOND_S);
        let wider = slides.iter().map(|[from, to]| [from - edge_s, to + edge_s]);
        wider.collect()
    }

    /// Whether a window begins at one of these times (s).
    fn begins_in(&self, times_s: &[[f64; 2]]) -> bool {
        let begins = |window: &Window| {
            let mut times_s = times_s.iter();
            times_s.any(|[from, to]| window.from_s > *from && window.from_s < to + AFTER_S)
        };
        self.bench.windows.iter().any(begins)
    }

    /// Around the pushes with which a window begins, other than the first.
    fn begun_by_push(&self, node: &Node) -> Vec<[f64; 2]> {
        let pushes = node.hypotheses.iter().filter(|h| h.is_momentary());
        let begins = |t_s: &f64| {
            let mut later = self.bench.windows.windows(2).map(|pair| pair[1].from_s);
            later.any(|from_s| (from_s - t_s).abs() < PULSE_S)
        };
        let times_s = pushes.map(|push| push.values[0].1).filter(begins);
        times_s.map(|t_s| [t_s - EDGE_S, t_s + EDGE_S]).collect()
    }

    /// Whether wheels may slide in a model.
    pub(crate) fn slips(&self, node: &Node) -> bool {
        self.has(node, slides)
    }

    /// Whether some effect of a node, or of the model that it begins from, is such.
    fn has(&self, node: &Node, such: fn(&Info) -> bool) -> bool {
        let mut known = self.bench.model.effects.iter();
        node.hypotheses.iter().any(|h| such(h.info))
            || known.any(|e| find(&e.effect).is_some_and(such))
    }
}
