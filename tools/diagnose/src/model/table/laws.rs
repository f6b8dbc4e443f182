//! Laws of speed over turn rate and over speed: what the catalogue does not have.

use super::draft::Place::Reference;
use super::draft::{Draft, Row, Shown, about};
use super::known::Known;
use super::sizes::{LAW_COST, LEAST_DRIVER, LENGTH_SHARE};
use crate::filter::motion_law::VALUES;
use crate::model::from_wheels::LAW_FIRST;

impl Known<'_> {
    /// Laws of speed over turn rate and over speed: what the catalogue does not have.
    pub(super) fn laws(&self, all: &mut Vec<Draft>) {
        if !self.has_pose {
            return;
        }
        let reference = self.streams.reference;
        let reach = reference.knots.map(|knots| knots.reach());
        let floor = LENGTH_SHARE * (reach[0] * self.half_track_m).max(reach[1]);
        for (place, name) in ["law of w", "law of v"].into_iter().enumerate() {
            if reach[place] <= LEAST_DRIVER[place] {
                continue;
            }
            let first = LAW_FIRST + place * VALUES[0];
            let rows = (0..VALUES[place]).map(|number| Row {
                name,
                number,
                moves: vec![(Reference(first + number), 1.0)],
                prior: about(reference.law_prior_m_s()),
                resolution: floor,
                repeatability: 0.0,
            });
            let shown = vec![Shown::new("unknown", Vec::new())];
            // at exactly 0 the filter leaves a law out, and has no derivative by it
            let start = vec![f64::MIN_POSITIVE; VALUES[place]];
            let mut law = Draft::new(name, rows.collect(), shown).from([start]);
            law.cost = LAW_COST;
            law.lasting = true;
            law.later = true;
            all.push(law);
        }
    }
}
