//! What is said of changes: a line on the terminal, a line of JSON, a message to Foxglove.

use std::collections::BTreeMap;
use std::fs::File;
use std::io::Write as _;
use std::path::Path;

use serde_json::{Value, json};
use slipstream_answer::statement::change;
use slipstream_answer::{Answer, Finding, Verdict};
use slipstream_bag::Announced;
use slipstream_bus::InputError;
use slipstream_diagnose::{Change, Event, State};
use slipstream_live::Server;

use crate::exit::Error;
use crate::print::{self, note_line, print_line};
use crate::viewers::invitation;

/// The topic of Foxglove.
const TOPIC: &str = "/slipstream/changes";

/// Where it is said.
pub(super) struct Spoken {
    json: Option<File>,
    /// JSON goes to standard output, and nothing else does.
    is_piped: bool,
    server: Option<Server>,
    confirmed: usize,
    raised: usize,
}

impl Spoken {
    pub(super) fn new(json: Option<&Path>, listen: Option<&str>) -> Result<Self, Error> {
        let is_piped = json == Some(Path::new("-"));
        let file = json.filter(|_| !is_piped).map(|path| {
            let made = File::create(path);
            made.map_err(|error| InputError::unreadable(path, &error))
        });
        let server = listen.map(|address| {
            let mut server = Server::start(address, "slipstream watch")?;
            server.announce(&Announced {
                topic: TOPIC,
                encoding: "json",
                schema_name: "slipstream.Change",
                schema_encoding: "jsonschema",
                schema: include_bytes!("../../schemas/watch.schema.json"),
                metadata: &BTreeMap::new(),
            });
            let host = address.rsplit_once(':').map_or("", |(host, _)| host);
            note_line!("{}", invitation(&format!("{host}:{}", server.port())));
            Ok::<Server, InputError>(server)
        });
        Ok(Self {
            json: file.transpose()?,
            is_piped,
            server: server.transpose()?,
            confirmed: 0,
            raised: 0,
        })
    }

    /// Says an event.
    pub(super) fn say(&mut self, event: &Event) -> Result<(), Error> {
        let (t_s, line, value) = match event {
            Event::Change(change) => {
                match change.state {
                    State::Raised => self.raised += 1,
                    State::Confirmed => self.confirmed += 1,
                    State::Withdrawn => (),
                }
                (change.t_s, words(change), changed(change))
            }
            Event::Fault(t_s, warning) => {
                let robot = warning.robot.as_deref().unwrap_or("");
                let line = format!(
                    "{t_s:.1} s, robot {robot}: {}; {}",
                    warning.statement, warning.remedy
                );
                let value =
                    json!({"format": 1, "t_s": t_s, "robot": warning.robot, "warning": warning});
                (*t_s, line, value)
            }
        };
        self.line(&line);
        self.value(t_s, &value)
    }

    /// Says how rows compare with the baseline, all together.
    pub(super) fn compared(
        &mut self,
        answer: &Answer,
        span_s: Option<[f64; 2]>,
    ) -> Result<(), Error> {
        let [from_s, to_s] = span_s.unwrap_or_default();
        for finding in &answer.findings {
            let change = Change {
                t_s: to_s,
                onset_s: from_s,
                robot: finding.robot.clone(),
                finding: finding.clone(),
                state: State::Confirmed,
            };
            self.line(&finding.statement);
            self.value(to_s, &changed(&change))?;
        }
        if answer.findings.is_empty() {
            let over_s = to_s - from_s;
            let before = answer.against.join(", ");
            let line = match answer.verdict {
                Verdict::Match => format!("No change since {before}, in {over_s:.0} s of driving."),
                _ => format!("{}.", answer.statement),
            };
            self.line(&line);
        }
        Ok(())
    }

    /// Says how a watch went.
    pub(super) fn ended(&self) {
        let line = match (self.confirmed, self.raised) {
            (0, 0) => "No change.".to_owned(),
            (confirmed, raised) => format!(
                "{} {confirmed}, raised {raised}. To see what they explain: slipstream diagnose SOURCE --against BASELINE",
                "Changes confirmed:"
            ),
        };
        self.line(&line);
    }

    fn line(&self, line: &str) {
        if !self.is_piped {
            print_line!("{line}");
        }
    }

    fn value(&mut self, t_s: f64, value: &Value) -> Result<(), Error> {
        if self.is_piped {
            print::raw(format_args!("{value}\n"));
        }
        if let Some(file) = &mut self.json {
            let written = writeln!(file, "{value}").and_then(|()| file.flush());
            written.map_err(|error| Error::Failed(format!("--json: {error}")))?;
        }
        if let Some(server) = &self.server {
            let t_ns = (t_s.max(0.0) * 1e9) as u64;
            server.send(TOPIC, t_ns, value.to_string().as_bytes());
        }
        Ok(())
    }
}

impl Drop for Spoken {
    /// However a watch ends, viewers have time to take the last messages.
    fn drop(&mut self) {
        if let Some(server) = &mut self.server {
            server.end();
        }
    }
}

/// A change as JSON.
fn changed(change: &Change) -> Value {
    json!({
        "format": 1,
        "t_s": change.t_s,
        "onset_s": change.onset_s,
        "robot": change.robot,
        "finding": change.finding,
        "state": change.state.name(),
    })
}

/// A change in a line.
fn words(own: &Change) -> String {
    let state = match own.state {
        State::Raised => String::new(),
        State::Confirmed => ", confirmed".to_owned(),
        State::Withdrawn => ", withdrawn: the rows since do not say so any more".to_owned(),
    };
    let what = change(&own.finding).unwrap_or_else(|| own.finding.effect.replace('_', " "));
    let (robot, onset_s) = (&own.robot, own.onset_s);
    let sizes = sizes(&own.finding);
    let alike: Vec<String> = own
        .finding
        .confused_with
        .iter()
        .map(|own| own.replace('_', " "))
        .collect();
    let alike = match alike.as_slice() {
        [] => String::new(),
        all => format!("; as well {}", all.join(" or ")),
    };
    format!(
        "{:.1} s, robot {robot}{state}: since {onset_s:.1} s {what}{sizes}{alike}",
        own.t_s
    )
}

/// The numbers of a finding with their intervals.
fn sizes(finding: &Finding) -> String {
    let numbers = finding.parameters.iter().filter_map(|own| {
        let ([low, high], estimate) = (own.ci95?, own.estimate?);
        let unit = if own.unit == "1" {
            String::new()
        } else {
            format!(" {}", own.unit)
        };
        let was = own
            .nominal
            .map_or(String::new(), |was| format!(", was {was:.4}"));
        let name = own.name.replace('_', " ");
        Some(format!(
            "{name} {estimate:.4}{unit} ({low:.4} to {high:.4}{was})"
        ))
    });
    let numbers: Vec<String> = numbers.collect();
    if numbers.is_empty() {
        return String::new();
    }
    format!(" [{}]", numbers.join(", "))
}
