//! The page of a trial: one square a case, confusion, detection by size, intervals, every case.

use maud::{Markup, html};
use slipstream_trial::grade::TrialGrade;
use slipstream_trial::own::OwnReport;
use slipstream_trial::part::TrialPart;
use slipstream_trial::tally::{DetectionRate, NuisanceCounts, ScoredCase, TrialReport};

use crate::effect_words::{name, scale_of, unit_of};
use crate::parts::{
    Cell, Frame, Icon, Ink, Page, Scale, Tone, capital, fixed, short, table, verdict, with_unit,
};

/// The HTML file.
pub fn page(report: &TrialReport, command_line: &str) -> String {
    let sentence = sentence(report);
    let bad = report.wrong + report.false_alarms;
    let (tone, icon, chip) = match bad {
        0 => (Tone::Good, Icon::Tick, "Nothing false".to_owned()),
        _ => (
            Tone::Bad,
            Icon::Half,
            format!(
                "{} wrong, {} false alarms",
                report.wrong, report.false_alarms
            ),
        ),
    };
    let planned = report.part.as_ref().map(TrialPart::count);
    let facts = format!(
        "{} · {} without a concealed effect · {} commitments",
        count(report, planned, "cases"),
        report.nulls,
        report.commitments.len()
    );
    let lead = html! {
        (report.missed) " missed, " (report.failed) " without an answer, " (report.refused) " of them refused; "
        (report.contradictions) " contradict their own error, " (report.worse) " predict worse than the nominal model."
        (durations(report))
    };
    let body = html! {
        (verdict(tone, icon, &chip, &facts, &sentence, &lead))
        (squares(report))
        section id="sizes" { div class="cards" { (detection(report)) (intervals(report)) } }
        section id="grades" { h2 { "By kind of case" } (grades(report)) }
        @if !report.nuisances.is_empty() {
            section id="nuisances" { h2 { "By nuisance" }
                p class="sub" { "A case counts for each nuisance that it has." }
                (nuisances(report)) }
        }
        section id="confusion" { h2 { "What was taken for what" } (confusion(report)) }
        section id="cases" { h2 { "Every case" } (every_case(report)) }
        @if !report.commitments.is_empty() {
            section { h2 { "Commitments" }
                p class="sub" { "SHA-256 of a nonce, a line feed and the label, written before the first diagnosis." }
                details { summary { (report.commitments.len()) " hashes" } pre { (report.commitments.join("\n")) } } }
        }
    };
    let page = Page {
        command: "trial",
        subject: format!("{} cases", report.cases),
        summary: sentence.clone(),
        anchors: vec![
            ("sizes", "Sizes"),
            ("grades", "Kinds"),
            ("confusion", "Confusion"),
            ("cases", "Cases"),
            ("made", "Made by"),
        ],
        body,
        command_line: command_line.to_owned(),
        answer: serde_json::to_string(report).ok(),
        ..Page::default()
    };
    page.html()
}

/// The HTML file of a trial on somebody's own recording.
pub fn own_page(report: &OwnReport, command_line: &str) -> String {
    let found = own_sentence(report);
    let trial = &report.trial;
    let bad = trial.wrong + trial.false_alarms;
    let (tone, icon, chip) = match bad {
        0 => (Tone::Good, Icon::Tick, "Nothing false".to_owned()),
        _ => (Tone::Bad, Icon::Half, format!("{bad} false")),
    };
    let facts = format!(
        "{} of {}",
        count(trial, Some(report.planned), "copies"),
        report.on
    );
    let lead = html! {
        "Known changes were put into copies of the recording; " (trial.nulls) " copies are without one. Each copy was diagnosed "
        "against the original." (durations(trial))
    };
    let body = html! {
        (verdict(tone, icon, &chip, &facts, &found, &lead))
        section id="detectable" { h2 { "What would be found on this robot" }
            p class="sub" { "A change of this size since the recording, and every larger one that was tried, was named with its size." }
            (detectable(report)) }
        (squares(trial))
        section id="grades" { h2 { "By kind of copy" } (grades(trial)) }
        section id="confusion" { h2 { "What was taken for what" } (confusion(trial)) }
        section id="cases" { h2 { "Every copy" } (every_case(trial)) }
    };
    let page = Page {
        command: "trial",
        subject: report.on.clone(),
        summary: found.clone(),
        anchors: vec![
            ("detectable", "Sizes"),
            ("grades", "Kinds"),
            ("confusion", "Confusion"),
            ("cases", "Copies"),
            ("made", "Made by"),
        ],
        body,
        command_line: command_line.to_owned(),
        answer: serde_json::to_string(report).ok(),
        ..Page::default()
    };
    page.html()
}

/// How many cases there are, and of how many that were planned if it was interrupted.
fn count(report: &TrialReport, planned: Option<usize>, what: &str) -> String {
    match (report.interrupted, planned) {
        (false, _) => format!("{} {what}", report.cases),
        (true, Some(all)) => format!("interrupted after {} of {all} {what}", report.cases),
        (true, None) => format!("interrupted after {} {what}", report.cases),
    }
}

/// How long the diagnoses took; nothing if they ran elsewhere.
fn durations(report: &TrialReport) -> Markup {
    html! {
        @if let Some([median, longest]) = report.seconds {
            " A diagnosis took " b { (short(median)) " s" } " in the median and " b { (short(longest)) " s" } " at most."
        }
    }
}

fn own_sentence(report: &OwnReport) -> String {
    let [whole, exact, hidden] = report.whole();
    let trial = &report.trial;
    let hidden = match hidden {
        0 => String::new(),
        1 => ", 1 is too small to be seen in it".to_owned(),
        _ => format!(", {hidden} are too small to be seen in it"),
    };
    format!(
        "{exact} of {whole} changes in whole copies were named with their size{hidden}; {} of {} copies without a change raised a false \
         alarm.",
        trial.false_alarms, trial.nulls
    )
}

fn detectable(report: &OwnReport) -> Markup {
    let rows = report.detectable.iter().map(|own| {
        let native = unit_of(&own.effect, &own.parameter);
        let (factor, unit) = scale_of(&own.effect, &own.parameter, native, None);
        let size = |value: f64| with_unit(&short(factor * value), unit);
        let tried = own.tried.iter().map(|(value, found)| {
            let outcome = if *found { "found" } else { "not found" };
            format!("{} {outcome}", size(*value))
        });
        let smallest = own.smallest.map_or("–".to_owned(), size);
        vec![
            Cell::text(name(&own.effect)),
            Cell::text(format!("{} {}", own.effect, own.parameter)),
            Cell::number(own.smallest.unwrap_or(f64::INFINITY), smallest),
            Cell::text(tried.collect::<Vec<_>>().join(", ")),
        ]
    });
    let rows: Vec<Vec<Cell>> = rows.collect();
    let heads = [
        "Effect",
        "Parameter",
        "Found from",
        "Changes that were tried",
    ];
    table("Changes by effect", &heads, &rows)
}

fn sentence(report: &TrialReport) -> String {
    let [concealed, exact] = report.concealed();
    let held = report
        .each
        .iter()
        .flat_map(|own| &own.score.parameters)
        .filter_map(|own| own.covered);
    let (held, all) = held.fold((0, 0), |(held, all), own| {
        (held + usize::from(own), all + 1)
    });
    let intervals = if all > 0 {
        format!("; intervals held {held} of {all}")
    } else {
        String::new()
    };
    format!(
        "What was concealed was named with its size in {exact} of {concealed} cases, {} wrong; false alarms in {} of {} cases \
         without an effect{intervals}.",
        report.wrong, report.false_alarms, report.nulls
    )
}

/// Class and sign of an outcome: colour never stands alone.
fn look(grade: TrialGrade) -> (&'static str, &'static str) {
    match grade.name() {
        "exact" | "right" | "correct_null" => ("s-good", ""),
        "wrong" | "false_alarm" | "failed" => ("s1", "×"),
        "missed" => ("su", ""),
        _ => ("sn", "~"),
    }
}

fn squares(report: &TrialReport) -> Markup {
    let mut each: Vec<&ScoredCase> = report.each.iter().collect();
    each.sort_by_key(|own| {
        TrialGrade::ALL
            .iter()
            .position(|grade| *grade == own.score.grade)
    });
    let counts: Vec<(TrialGrade, usize)> = TrialGrade::ALL
        .iter()
        .map(|grade| {
            (
                *grade,
                each.iter().filter(|own| own.score.grade == *grade).count(),
            )
        })
        .filter(|(_, count)| *count > 0)
        .collect();
    html! {
        section class="first" {
            h2 { "One square a case" }
            ul class="squares" aria-label="Cases by outcome" {
                @for own in &each {
                    li class=(look(own.score.grade).0) title=(format!("{}: {}", own.case, own.score.grade.name().replace('_', " "))) {
                        span class="sq" aria-hidden="true" { (look(own.score.grade).1) }
                    }
                }
            }
            ul class="labs" {
                @for (grade, count) in &counts {
                    li { i class=(format!("sw {}", look(*grade).0)) {} span { (grade.name().replace('_', " ")) " " b { (count) } } }
                }
            }
        }
    }
}

fn detection(report: &TrialReport) -> Markup {
    let share = |count: fn(&DetectionRate) -> usize| -> Vec<(f64, f64)> {
        let steps = report.detection.iter();
        steps
            .map(|own| {
                (
                    (4.0 * own.from_gain).log10(),
                    100.0 * count(own) as f64 / own.effects.max(1) as f64,
                )
            })
            .collect()
    };
    let named = share(|own| own.named);
    let either = share(|own| own.named + own.look_alike);
    html! {
        @if !named.is_empty() {
            figure class="card" {
                figcaption { h3 { "Found, by size" } "Percent of effects, against log10 of the expected gain (nats)" }
                p class="legend" { span class="ca" { i class="kl af" {} "named" } span class="cm" { i class="kl cx da" {} "named, or a declared look-alike" } }
                (Frame::new(Scale::around(named.iter().map(|p| p.0), false, 4), Scale::new(0.0, 100.0, 4), 200, "Share of effects found by expected gain")
                    .x_axis("").y_unit("%").line(Ink::ContextDashed, &either, f64::INFINITY)
                    .line(Ink::After, &named, f64::INFINITY).dots(Ink::After, &named, 7.0).markup())
                p class="small" { "An effect of nine standard deviations has 40 nats, at 1.6 on this axis." }
            }
        }
    }
}

fn intervals(report: &TrialReport) -> Markup {
    let all = report.each.iter().flat_map(|own| &own.score.parameters);
    let errors: Vec<f64> = all
        .filter_map(|own| own.error_in_stated_deviations)
        .filter(|error| error.is_finite())
        .map(|error| error.clamp(-6.0, 6.0))
        .collect();
    if errors.is_empty() {
        return html! {};
    }
    let mut heights = [0_u32; 24];
    let mut dots: Vec<(f64, f64)> = Vec::new();
    for error in &errors {
        let bin = (((error + 6.0) * 2.0) as usize).min(23);
        heights[bin] += 1;
        dots.push((
            f64::midpoint(bin as f64 / 2.0 - 6.0, (bin + 1) as f64 / 2.0 - 6.0),
            f64::from(heights[bin]),
        ));
    }
    let most = heights.iter().copied().max().unwrap_or(1);
    let value = |own: Option<f64>| own.map_or("–".to_owned(), short);
    html! {
        figure class="card" {
            figcaption { h3 { "95 % intervals held " (report.coverage95.map_or("–".to_owned(), |own| format!("{}\u{202f}%", fixed(100.0 * own, 1)))) }
                "One dot a parameter: its error in stated standard deviations; shaded: 95 %" }
            (Frame::new(Scale::new(-6.0, 6.0, 6), Scale::new(0.0, f64::from(most) + 1.0, 4), 200, "Errors of parameters in stated standard deviations")
                .x_axis("").span(None, [-1.96, 1.96]).dots(Ink::After, &dots, 6.0).markup())
            p class="small" { "Errors are " (value(report.error_over_stated)) " times the stated standard deviation (root mean square) and "
                (value(report.error_over_least)) " times the least that any method can reach on the same data (Cramér-Rao bound); in the \
                 median they are " (value(report.median_relative_error.map(|own| 100.0 * own))) "\u{202f}% of the value. Values beyond 6 \
                 stand at 6." }
        }
    }
}

fn grades(report: &TrialReport) -> Markup {
    let names: Vec<String> = TrialGrade::ALL
        .iter()
        .map(|grade| grade.name().replace('_', " "))
        .collect();
    let mut heads = vec!["Cases"];
    heads.extend(names.iter().map(String::as_str));
    let rows: Vec<Vec<Cell>> = report
        .kinds
        .iter()
        .map(|(kind, counts)| {
            let mut row = vec![Cell::text(if kind.is_empty() { "all" } else { kind })];
            row.extend(TrialGrade::ALL.iter().map(|grade| {
                let count = counts.get(grade.name()).copied().unwrap_or(0);
                Cell::number(
                    count as f64,
                    if count == 0 {
                        String::new()
                    } else {
                        count.to_string()
                    },
                )
            }));
            row
        })
        .collect();
    table("Outcomes by kind of case", &heads, &rows)
}

fn nuisances(report: &TrialReport) -> Markup {
    let rows = report.nuisances.iter().map(|(name, counts)| {
        let cells = counts.columns();
        let cells = cells.map(|(_, count)| Cell::number(count as f64, count.to_string()));
        let name = Cell::text(name.replace('_', " "));
        std::iter::once(name).chain(cells).collect()
    });
    let rows: Vec<Vec<Cell>> = rows.collect();
    let names = NuisanceCounts::default().columns().map(|(name, _)| name);
    let heads: Vec<String> = std::iter::once("nuisance")
        .chain(names)
        .map(capital)
        .collect();
    let heads: Vec<&str> = heads.iter().map(String::as_str).collect();
    table("What came of each nuisance", &heads, &rows)
}

fn confusion(report: &TrialReport) -> Markup {
    let rows: Vec<Vec<Cell>> = report
        .confusion
        .iter()
        .map(|(truth, said)| {
            let said: Vec<String> = said
                .iter()
                .map(|(name, count)| format!("{name} ({count})"))
                .collect();
            vec![Cell::text(truth), Cell::text(said.join(", "))]
        })
        .collect();
    table(
        "Concealed effect and what was answered",
        &["Concealed", "Answered (count)"],
        &rows,
    )
}

fn every_case(report: &TrialReport) -> Markup {
    let heads = [
        "Case",
        "Kind",
        "Concealed",
        "Answered",
        "Outcome",
        "Remarks",
        "Prediction error",
        "Time, s",
    ];
    let rows: Vec<Vec<Cell>> = report
        .each
        .iter()
        .map(|own| {
            let side = |at: usize| {
                own.score
                    .pairs
                    .iter()
                    .map(|pair| pair[at].as_str())
                    .collect::<Vec<_>>()
                    .join(", ")
            };
            let held = own.score.held_out;
            vec![
                Cell::text(&own.case),
                Cell::text(&own.kind),
                Cell::text(side(0)),
                Cell::text(side(1)),
                Cell::text(own.score.grade.name().replace('_', " ")),
                Cell::text(own.score.remarks.join("; ")),
                held.map_or_else(
                    || Cell::text(""),
                    |[a, b]| Cell::text(format!("{} → {}", fixed(a, 2), fixed(b, 2))),
                ),
                own.seconds.map_or_else(
                    || Cell::text(""),
                    |seconds| Cell::number(seconds, fixed(seconds, 1)),
                ),
            ]
        })
        .collect();
    table("Every case", &heads, &rows)
}
