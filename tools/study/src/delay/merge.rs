//! Shards put together again: the file of a whole study, as if one machine had done it.

use std::path::Path;

use slipstream_launch::Unusable;

use super::Study;
use super::answers::answers;
use super::grid::Shard;
use crate::StudyError;

/// Reads a study's file.
///
/// # Errors
/// A file that cannot be read or is no study.
pub fn read(path: &Path) -> Result<Study, Unusable> {
    let place = path.display().to_string();
    let text = std::fs::read_to_string(path).map_err(|error| {
        Unusable::new(
            &place,
            format!("cannot be read: {error}"),
            "give files that `slipstream study delay --json` wrote",
        )
    })?;
    let study: Study = serde_json::from_str(&text).map_err(|error| {
        Unusable::new(
            format!("{place}:{}", error.line()),
            format!("is no study: {error}"),
            "give files that `slipstream study delay --json` wrote",
        )
    })?;
    if study.format != 1 {
        return Err(Unusable::new(
            place,
            format!("format is {}", study.format),
            "this program reads format 1",
        ));
    }
    Ok(study)
}

/// Puts all shards of one study together and answers its questions.
///
/// # Errors
/// Shards of different studies, missing or doubled ones.
pub fn merge(shards: &[(String, Study)], threads: usize) -> Result<Study, StudyError> {
    let Some((first_name, first)) = shards.first() else {
        return Err(Unusable::new("FILE", "is missing", "give the shards' files").into());
    };
    let grid = &first.grid;
    grid.validate(first.shard)?;
    let of = first.shard.of;
    let mut parts: Vec<Option<&Study>> = vec![None; of];
    for (name, study) in shards {
        if study.grid != *grid || study.shard.of != of {
            return Err(Unusable::new(
                name,
                format!("is of another study than {first_name}"),
                "merge shards of one command line",
            )
            .into());
        }
        let place = study.shard.index.checked_sub(1);
        let Some(part) = place.and_then(|place| parts.get_mut(place)) else {
            return Err(Unusable::new(name, "has no place in its study", "run it again").into());
        };
        if part.replace(study).is_some() {
            let shard = study.shard.index;
            return Err(Unusable::new(
                name,
                format!("is shard {shard}/{of} a second time"),
                "give each shard once",
            )
            .into());
        }
    }
    let mut points = Vec::new();
    for (place, cell) in grid.cells().into_iter().enumerate() {
        let owner = place % of;
        let shard = owner + 1;
        let Some(part) = parts[owner] else {
            return Err(Unusable::new(
                "FILE",
                format!("shard {shard}/{of} is missing"),
                format!("run it with --shard {shard}/{of} and give its file too"),
            )
            .into());
        };
        let point = part.points.iter().find(|point| point.cell == cell);
        let point = point.ok_or_else(|| {
            let problem = match part.interrupted {
                true => "was interrupted: it lacks points",
                false => "lacks a point",
            };
            Unusable::new(format!("shard {shard}/{of}"), problem, "run it again")
        })?;
        points.push(point.clone());
    }
    Ok(Study {
        format: 1,
        grid: grid.clone(),
        shard: Shard::WHOLE,
        answers: answers(grid, &points, threads)?,
        points,
        interrupted: false,
    })
}
