//! What the delay of the links does in one run: the same run with and without it.

use slipstream_bus::Experiment;
use slipstream_launch::in_process;
use slipstream_launch::summary::DelayEffect;

use super::follower_recorder::FollowerRecorder;
use crate::StudyError;

/// Largest work that is done for it, number of robots times duration (s): about a second.
const MOST_ROBOT_S: f64 = 3_000.0;

/// What the delay of the links did. `None` without a delay or followers, for programs of the user's own, and for runs so long
/// that two more of them would take a while.
///
/// # Errors
/// When a run fails.
pub fn effect(experiment: &Experiment) -> Result<Option<DelayEffect>, StudyError> {
    let settings = &experiment.settings;
    let links = &settings.links;
    let has_delay = links.delay_s > 0.0 || links.jitter_s > 0.0 || !links.trace.is_empty();
    let is_alone = settings.open_loop.enabled || experiment.robots.len() < 2;
    let work_robot_s = experiment.robots.len() as f64 * settings.duration_s;
    let is_ours = settings.agents.is_empty();
    if !has_delay || is_alone || !is_ours || work_robot_s > MOST_ROBOT_S {
        return Ok(None);
    }
    let mut without = experiment.clone();
    without.half_round_trips_ns = Vec::new();
    let links = &mut without.settings.links;
    (links.delay_s, links.jitter_s, links.trace) = (0.0, 0.0, String::new());
    let (age_s, _) = run(experiment)?;
    let (age_without_s, max_spacing_error_without_m) = run(&without)?;
    Ok(Some(DelayEffect {
        age_s,
        age_without_s,
        max_spacing_error_without_m,
    }))
}

/// Mean age of the positions in use (s) and the largest true spacing error (m).
fn run(experiment: &Experiment) -> Result<(f64, f64), StudyError> {
    let recorder = FollowerRecorder::new(experiment);
    let (reports, recorder) = in_process::run_recorded(experiment, false, recorder)?;
    let robots = reports.plant.robots.iter();
    let errors = robots.filter_map(|robot| robot.max_spacing_error_m);
    Ok((recorder.mean_age_s(), errors.fold(0.0, f64::max)))
}

#[cfg(test)]
mod tests {
    use slipstream_launch::{Request, resolve};

    use super::*;

    fn of(set: &[(&str, &str)]) -> Option<DelayEffect> {
        let own = |(key, value): &(&str, &str)| ((*key).to_owned(), (*value).to_owned());
        let request = Request {
            set: set.iter().map(own).collect(),
            ..Request::default()
        };
        effect(&resolve(&request).unwrap().experiment).unwrap()
    }

    /// Sent at every outer tick, a position is used at the tick after its delay.
    #[test]
    fn the_age_is_the_delay_where_positions_are_sent_at_every_tick() {
        let found = of(&[("links.delay_s", "0.1"), ("links.protocol", "periodic")]).unwrap();
        // Without a delay it is used one outer period (50 ms) later; a delay of two periods is over at the second tick.
        assert!((found.age_s - 0.1).abs() < 1e-9, "{found:?}");
        assert!((found.age_without_s - 0.05).abs() < 1e-9, "{found:?}");
    }

    #[test]
    fn without_a_delay_there_is_nothing_to_tell() {
        assert_eq!(of(&[]), None);
        assert_eq!(of(&[("links.delay_s", "0.1"), ("robots.count", "1")]), None);
    }
}
