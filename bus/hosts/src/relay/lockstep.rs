//! The relay in lockstep: it plays the rounds of the plant with the agents of its host.

use slipstream_bus::transport::BusError;
use slipstream_ipc::wake_page::Stage;

use super::play::{Play, stopped_by_plant};
use crate::frame::{Answer, Down, Round, Up, encode};

/// The last answer, encoded, and its round.
type LastAnswer = (u64, Vec<u8>);

/// Answers the rounds of the plant until the run is over. Returns why it ended early, if it did.
pub(super) fn rounds(play: &mut Play<'_>) -> Result<Option<String>, BusError> {
    let mut answered: LastAnswer = (0, Vec::new());
    play.send(&Up::Ready(play.run))?;
    play.joined.wake_page().advance(Stage::Running);
    loop {
        match play.receive()? {
            None if answered.0 == 0 && play.contact.resend_is_due() => {
                play.send(&Up::Ready(play.run))?;
            }
            Some(Down::Round(round)) => answer(play, &round, &mut answered)?,
            Some(Down::Over(end)) => return play.end(end),
            Some(Down::Stop(reason)) => return Err(stopped_by_plant(reason)),
            None | Some(_) => {}
        }
    }
}

/// Plays a round, or answers one that came again from memory.
fn answer(play: &mut Play<'_>, round: &Round, answered: &mut LastAnswer) -> Result<(), BusError> {
    if round.number == answered.0 {
        play.contact.sent();
        return play.carrier.send(&answered.1);
    }
    if round.number < answered.0 {
        return Ok(());
    }
    if round.number > answered.0 + 1 {
        return Err(BusError::failed("network", "a round is missing"));
    }
    play.measure(&round.measured)?;
    let now_ns = round.measured.now_ns;
    for position in &round.positions {
        play.crossing.deliver(position)?;
    }
    play.plant.begin_round(now_ns, &play.encoders)?;
    while !play.plant.await_answers()? {
        play.drain_records()?;
        play.beat()?;
    }
    play.plant.take_answers(&mut play.commands)?;
    play.joined.wake_page().publish_progress(now_ns, 0.0, 0.0);
    let mut positions = Vec::new();
    play.crossing.poll(|position| positions.push(position))?;
    play.drain_records()?;
    let commands = play.robots.iter().map(|&own| play.commands[own as usize]);
    let answer = Up::Answer(Answer {
        number: round.number,
        commands: commands.collect(),
        positions,
        records: std::mem::take(&mut play.chunks),
    });
    *answered = (round.number, encode(&answer)?);
    play.contact.sent();
    play.carrier.send(&answered.1)
}
