//! What the paper leaves open, as the files of its experiments assume it.

use std::borrow::Cow;

use serde::{Deserialize, Serialize};
use slipstream_launch::{Request, resolve};

use crate::StudyError;

/// A value that the paper leaves open, as the file of an experiment assumes it.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Assumption {
    /// The experiment whose file makes the assumption.
    pub experiment: Cow<'static, str>,
    /// Name, keys with the assumed values, and reason.
    #[serde(flatten)]
    pub assumed: slipstream_launch::Assumption,
}

/// The assumptions in the files of the paper's experiments.
///
/// # Errors
/// A file that cannot be used.
pub fn assumptions() -> Result<Vec<Assumption>, StudyError> {
    let mut all = Vec::new();
    for experiment in ["platoon", "single"] {
        let request = Request {
            experiment: Some(experiment.to_owned()),
            ..Request::default()
        };
        let assumed = resolve(&request)?.assumptions.into_iter();
        all.extend(assumed.map(|assumed| Assumption {
            experiment: experiment.into(),
            assumed,
        }));
    }
    Ok(all)
}
