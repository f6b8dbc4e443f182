//! Speed lost in turns, a track that is larger to one side, and laws of speed and of turn rate: what the catalogue does
//! not have.

use super::draft::Place::Reference;
use super::draft::{Draft, Row, Shown, about};
use super::known::Known;
use super::sizes::{LAW_COST, LEAST_DRIVER, LENGTH_SHARE, TURN_COST};
use crate::filter::motion_law::{OF_SIZE, TABLES, Table};
use crate::model::wheel_parameters::LAW_FIRST;

impl Known<'_> {
    /// What is in proportion to the size of the turn rate: a speed that is lost, and a turn rate, for the track is
    /// larger to one side.
    pub(super) fn in_turns(&self, all: &mut Vec<Draft>) {
        if !self.streams.reference.knots[0].has_both_sides() {
            return;
        }
        for (table, name, sign) in [(0, "loss in turns", -1.0), (2, "track by side", 1.0)] {
            let table = &TABLES[table];
            if self.shows(table) {
                let moves = OF_SIZE.map(|(own, weight)| (own, sign * weight));
                let mut term = self.outside(table, name, vec![moves.to_vec()]);
                term.cost = TURN_COST;
                // nothing makes a robot faster in turns
                term.positive = sign < 0.0;
                all.push(term);
            }
        }
    }

    /// Laws of speed over turn rate and over speed, and of turn rate over turn rate.
    pub(super) fn laws(&self, all: &mut Vec<Draft>) {
        for table in TABLES.iter().filter(|own| self.shows(own)) {
            let moves = (0..table.count).map(|own| vec![(own, 1.0)]);
            let mut law = self.outside(table, table.name, moves.collect());
            law.cost = LAW_COST;
            all.push(law);
        }
    }

    /// Whether a table would show: a gyro sees turns alone.
    fn shows(&self, table: &Table) -> bool {
        let [w, v] = self.streams.reference.knots.map(|knots| knots.reach());
        let reach = [w, v][table.over];
        let seen = self.has_pose || self.has_gyro && table.acts_on == "turn_rate";
        let turns = table.over == 1 || self.streams.reference.turns();
        seen && turns && reach > LEAST_DRIVER[table.over]
    }

    /// A term of a table, each parameter of which moves some of the table's.
    fn outside(&self, table: &Table, name: &'static str, moves: Vec<Vec<(usize, f64)>>) -> Draft {
        let reference = self.streams.reference;
        let [w, v] = reference.knots.map(|knots| knots.reach());
        let of_turns = usize::from(table.acts_on == "turn_rate");
        let most = [v.max(w * self.half_track_m), w][of_turns];
        // at exactly 0 the filter leaves a law out, and has no derivative by it
        let start = vec![f64::MIN_POSITIVE; moves.len()];
        let place =
            |(own, weight): (usize, f64)| (Reference(LAW_FIRST + table.first + own), weight);
        let rows = moves.into_iter().enumerate().map(|(number, moves)| Row {
            name,
            number,
            moves: moves.into_iter().map(place).collect(),
            prior: about(reference.law_priors()[of_turns]),
            resolution: LENGTH_SHARE * most,
            repeatability: 0.0,
        });
        let shown = vec![Shown::new("unknown", Vec::new())];
        let mut term = Draft::new(name, rows.collect(), shown).from([start]);
        term.needs_relevance = true;
        term.later = true;
        term
    }
}
