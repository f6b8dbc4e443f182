//! The latency of each link as a page: the way of its median message, and histograms.

use std::fmt::Write as _;
use std::path::Path;

use plotters::coord::Shift;
use plotters::prelude::*;
use slipstream_trace::{Answer, Fate, Hop, Reading, STAGES, Way, follow};

use crate::compare::escaped;

/// Size of a picture (pixels).
const SIZE: (u32, u32) = (920, 260);
/// Bars of a histogram.
const BARS: usize = 60;
const BLUE: RGBColor = RGBColor(0x1f, 0x6f, 0xb4);

type Drawn = Result<(), DrawingAreaErrorKind<std::io::Error>>;
type Area<'a> = DrawingArea<SVGBackend<'a>, Shift>;

/// The whole page.
pub(super) fn page(recording: &Path, answer: &Answer, reading: &Reading) -> Result<String, String> {
    let title = escaped(&format!("Latency of {}", recording.display()));
    let mut page = format!(
        "<!doctype html>\n<html lang=\"en\">\n<meta charset=\"utf-8\">\n<title>{title}</title>\n\
         <style>body {{ font-family: sans-serif; margin: 2rem auto; max-width: 960px }}</style>\n\
         <h1>{title}</h1>\n"
    );
    let messages = follow(&reading.log);
    for hop in &answer.hops {
        let of_hop = messages.iter().filter(|message| {
            [reading.name_of(message.from), reading.name_of(message.to)] == [&*hop.from, &*hop.to]
        });
        let mut ways: Vec<Way> = of_hop
            .filter_map(|message| match message.fate {
                Fate::Used(way) => Some(way),
                _ => None,
            })
            .collect();
        ways.sort_by_key(Way::end_to_end_ns);
        add_hop(&mut page, hop, &ways).map_err(|e| e.to_string())?;
    }
    page.push_str("</html>\n");
    Ok(page)
}

fn add_hop(page: &mut String, hop: &Hop, ways: &[Way]) -> Drawn {
    let (from, to) = (escaped(&hop.from), escaped(&hop.to));
    let (sent, used, others) = (hop.sent, hop.messages, super::others(&hop.incomplete));
    // Writing to a string cannot fail.
    let _ = writeln!(
        page,
        "<h2>{from} → {to}</h2>\n<p>{sent} sent, {used} used{others}</p>"
    );
    // The message that `p50_s` of the answer is about.
    let Some(median) = ways.get(ways.len().div_ceil(2).saturating_sub(1)) else {
        return Ok(());
    };
    page.push_str("<h3>The way of the median message</h3>\n");
    add(page, |area| waterfall(area, median))?;
    page.push_str("<h3>How long messages took</h3>\n");
    let durations: Vec<i64> = ways.iter().map(Way::end_to_end_ns).collect();
    add(page, |area| histogram(area, "end to end", &durations))?;
    for (i, stage) in STAGES.iter().enumerate() {
        let mut durations: Vec<i64> = ways.iter().map(|way| way.stages_ns()[i]).collect();
        durations.sort_unstable();
        if durations.first() != durations.last() {
            add(page, |area| histogram(area, stage, &durations))?;
        }
    }
    Ok(())
}

/// Adds a picture to the page.
fn add(page: &mut String, draw: impl FnOnce(&Area<'_>) -> Drawn) -> Drawn {
    let mut svg = String::new();
    {
        let area = SVGBackend::with_string(&mut svg, SIZE).into_drawing_area();
        draw(&area)?;
        area.present()?;
    }
    page.push_str(&svg);
    page.push('\n');
    Ok(())
}

fn ms(ns: i64) -> f64 {
    ns as f64 / 1e6
}

/// Each stage a bar, where it lies in time.
fn waterfall(area: &Area<'_>, way: &Way) -> Drawn {
    let start_ns = way.instants_ns[0];
    let end = ms(way.end_to_end_ns()).max(1e-6);
    let rows = STAGES.len() as f64;
    let mut chart = ChartBuilder::on(area)
        .margin(8)
        .x_label_area_size(32)
        .build_cartesian_2d(0.0..1.45 * end, 0.0..rows)?;
    let mut mesh = chart.configure_mesh();
    mesh.disable_mesh().disable_y_axis();
    mesh.x_desc("since the encoder sample (ms)").draw()?;
    for (row, (stage, pair)) in STAGES.iter().zip(way.instants_ns.windows(2)).enumerate() {
        let [begin, end] = [pair[0], pair[1]].map(|t_ns| ms(t_ns.saturating_sub(start_ns)));
        let row = rows - 1.0 - row as f64;
        let bar = [(begin, row + 0.15), (end, row + 0.85)];
        chart.draw_series([Rectangle::new(bar, BLUE.filled())])?;
        let label = format!("  {stage} {:.4} ms", end - begin);
        let font = ("sans-serif", 13);
        chart.draw_series([Text::new(label, (end, row + 0.65), font)])?;
    }
    Ok(())
}

/// How many of the durations (ns, sorted) fall where.
fn histogram(area: &Area<'_>, name: &str, durations_ns: &[i64]) -> Drawn {
    let (Some(&low), Some(&high)) = (durations_ns.first(), durations_ns.last()) else {
        return Ok(());
    };
    let (low, high) = (ms(low), ms(high));
    let width = ((high - low) / BARS as f64).max(1e-6);
    let mut counts = [0_u32; BARS];
    for &duration_ns in durations_ns {
        let bar = ((ms(duration_ns) - low) / width) as usize;
        counts[bar.min(BARS - 1)] += 1;
    }
    let most = counts.iter().copied().max().unwrap_or(1);
    let mut chart = ChartBuilder::on(area)
        .margin(8)
        .x_label_area_size(32)
        .y_label_area_size(48)
        .build_cartesian_2d(low..low + width * BARS as f64, 0..most + 1)?;
    let mut mesh = chart.configure_mesh();
    mesh.disable_x_mesh().light_line_style(TRANSPARENT);
    mesh.x_desc(format!("{name} (ms)"))
        .y_desc("messages")
        .draw()?;
    let bars = counts.iter().enumerate().filter(|(_, count)| **count > 0);
    chart.draw_series(bars.map(|(i, &count)| {
        let begin = low + width * i as f64;
        Rectangle::new([(begin, 0), (begin + width, count)], BLUE.filled())
    }))?;
    Ok(())
}
