//! The traces of two runs of one experiment beside each other, link by link, matched by the names of the robots.

use slipstream_recording::two_runs::{Both, DelayPercentiles, LinkPair, StagePair};

use crate::answer::{Hop, answer};
use crate::compare::{HopChange, against};
use crate::percentiles::Percentiles;
use crate::read::TraceReading;

/// Median and 95th percentile of every stage in both runs, of the links that are in both.
pub fn both(real: &TraceReading, simulated: &TraceReading) -> Vec<LinkPair> {
    // Means are compared by the index of a robot.
    let changes = if real.robots == simulated.robots {
        against(&real.log, &simulated.log, &real.robots)
    } else {
        Vec::new()
    };
    let [here, there] = [real, simulated].map(|reading| answer(&reading.log, &reading.robots).hops);
    let pair = |hop: &Hop| {
        let is_same = |from: &str, to: &str| from == hop.from && to == hop.to;
        let other = there.iter().find(|own| is_same(&own.from, &own.to))?;
        let change = changes.iter().find(|own| is_same(&own.from, &own.to));
        Some(LinkPair {
            from: hop.from.clone(),
            to: hop.to.clone(),
            stages: stages(hop, other, change),
        })
    };
    here.iter().filter_map(pair).collect()
}

/// The stages that one of both has, then `end_to_end`.
fn stages(real: &Hop, simulated: &Hop, change: Option<&HopChange>) -> Vec<StagePair> {
    let of = |hop: &Hop, name: &str| {
        let stage = hop.stages.iter().find(|own| own.stage == name);
        let figures = match name {
            "end_to_end" => hop.end_to_end,
            _ => stage.map(|own| own.figures),
        };
        figures.map(|Percentiles { p50_s, p95_s, .. }| DelayPercentiles { p50_s, p95_s })
    };
    let names = crate::chain::STAGES.into_iter().chain(["end_to_end"]);
    let pair = |name: &str| StagePair {
        stage: name.to_owned(),
        delays: Both {
            real: of(real, name),
            simulated: of(simulated, name),
        },
        changed: change
            .and_then(|own| own.stages.iter().find(|stage| stage.stage == name))
            .filter(|own| own.ci95_s.is_some())
            .map(|own| own.changed),
    };
    let pairs = names.map(pair);
    pairs.filter(|own| !own.delays.is_empty()).collect()
}
