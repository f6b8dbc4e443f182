//! A recording that is played as if its robot were driving.

use std::time::{Duration, Instant};

use slipstream_bus::InputError;
use slipstream_recording::{Pieces, Recording};

use super::heard::{Heard, Source};

/// Length of a piece (s).
const PIECE_S: f64 = 0.5;

/// A recording in pieces, as fast as it is heard, or at a speed.
pub struct Replay {
    name: String,
    pieces: Pieces,
    /// The piece that is not due yet, and when it ends (s).
    next: Option<(f64, Recording)>,
    /// Times as fast as it was recorded.
    speed: Option<f64>,
    /// When the first piece began, and its time (s).
    began: Option<(Instant, f64)>,
}

impl Replay {
    /// Plays a recording `speed` times as fast as it was recorded, or without waiting.
    pub fn new(name: &str, recording: Recording, speed: Option<f64>) -> Self {
        Self {
            name: name.to_owned(),
            pieces: Pieces::new(recording, PIECE_S),
            next: None,
            speed: speed.filter(|speed| *speed > 0.0),
            began: None,
        }
    }

    /// How long it is until what ends at `end_s` is due.
    fn until(&mut self, end_s: f64) -> Duration {
        let Some(speed) = self.speed else {
            return Duration::ZERO;
        };
        let (began, first_s) = *self
            .began
            .get_or_insert_with(|| (Instant::now(), end_s - PIECE_S));
        let due = Duration::try_from_secs_f64((end_s - first_s) / speed);
        due.unwrap_or_default().saturating_sub(began.elapsed())
    }
}

impl Source for Replay {
    fn name(&self) -> &str {
        &self.name
    }

    fn hear(&mut self, wait: Duration) -> Result<Heard, InputError> {
        let next = self.next.take().or_else(|| self.pieces.next());
        let Some((end_s, piece)) = next else {
            return Ok(Heard::End);
        };
        let until = self.until(end_s);
        std::thread::sleep(until.min(wait));
        if until > wait {
            self.next = Some((end_s, piece));
            return Ok(Heard::Nothing);
        }
        Ok(Heard::Rows(piece))
    }
}
