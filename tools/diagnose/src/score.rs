//! Prediction error in the form of the contract: the state at a window's start fitted to its first
//! half second, then simulated open loop.

use slipstream_bus::RobotModel;
use slipstream_sim::Robot;

use crate::fit::{CHANNELS, Misfit, Problem};
use crate::search::Search;
use crate::window::Window;

/// Time over which a window's start is fitted (s).
const FITTED_S: f64 = 0.5;

/// Root mean square of each channel's residual over its deviation (right and left wheel, x, y,
/// yaw), and of the pose channels together. `None` where nothing was measured.
pub(crate) fn prediction(
    search: &Search<'_>,
    model: &RobotModel,
) -> ([Option<f64>; CHANNELS], f64) {
    let mut misfit = Misfit::default();
    let (Ok(list), Ok(robot)) = (slipstream_sim::read_effects(model), Robot::new(model)) else {
        return ([None; CHANNELS], f64::NAN);
    };
    let body = &model.robot;
    for window in search.windows {
        let head: [Window; 1] = [window.head(search.track, FITTED_S)];
        let guess = window.guess(search.track, body.wheel_radius_m, body.half_track_m);
        let problem = Problem {
            track: search.track,
            windows: &head,
            model,
            list: &list,
            free: &[],
        };
        let Some(fit) = problem.fit(&[], &[guess], 30) else {
            continue;
        };
        let after_s = window.from_s + FITTED_S;
        window.simulate(
            search.track,
            &robot,
            &fit.starts[0],
            |stamp_s, channel, residual: f64| {
                if stamp_s > after_s {
                    misfit.squares[channel] += residual * residual;
                    misfit.counts[channel] += 1.0;
                }
            },
        );
    }
    let rms = |squares: f64, count: f64| (count > 0.0).then(|| (squares / count).sqrt());
    let mut channels = [None; CHANNELS];
    for (channel, own) in channels.iter_mut().enumerate() {
        *own = rms(misfit.squares[channel], misfit.counts[channel]);
    }
    let pose = if misfit.counts[2] > 0.0 {
        2..CHANNELS
    } else {
        0..2
    };
    let squares: f64 = misfit.squares[pose.clone()].iter().sum();
    let count: f64 = misfit.counts[pose].iter().sum();
    (channels, rms(squares, count).unwrap_or(f64::NAN))
}
