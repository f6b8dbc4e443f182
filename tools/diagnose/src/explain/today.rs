//! What changed, found beside runs from before, as a fit of the runs of today alone: what both share is as
//! the model has it, and changes are added to it.

use nalgebra::DMatrix;

use super::search::{Searched, problem};
use crate::estimate::cluster::Precision;
use crate::estimate::scoring::Fit;
use crate::estimate::term::Term;
use crate::model::streams::{Joint, ROBUST, Streams};
use crate::model::table::{Asked, Table};
use crate::select::selected::{Kept, Selected};

/// A search in all runs, as one in those of today, whose filters read `nominal` under the model of before.
pub(super) fn of_today(
    all: &Searched,
    streams: Streams<'_>,
    nominal: Vec<f64>,
    excluded: &[String],
) -> Searched {
    let table = Table::new(&Asked {
        streams,
        nominal: &nominal,
        excluded,
        by_run: all.by_run,
    });
    let found = &all.selected;
    let to = |from: usize| table.find(&all.table.keys[from]);
    let mut at = vec![0.0; table.parameters()];
    let values = found.fit.at.iter().enumerate();
    let values = values.filter_map(|(from, value)| Some((to(from)?, *value)));
    values.for_each(|(to, value)| at[to] = value);
    let places = found.fit.free.iter().enumerate();
    let left: Vec<(usize, usize)> = places
        .filter_map(|(place, from)| Some((place, to(*from)?)))
        .collect();
    let free: Vec<usize> = left.iter().map(|(_, to)| *to).collect();
    let objective = {
        let joint = Joint::new(streams, &nominal, &table.weights, ROBUST);
        problem(&joint, &table).objective(&at, &free)
    };
    let selected = Selected {
        fit: Fit {
            at,
            free,
            objective,
            converged: found.fit.converged,
        },
        precision: of_left(&found.precision, &left),
        kept: kept(found, &table),
        alike: found.alike.clone(),
        halves: found.halves.as_ref().map(|own| own.of(&left)),
    };
    Searched {
        table,
        nominal,
        selected,
        criterion: all.criterion,
        by_run: all.by_run,
        is_undetermined: all.is_undetermined,
        dense: None,
    }
}

/// What is known of the fitted parameters at these places.
fn of_left(known: &Precision, left: &[(usize, usize)]) -> Precision {
    let places: Vec<usize> = left.iter().map(|(place, _)| *place).collect();
    let of = |own: &DMatrix<f64>| own.select_rows(&places).select_columns(&places);
    Precision {
        covariance: of(&known.covariance),
        expected: of(&known.expected),
        dispersion: places.iter().map(|i| known.dispersion[*i]).collect(),
    }
}

/// The terms that are kept, as `table` has them.
fn kept(found: &Selected, table: &Table) -> Vec<Kept> {
    let kept = found.kept.iter().filter_map(|kept| {
        let mut terms = table.terms.iter();
        let own = terms.find(|term| term.name == kept.term.name)?;
        Some(Kept {
            term: Term {
                resolution: kept.term.resolution.clone(),
                repeatability: kept.term.repeatability.clone(),
                ..own.clone()
            },
            ..kept.clone()
        })
    });
    kept.collect()
}
