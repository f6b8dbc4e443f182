//! Report page of a trace: for each link the stages of the median message, and histograms of the latency.

use std::path::Path;

use slipstream_report::{Histogram, Page, PictureError, Row, Timeline};
use slipstream_trace::{Answer, Chain, Fate, Hop, Reading, STAGES, follow};

use super::table::unused;
use crate::command_line::command_line;

/// The whole page.
pub(super) fn page(
    recording: &Path,
    answer: &Answer,
    reading: &Reading,
) -> Result<String, PictureError> {
    let title = format!("Latency of {}", recording.display());
    let mut page = Page::new(&title, &command_line());
    let messages = follow(&reading.log);
    for hop in &answer.hops {
        let of_hop = messages.iter().filter(|message| {
            [reading.name_of(message.from), reading.name_of(message.to)] == [&*hop.from, &*hop.to]
        });
        let mut chains: Vec<Chain> = of_hop
            .filter_map(|message| match message.fate {
                Fate::Used(chain) => Some(chain),
                _ => None,
            })
            .collect();
        chains.sort_by_key(Chain::end_to_end_ns);
        add_hop(&mut page, hop, &chains)?;
    }
    Ok(page.end())
}

fn add_hop(page: &mut Page, hop: &Hop, chains: &[Chain]) -> Result<(), PictureError> {
    let (sent, used, others) = (hop.sent, hop.messages, unused(&hop.incomplete));
    page.section(&format!("{} → {}", hop.from, hop.to));
    page.paragraph(&format!("{sent} sent, {used} used{others}"));
    // The message whose latency is the answer's `p50_s`.
    let Some(median) = chains.get(chains.len().div_ceil(2).saturating_sub(1)) else {
        return Ok(());
    };
    page.figure(
        &waterfall(median)?,
        "Stages of the message with the median latency.",
    );
    let durations = chains.iter().map(|chain| ms(chain.end_to_end_ns()));
    let histogram = Histogram::new("end to end (ms)", "messages", durations);
    page.figure(&histogram.svg()?, "Distribution of the end-to-end latency.");
    for (i, stage) in STAGES.iter().enumerate() {
        let durations = || chains.iter().map(|chain| chain.stages_ns()[i]);
        if durations().min() != durations().max() {
            let histogram =
                Histogram::new(format!("{stage} (ms)"), "messages", durations().map(ms));
            page.figure(&histogram.svg()?, &format!("Distribution of {stage}."));
        }
    }
    Ok(())
}

fn ms(ns: i64) -> f64 {
    ns as f64 / 1e6
}

/// Waterfall chart: one bar for each stage, at its place in time.
fn waterfall(chain: &Chain) -> Result<String, PictureError> {
    let start_ns = chain.instants_ns[0];
    let stage_row = |(stage, pair): (&&str, &[i64])| {
        let [from, to] = [pair[0], pair[1]].map(|t_ns| ms(t_ns.saturating_sub(start_ns)));
        Row {
            name: (*stage).to_owned(),
            spans: vec![(from, to)],
            note: format!("{:.4} ms", to - from),
        }
    };
    let rows = STAGES
        .iter()
        .zip(chain.instants_ns.windows(2))
        .map(stage_row);
    Timeline::new("since the encoder sample (ms)", rows).svg()
}
