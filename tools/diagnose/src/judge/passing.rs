//! The search for findings that predict no quantity worse than the model that they replace.

/// An effect by which predictions become worse, and the quantity that is predicted worse.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Culprit {
    pub(crate) effect: &'static str,
    pub(crate) quantity: &'static str,
}

/// What `find` finds without the effects that are excluded, and without those that make predictions worse: these
/// are returned as well. `progress` hears why it looks again.
///
/// # Errors
/// Those of `find`.
pub(crate) fn passing<T, E>(
    excluded: &[String],
    progress: &dyn Fn(&str),
    mut find: impl FnMut(&[String]) -> Result<Result<T, Culprit>, E>,
) -> Result<(T, Vec<String>), E> {
    let mut refused: Vec<String> = Vec::new();
    loop {
        match find(&[excluded, refused.as_slice()].concat())? {
            Ok(found) => return Ok((found, refused)),
            Err(Culprit { effect, quantity }) => {
                let what = format!(
                    "{quantity} is predicted worse with {effect}: looking for better findings"
                );
                progress(&what.replace('_', " "));
                refused.push(effect.to_owned());
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_makes_predictions_worse_is_forbidden_until_nothing_does() {
        let excluded = ["payload".to_owned()];
        let mut seen = Vec::new();
        let (found, refused) = passing(&excluded, &|_| (), |forbidden| {
            seen.push(forbidden.len());
            let culprit = Culprit {
                effect: "track_width",
                quantity: "heading",
            };
            Ok::<_, ()>(if forbidden.len() < 2 {
                Err(culprit)
            } else {
                Ok(forbidden.to_vec())
            })
        })
        .unwrap();
        assert_eq!(seen, [1, 2]);
        assert_eq!(found, ["payload", "track_width"]);
        assert_eq!(refused, ["track_width"]);
    }
}
