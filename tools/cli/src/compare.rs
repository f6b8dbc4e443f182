//! `slipstream compare`: the simulation of the recorded commands over the recording, in pictures.

use std::fmt::Write as _;
use std::path::PathBuf;

use clap::Args;
use plotters::prelude::*;
use slipstream_recording::Channel;

use crate::exit::{Error, Exit};
use crate::models::Models;

/// Show the simulation of the recorded commands over the recording: one picture per channel, no
/// diagnosis.
#[derive(Debug, Args)]
pub(crate) struct Arguments {
    /// Folder with recording.toml, or an MCAP file.
    recording: PathBuf,
    /// A robot's model, for all or for the robot NAME; without it the one in the recording.
    #[arg(long, value_name = "[NAME=]FILE.toml")]
    robot: Vec<String>,
    /// The page to write.
    #[arg(long, value_name = "FILE.html", default_value = "compare.html")]
    report: PathBuf,
}

/// Runs the command.
pub(crate) fn run(arguments: &Arguments) -> Result<Exit, Error> {
    let import = slipstream_recording::read(&arguments.recording)?;
    for warning in &import.warnings {
        eprintln!("{warning}");
    }
    let models = Models::read(&arguments.robot)?;
    let channels = slipstream_recording::compare(&import.recording, |robot| models.of(robot))
        .map_err(|why| Error::Input(format!("{}: {why}", arguments.recording.display())))?;
    let failed = |e: String| Error::Failed(format!("{}: {e}", arguments.report.display()));
    let page = page(&import.recording.name, &channels).map_err(failed)?;
    std::fs::write(&arguments.report, page).map_err(|e| failed(e.to_string()))?;
    for channel in &channels {
        let (robot, name, unit) = (&channel.robot, &channel.name, channel.unit);
        match channel.rms_difference() {
            Some(rms) => println!("{robot:12} {name:12} rms difference {rms:.4} {unit}"),
            None => println!("{robot:12} {name:12} nothing to compare"),
        }
    }
    println!("{}", arguments.report.display());
    Ok(Exit::Done)
}

/// One page with all pictures in it.
fn page(title: &str, channels: &[Channel]) -> Result<String, String> {
    let title = escaped(title);
    let mut page = format!(
        "<!doctype html>\n<html lang=\"en\">\n<meta charset=\"utf-8\">\n<title>{title}</title>\n\
         <style>body {{ font-family: sans-serif; margin: 2rem auto; max-width: 960px }}</style>\n\
         <h1>{title}</h1>\n<p>Recorded <span style=\"color:#1f6fb4\">blue</span>, simulated \
         <span style=\"color:#d1495b\">red</span>: open loop from the recorded commands.</p>\n"
    );
    for channel in channels {
        let rms = channel.rms_difference();
        let rms = rms.map_or_else(String::new, |rms| {
            format!(": rms difference {rms:.4} {}", channel.unit)
        });
        let (robot, name) = (escaped(&channel.robot), &channel.name);
        // Writing to a string cannot fail.
        let _ = writeln!(page, "<h2>{robot} {name}{rms}</h2>");
        page.push_str(&picture(channel).map_err(|e| e.to_string())?);
    }
    page.push_str("</html>\n");
    Ok(page)
}

/// Text for a page.
pub(crate) fn escaped(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;")
}

/// Blue for what was recorded.
const RECORDED: RGBColor = RGBColor(0x1f, 0x6f, 0xb4);
/// Red for what was simulated.
const SIMULATED: RGBColor = RGBColor(0xd1, 0x49, 0x5b);

fn picture(channel: &Channel) -> Result<String, DrawingAreaErrorKind<std::io::Error>> {
    let mut svg = String::new();
    {
        let area = SVGBackend::with_string(&mut svg, (920, 300)).into_drawing_area();
        let both = || channel.recorded.iter().chain(&channel.simulated);
        let range = |pick: fn(&(f64, f64)) -> f64| {
            let low = both().map(pick).fold(f64::INFINITY, f64::min);
            let high = both().map(pick).fold(f64::NEG_INFINITY, f64::max);
            let margin = (0.03 * (high - low)).max(1e-9);
            if low <= high {
                low - margin..high + margin
            } else {
                0.0..1.0
            }
        };
        let mut chart = ChartBuilder::on(&area)
            .margin(8)
            .x_label_area_size(32)
            .y_label_area_size(64)
            .build_cartesian_2d(range(|p| p.0), range(|p| p.1))?;
        chart
            .configure_mesh()
            .light_line_style(TRANSPARENT)
            .x_desc("t (s)")
            .y_desc(format!("{} ({})", channel.name, channel.unit))
            .draw()?;
        chart.draw_series(LineSeries::new(thinned(&channel.recorded), &RECORDED))?;
        chart.draw_series(LineSeries::new(thinned(&channel.simulated), &SIMULATED))?;
        area.present()?;
    }
    Ok(svg)
}

/// Points that a picture can show: of every stretch its lowest and its highest.
fn thinned(points: &[(f64, f64)]) -> Vec<(f64, f64)> {
    const STRETCHES: usize = 1500;
    if points.len() <= 2 * STRETCHES {
        return points.to_vec();
    }
    let by_value = |a: &&(f64, f64), b: &&(f64, f64)| a.1.total_cmp(&b.1);
    let stretches = points.chunks(points.len().div_ceil(STRETCHES));
    stretches
        .flat_map(|stretch| {
            let low = stretch.iter().min_by(by_value).copied();
            let high = stretch.iter().max_by(by_value).copied();
            let mut pair: Vec<(f64, f64)> = low.into_iter().chain(high).collect();
            pair.sort_by(|a, b| a.0.total_cmp(&b.0));
            pair
        })
        .collect()
}
