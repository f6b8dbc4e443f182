//! Merges shards into the file of the whole study, as if one machine had run it.

use std::path::Path;

use slipstream_bus::InputError;

use super::answers::answers;
use super::grid::{Cell, Shard};
use super::point::Point;
use super::study::Study;
use crate::StudyError;

/// Reads the file of a study or a shard.
///
/// # Errors
/// A file that cannot be read or does not contain a study.
pub fn read(path: &Path) -> Result<Study, InputError> {
    let place = path.display().to_string();
    let text = std::fs::read_to_string(path).map_err(|error| {
        InputError::new(
            &place,
            format!("cannot be read: {error}"),
            "give files that `slipstream study delay --json` wrote",
        )
    })?;
    let study: Study = serde_json::from_str(&text).map_err(|error| {
        InputError::new(
            format!("{place}:{}", error.line()),
            format!("is not a study: {error}"),
            "give files that `slipstream study delay --json` wrote",
        )
    })?;
    if study.format != 1 {
        return Err(InputError::new(
            place,
            format!("format is {}", study.format),
            "this program reads format 1",
        ));
    }
    Ok(study)
}

/// Merges all shards of one study, given with their names, and answers its questions.
///
/// # Errors
/// Shards of different studies; a shard or a point that is missing; a shard given twice.
pub fn merge(shards: &[(String, Study)], threads: usize) -> Result<Study, StudyError> {
    let Some((first_name, first)) = shards.first() else {
        return Err(InputError::new("FILE", "is missing", "give the shards' files").into());
    };
    let grid = &first.grid;
    grid.validate(first.shard)?;
    let of = first.shard.of;
    let mut parts: Vec<Option<&Study>> = vec![None; of];
    for (name, study) in shards {
        if study.grid != *grid || study.shard.of != of {
            return Err(InputError::new(
                name,
                format!("is of another study than {first_name}"),
                "merge shards of one command line",
            )
            .into());
        }
        add(&mut parts, name, study)?;
    }
    let points = (0..)
        .zip(grid.cells())
        .map(|(index, cell)| point(&parts, index, &cell))
        .collect::<Result<Vec<Point>, InputError>>()?;
    Ok(Study {
        format: 1,
        grid: grid.clone(),
        shard: Shard::WHOLE,
        answers: answers(grid, &points, threads)?,
        points,
        interrupted: false,
    })
}

/// Puts a shard into its slot.
fn add<'a>(
    parts: &mut [Option<&'a Study>],
    name: &str,
    study: &'a Study,
) -> Result<(), InputError> {
    let slot = study.shard.index.checked_sub(1);
    let Some(part) = slot.and_then(|slot| parts.get_mut(slot)) else {
        let Shard { index, of } = study.shard;
        let problem = format!("says that it is shard {index}/{of}");
        return Err(InputError::new(name, problem, "run it again"));
    };
    if part.replace(study).is_some() {
        let Shard { index, of } = study.shard;
        return Err(InputError::new(
            name,
            format!("is shard {index}/{of} a second time"),
            "give each shard once",
        ));
    }
    Ok(())
}

/// Finds the point of a cell in its shard; `index` is that of the cell in the grid.
fn point(parts: &[Option<&Study>], index: usize, cell: &Cell) -> Result<Point, InputError> {
    let of = parts.len();
    let slot = index % of;
    let shard = slot + 1;
    let Some(part) = parts[slot] else {
        return Err(InputError::new(
            "FILE",
            format!("shard {shard}/{of} is missing"),
            format!("run it with --shard {shard}/{of} and give its file too"),
        ));
    };
    let found = part.points.iter().find(|point| point.cell == *cell);
    found.cloned().ok_or_else(|| {
        let problem = match part.interrupted {
            true => "was interrupted: some points are missing",
            false => "lacks a point",
        };
        InputError::new(format!("shard {shard}/{of}"), problem, "run it again")
    })
}
