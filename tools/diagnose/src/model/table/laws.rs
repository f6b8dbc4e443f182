//! Laws of speed and of turn rate: what the catalogue does not have.

use super::draft::Place::Reference;
use super::draft::{Draft, Row, Shown, about};
use super::known::Known;
use super::sizes::{LAW_COST, LEAST_DRIVER, LENGTH_SHARE};
use crate::filter::motion_law::{TABLES, Table};
use crate::model::from_wheels::LAW_FIRST;

impl Known<'_> {
    /// Laws of speed over turn rate and over speed, and of turn rate over turn rate.
    pub(super) fn laws(&self, all: &mut Vec<Draft>) {
        let reference = self.streams.reference;
        let reach = reference.knots.map(|knots| knots.reach());
        // a gyro sees turns alone
        let shows = |own: &&Table| self.has_pose || self.has_gyro && own.acts_on == "turn_rate";
        let moves = |own: &&Table| reach[own.over] > LEAST_DRIVER[own.over];
        for table in TABLES.iter().filter(shows).filter(moves) {
            let of_turns = usize::from(table.acts_on == "turn_rate");
            let most = [(reach[0] * self.half_track_m).max(reach[1]), reach[0]];
            let rows = (0..table.count).map(|number| Row {
                name: table.name,
                number,
                moves: vec![(Reference(LAW_FIRST + table.first + number), 1.0)],
                prior: about(reference.law_priors()[of_turns]),
                resolution: LENGTH_SHARE * most[of_turns],
                repeatability: 0.0,
            });
            let shown = vec![Shown::new("unknown", Vec::new())];
            // at exactly 0 the filter leaves a law out, and has no derivative by it
            let start = vec![f64::MIN_POSITIVE; table.count];
            let mut law = Draft::new(table.name, rows.collect(), shown).from([start]);
            law.cost = LAW_COST;
            law.lasting = true;
            law.later = true;
            all.push(law);
        }
    }
}
