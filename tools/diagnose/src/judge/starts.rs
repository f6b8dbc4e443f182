//! Windows whose start is not known: no prediction from there says anything of the model.

use super::score::Score;

/// A start is not known where it is so many standard deviations from what it was fitted to, and so many times as far
/// as half of the others.
const UNKNOWN_START_DEVIATIONS: f64 = 5.0;
const TIMES: f64 = 10.0;
/// So many windows at most are left out of each one.
const SHARE: usize = 3;

/// Whether the start of each window is known.
pub(crate) fn known(scores: &[Score]) -> Vec<bool> {
    let mut levels: Vec<f64> = scores.iter().map(Score::start).collect();
    levels.sort_by(f64::total_cmp);
    let Some(middle) = levels.get(levels.len() / 2) else {
        return Vec::new();
    };
    let most = UNKNOWN_START_DEVIATIONS.max(TIMES * middle);
    let known: Vec<bool> = scores.iter().map(|own| own.start() <= most).collect();
    let left_out = known.iter().filter(|own| !**own).count();
    if left_out * SHARE > scores.len() {
        vec![true; scores.len()]
    } else {
        known
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(starts: &[f64]) -> Vec<bool> {
        let scores: Vec<Score> = starts
            .iter()
            .map(|level| {
                let mut score = Score::default();
                score.begin(*level);
                score
            })
            .collect();
        known(&scores)
    }

    #[test]
    fn one_start_among_many_is_left_out() {
        assert_eq!(of(&[1.0, 1.2, 100.0, 0.9]), [true, true, false, true]);
    }

    #[test]
    fn a_model_that_is_wrong_everywhere_is_judged_everywhere() {
        assert_eq!(of(&[40.0, 100.0, 60.0, 30.0]), [true; 4]);
        // and where most starts are as bad as that
        assert_eq!(of(&[1.0, 1.0, 1.0, 100.0, 100.0]), [true; 5]);
    }
}
