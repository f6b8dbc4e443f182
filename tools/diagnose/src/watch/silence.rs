//! Streams that stop while others go on.

use slipstream_recording::recording::Robot;

use crate::data::wheel_path::median_interval;

/// A stream is silent after so many of its usual intervals, and no less than this (s).
const INTERVALS: f64 = 20.0;
const LEAST_S: f64 = 1.5;

/// How long (s) what usually comes so often (s), and was away for so long at most (s), may be silent.
pub(super) fn most_s(usual_s: f64, longest_s: f64) -> f64 {
    (INTERVALS * usual_s).max(1.5 * longest_s).max(LEAST_S)
}

/// Identity, statement and remedy.
pub(super) type Words = (&'static str, String, &'static str);

/// A stream that is listened for.
struct ListenedStream {
    name: &'static str,
    times_s: fn(&Robot) -> Option<&[f64]>,
    /// How long it may be silent (s).
    most_s: f64,
    last_s: Option<f64>,
    is_silent: bool,
}

/// All streams of a robot that go on in its baseline.
pub(super) struct Silence(Vec<ListenedStream>);

/// A stream's name and its stamps.
type NamedStamps = (&'static str, fn(&Robot) -> Option<&[f64]>);

const STREAMS: [NamedStamps; 4] = [
    ("wheels", |own| Some(&own.wheels.as_ref()?.t_s)),
    ("odometry", |own| Some(&own.odometry.as_ref()?.t_s)),
    ("pose", |own| Some(&own.pose.as_ref()?.t_s)),
    ("imu", |own| Some(&own.imu.as_ref()?.t_s)),
];

impl Silence {
    /// Listens for the streams of a baseline, which are silent for as long as they were there, and a half.
    ///
    /// `rests`: wheels have rows only while they turn.
    pub(super) fn new<'a>(runs: impl Iterator<Item = &'a Robot> + Clone, rests: bool) -> Self {
        let of = |(name, times_s): NamedStamps| {
            let all = runs.clone().filter_map(times_s).filter(|own| own.len() > 1);
            let usual_s = all.clone().map(median_interval).reduce(f64::max)?;
            let gaps = all.flat_map(|own| own.windows(2).map(|pair| pair[1] - pair[0]));
            let longest_s = gaps.fold(0.0, f64::max);
            Some(ListenedStream {
                name,
                times_s,
                most_s: most_s(usual_s, longest_s),
                last_s: None,
                is_silent: false,
            })
        };
        let listened = STREAMS
            .into_iter()
            .filter(|(name, _)| !(rests && *name == "wheels"));
        Self(listened.filter_map(of).collect())
    }

    /// Nothing was heard.
    pub(super) fn again(&mut self) {
        for own in &mut self.0 {
            (own.last_s, own.is_silent) = (None, false);
        }
    }

    /// Hears a piece; which streams fell silent or came back, and when (s).
    pub(super) fn hear(&mut self, piece: &Robot) -> Vec<(f64, Words)> {
        let mut now_s = f64::NEG_INFINITY;
        for own in &mut self.0 {
            let last = (own.times_s)(piece).and_then(|all| all.last().copied());
            if let Some(last_s) = last {
                own.last_s = Some(own.last_s.map_or(last_s, |before| before.max(last_s)));
            }
            now_s = now_s.max(own.last_s.unwrap_or(f64::NEG_INFINITY));
        }
        let mut said = Vec::new();
        for own in &mut self.0 {
            let Some(last_s) = own.last_s else { continue };
            let silent_s = now_s - last_s;
            let name = own.name;
            match (own.is_silent, silent_s > own.most_s) {
                (false, true) => said.push((
                    now_s,
                    (
                        "stream_silent",
                        format!("{name}: no row for {silent_s:.1} s while other streams go on"),
                        "look at its driver, its cable and the network",
                    ),
                )),
                (true, false) => said.push((
                    now_s,
                    (
                        "stream_back",
                        format!("{name}: rows come again"),
                        "nothing to do",
                    ),
                )),
                _ => (),
            }
            own.is_silent = silent_s > own.most_s;
        }
        said
    }

    /// Whether any stream is silent: what others say then is no change.
    pub(super) fn is_silent(&self) -> bool {
        self.0.iter().any(|own| own.is_silent)
    }
}
