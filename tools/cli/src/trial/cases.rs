//! The cases of a trial that was asked for: planned ones, or existing recordings with labels.

use std::path::{Path, PathBuf};

use clap::ValueEnum as _;
use slipstream_bus::{InputError, Shard};
use slipstream_trial::label::{self, Labels};
use slipstream_trial::maker::PlannedCase;
use slipstream_trial::part::TrialPart;
use slipstream_trial::seal::sha256;

use super::arguments::Arguments;
use crate::exit::Error;

/// The cases, in their order.
pub(super) enum Cases {
    /// Not yet made.
    New(Vec<PlannedCase>),
    /// The folder of the recordings, and their labels.
    Labelled(PathBuf, Labels),
}

impl Cases {
    /// All cases that were asked for.
    ///
    /// # Errors
    /// A file that contains no labels, or not those of a case that was named.
    pub(super) fn of(arguments: &Arguments) -> Result<Self, Error> {
        let Some(file) = &arguments.labels else {
            let effect = arguments.effect.as_deref();
            let cases = arguments
                .plan
                .cases(arguments.cases, arguments.seed, effect);
            return Ok(Self::New(cases));
        };
        let labels = select(label::read(file)?, &arguments.only, file)?;
        let folder = file.parent().unwrap_or(Path::new("."));
        Ok(Self::Labelled(folder.to_owned(), labels))
    }

    /// Number of cases.
    pub(super) fn count(&self) -> usize {
        match self {
            Self::New(cases) => cases.len(),
            Self::Labelled(_, labels) => labels.len(),
        }
    }

    /// The cases of a shard.
    pub(super) fn of_shard(self, shard: Shard) -> Self {
        match self {
            Self::New(cases) => Self::New(shard.pick(cases)),
            Self::Labelled(folder, labels) => {
                Self::Labelled(folder, shard.pick(labels).into_iter().collect())
            }
        }
    }

    /// What the report of a shard of these cases says about itself.
    ///
    /// # Errors
    /// None in practice: labels that were read can be written.
    pub(super) fn part(&self, arguments: &Arguments, shard: Shard) -> Result<TrialPart, Error> {
        let labels = match self {
            Self::New(_) => None,
            Self::Labelled(_, labels) => {
                let text = label::to_text(labels);
                Some(sha256(&text.map_err(|error| {
                    Error::Failed(format!("--labels: {error}"))
                })?))
            }
        };
        let is_new = labels.is_none();
        let plan = arguments.plan.to_possible_value();
        Ok(TrialPart {
            plan: plan
                .filter(|_| is_new)
                .map(|plan| plan.get_name().to_owned()),
            seed: is_new.then_some(arguments.seed),
            effect: arguments.effect.clone(),
            labels,
            cases: self.count(),
            without: arguments.without.clone(),
            with: arguments
                .with
                .as_ref()
                .map(|program| program.display().to_string()),
            limit_s: arguments.limit_s,
            shard,
        })
    }
}

/// The labels of the cases in `only`; all if it is empty.
fn select(mut labels: Labels, only: &[String], file: &Path) -> Result<Labels, InputError> {
    if let Some(name) = only.iter().find(|name| !labels.contains_key(*name)) {
        return Err(InputError::new(
            format!("--only {name}"),
            format!("is no case of {}", file.display()),
            "name cases as the labels do",
        ));
    }
    labels.retain(|name, _| only.is_empty() || only.contains(name));
    Ok(labels)
}
