//! What is known of the streams when their table is made.

use super::draft::Place::{Drive, Reference};
use super::draft::{Draft, Place, Row};
use super::sizes::{FACTOR, GYRO_ASYMMETRY, repeatability};
use crate::estimate::Prior;
use crate::model::command_to_wheels::CommandToWheels;
use crate::model::run::Run;
use crate::model::streams::Streams;
use crate::model::volts::{Load, Volts};
use crate::model::wheel_parameters::DRIVE_FIRST;

/// What is asked of a table.
pub(crate) struct Asked<'a> {
    pub(crate) streams: Streams<'a>,
    /// What the filters read under the nominal model.
    pub(crate) nominal: &'a [f64],
    /// Effects that are not looked for.
    pub(crate) excluded: &'a [String],
    /// Whether scale, track and latency of the poses are those of each run.
    pub(crate) by_run: [bool; 3],
}

impl Asked<'_> {
    /// Where a place stands among what the filters read: of today's runs, or of what they share with those from before.
    pub(super) fn index(&self, place: Place, is_shared: bool) -> usize {
        let reference = self.streams.reference;
        match (place, self.streams.drive) {
            (Drive(own), Some(_)) if is_shared => {
                self.streams.drive_first() + CommandToWheels::shared(own)
            }
            (Drive(own), Some(_)) => self.streams.drive_first() + own,
            (Drive(own), None) if is_shared => reference.shared(DRIVE_FIRST + own),
            (Drive(own), None) => DRIVE_FIRST + own,
            (Reference(own), _) if is_shared => reference.shared(own),
            (Reference(own), _) => own,
        }
    }

    /// Whether the filter of a place has runs from before.
    pub(super) fn compares(&self, place: Place) -> bool {
        match (place, self.streams.drive) {
            (Drive(_), Some(drive)) => drive.before.any(),
            _ => self.streams.reference.before.any(),
        }
    }
}

/// What is known of the streams when their table is made.
pub(super) struct Known<'a> {
    pub(super) streams: Streams<'a>,
    pub(super) asked: &'a Asked<'a>,
    pub(super) has_pose: bool,
    pub(super) has_heading: bool,
    pub(super) has_gyro: bool,
    pub(super) is_commanded: bool,
    /// Largest command (rad/s); 0 without commands.
    pub(super) top_rad_s: f64,
    pub(super) half_track_m: f64,
    /// The motors, where they are told voltages.
    pub(super) volts: Option<Volts>,
}

impl<'a> Known<'a> {
    pub(super) fn new(asked: &'a Asked<'a>) -> Self {
        let streams = asked.streams;
        let reference = streams.reference;
        let is_commanded = reference.is_commanded();
        Self {
            streams,
            asked,
            has_pose: reference.has_pose(),
            has_heading: reference.has_heading(),
            has_gyro: reference.has_gyro(),
            is_commanded,
            top_rad_s: match streams.drive {
                Some(drive) => drive.largest_rad_s,
                None if is_commanded => reference.largest_rad_s(),
                None => 0.0,
            },
            half_track_m: reference.half_track_m,
            volts: reference.volts,
        }
    }

    pub(super) fn is_driven(&self) -> bool {
        self.streams.drive.is_some() || self.is_commanded
    }

    /// What the motors move, where they are told voltages and masses are known.
    pub(super) fn load(&self) -> Option<Load> {
        self.volts.and_then(|own| own.load)
    }

    pub(super) fn has_reference(&self) -> bool {
        self.has_pose || self.has_gyro
    }

    /// Largest of an interval over all runs (s).
    pub(super) fn longest_s(&self, interval_s: fn(&Run) -> f64) -> f64 {
        let runs = self.streams.reference.runs.iter();
        runs.map(interval_s).fold(0.0, f64::max)
    }

    pub(super) fn duration_s(&self) -> f64 {
        let runs = self.streams.reference.runs.iter();
        let spans = runs.map(|run| run.blocks.span_s[1] - run.blocks.span_s[0]);
        spans.fold(1.0, f64::max)
    }

    /// Whether runs from before are fitted with a parameter whatever changed: what the streams show, and
    /// what the machine had before.
    pub(super) fn had(&self, asked: &Asked<'_>, row: &Row, later: bool) -> bool {
        let known = row.moves.iter().any(|(place, _)| {
            let own = asked.nominal.get(asked.index(*place, true));
            own.is_some_and(|own| *own != 0.0)
        });
        !later || known
    }

    pub(super) fn terms(&self) -> Vec<Draft> {
        let mut all = Vec::new();
        if self.has_reference() {
            self.geometry(&mut all);
            self.mounting(&mut all);
        }
        self.clocks(&mut all);
        if self.is_driven() {
            self.commands(&mut all);
        }
        self.in_turns(&mut all);
        self.laws(&mut all);
        all
    }

    pub(super) fn factors(
        &self,
        name: &'static str,
        moves: [Vec<(Place, f64)>; 2],
        priors: [Prior; 2],
    ) -> Vec<Row> {
        let repeatable = [repeatability::SCALE, repeatability::ASYMMETRY];
        let rows = moves.into_iter().zip(priors).zip(repeatable).enumerate();
        rows.map(|(number, ((moves, prior), repeatability))| Row {
            name,
            number,
            moves,
            prior,
            resolution: if number == 1 && !self.has_pose {
                GYRO_ASYMMETRY
            } else {
                FACTOR
            },
            repeatability,
        })
        .collect()
    }

    /// What the drive has of a parameter before any change.
    pub(super) fn nominal_of(&self, drive: usize) -> f64 {
        let place = Drive(drive);
        let is_shared = self.asked.compares(place);
        self.asked.nominal[self.asked.index(place, is_shared)]
    }
}
