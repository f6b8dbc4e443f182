//! What one machine lacks, its runs alone.

use slipstream_bus::RobotModel;

use super::selection::{Selected, Selection};
use crate::data::track::Track;
use crate::model::hypothesis::{self, Hypothesis};
use crate::model::plant::machine::Machine;
use crate::model::plant::table::Table;
use crate::predict::predictor::Predictor;
use crate::request::Request;

/// Rows of a series over all runs above which it is thinned, and that each run keeps: what is denser says
/// little more, and every fit filters all of them.
const ROWS: usize = 6000;
const LEAST_ROWS: usize = 500;

/// What was found on a machine.
pub(crate) struct Judged {
    pub(super) machine: Machine,
    pub(super) selected: Selected,
    /// What was looked for.
    pub(super) all: Vec<Hypothesis>,
    /// The parameters in which it was found.
    pub(super) table: Table,
    /// Of a comparison, 95 % intervals of what was there before: effect, parameter, interval.
    pub(super) nominal: Vec<(&'static str, &'static str, [f64; 2])>,
}

/// The runs of a machine as the filter reads them.
pub(super) fn machine_of(tracks: &[Track], model: &RobotModel, excluded: &[String]) -> Machine {
    let mut tracks = tracks.to_vec();
    let most = (ROWS / tracks.len().max(1)).max(LEAST_ROWS);
    tracks.iter_mut().for_each(|track| track.thin(most));
    Machine::new(tracks, model.clone(), excluded)
}

/// What a machine lacks of the catalogue.
pub(super) fn alone(
    request: &Request<'_>,
    predictor: &Predictor,
    progress: &(dyn Fn(&str) + Sync),
) -> Option<Judged> {
    let all = hypothesis::all(&predictor.model, &predictor.tracks, request.excluded);
    let mut selection = Selection {
        machine: machine_of(&predictor.tracks, &predictor.model, request.excluded),
        all: &all,
        known: &[],
        progress,
        begun: None,
        is_whole: false,
    };
    let selected = selection.run()?;
    let machine = selection.machine;
    Some(Judged {
        table: Table::new(&machine, &all, &[]),
        machine,
        selected,
        all,
        nominal: Vec::new(),
    })
}

/// The same with single pushes, and with what the catalogue does not hold.
pub(super) fn whole(judged: Judged, progress: &(dyn Fn(&str) + Sync)) -> Option<Judged> {
    let mut selection = Selection {
        machine: judged.machine,
        all: &judged.all,
        known: &[],
        progress,
        begun: Some(judged.selected),
        is_whole: true,
    };
    let selected = selection.run()?;
    let machine = selection.machine;
    Some(Judged {
        machine,
        selected,
        ..judged
    })
}
