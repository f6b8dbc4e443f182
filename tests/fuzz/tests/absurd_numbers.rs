//! Every number that people give, at values that no robot has: it is refused in one line, or a short
//! run with it gives finite positions.

use std::path::Path;

use slipstream_bus::{Experiment, InputError, RobotModel};
use slipstream_launch::{Request, in_process, resolve};
use slipstream_recording::robot_toml;
use slipstream_sim::effects::{CATALOGUE, Domain};

/// Numbers outside of what is physical, and at the ends of the ranges that are accepted.
const ABSURD: [&str; 18] = [
    "1e300", "-1e300", "1e-300", "-1", "0", "nan", "inf", "-inf", "1e12", "1e7", "1e6", "1e4",
    "1e3", "1e-4", "1e-6", "1e-9", "1e-12", "1",
];

/// Duration of each run (s).
const SHORT_S: f64 = 0.1;

/// What became of the inputs.
#[derive(Debug, Default)]
struct Tally {
    refused: u32,
    harmless: u32,
    problems: Vec<String>,
}

impl Tally {
    /// Adds an input, and runs it if it was accepted.
    fn add(&mut self, what: &str, given: Result<Experiment, InputError>) {
        let experiment = match given {
            Ok(experiment) => experiment,
            Err(error) if error.to_string().contains('\n') => {
                return self
                    .problems
                    .push(format!("{what}: several lines: {error}"));
            }
            Err(_) => return self.refused += 1,
        };
        let reports = match in_process::run(&experiment, false) {
            Ok(reports) => reports,
            Err(error) => return self.problems.push(format!("{what}: {error}")),
        };
        let poses = reports.plant.robots.iter().map(|robot| robot.final_true);
        let odometry = reports.agents.iter().map(|agent| agent.final_odometry);
        if poses.chain(odometry).flatten().all(f64::is_finite) {
            self.harmless += 1;
        } else {
            self.problems
                .push(format!("{what}: a position is not finite"));
        }
    }

    /// All inputs were refused or harmless, and many of each kind were tried.
    fn assert_no_problems(&self) {
        assert!(self.problems.is_empty(), "{}", self.problems.join("\n"));
        assert!(self.refused > 200 && self.harmless > 200, "{self:?}");
    }
}

#[test]
fn every_number_of_an_experiment_is_refused_or_harmless() {
    let bases: [(&str, &[(&str, &str)]); 5] = [
        ("platoon", &[]),
        ("platoon", &[("control.law", "computed_torque")]),
        ("platoon", &[("control.torque_limit", "adaptive")]),
        ("platoon", &[("control.torque_limit", "outer")]),
        ("single", &[]),
    ];
    let mut tally = Tally::default();
    for (base, with) in bases {
        let request = |set: &[(&str, &str)]| Request {
            experiment: Some(base.to_owned()),
            set: set
                .iter()
                .map(|(key, value)| ((*key).to_owned(), (*value).to_owned()))
                .collect(),
            ..Request::default()
        };
        let mut common = with.to_vec();
        common.extend([("duration_s", "0.1"), ("formation.start_s", "0")]);
        for (key, value, _) in resolve(&request(&[])).unwrap().keys {
            let list = value.starts_with('[');
            if !list && value.parse::<f64>().is_err() {
                continue;
            }
            for absurd in ABSURD {
                // A short run stays short, and a run of a few robots small.
                if key == "duration_s"
                    && absurd.parse().is_ok_and(|s: f64| s > 1.0)
                    && absurd.parse().is_ok_and(|s: f64| s <= 1e6)
                {
                    continue;
                }
                let absurd = if list {
                    with_first(&value, absurd)
                } else {
                    absurd.to_owned()
                };
                let mut set = common.clone();
                set.push((&key, &absurd));
                let given = resolve(&request(&set)).map(|resolved| resolved.experiment);
                tally.add(&format!("{base} {with:?} {key}={absurd}"), given);
            }
        }
    }
    tally.assert_no_problems();
}

/// A TOML list with another first number.
fn with_first(list: &str, first: &str) -> String {
    let rest = list.find(',').map_or("]", |comma| &list[comma..]);
    format!("[{first}{rest}")
}

#[test]
fn every_number_of_a_robot_is_refused_or_harmless() {
    let mut tally = Tally::default();
    for (what, text) in robots() {
        for (line, _) in text.lines().enumerate().skip(1) {
            for (number, _) in numbers(text.lines().nth(line).unwrap()).iter().enumerate() {
                for absurd in ABSURD {
                    let changed = replace(&text, line, number, absurd);
                    let changed_line = changed.lines().nth(line).unwrap();
                    for experiment in ["single", "platoon"] {
                        let given = run_of(&changed, experiment);
                        let what = format!("{experiment}, {what}: {changed_line}");
                        tally.add(&what, given);
                    }
                }
            }
        }
    }
    tally.assert_no_problems();
}

/// A short run of robots with this model.
fn run_of(text: &str, experiment: &str) -> Result<Experiment, InputError> {
    let model = robot_toml::parse(text, Path::new("robot.toml"))?;
    let request = Request {
        experiment: Some(experiment.to_owned()),
        ..Request::default()
    };
    let mut settings = resolve(&request)?.experiment.settings;
    settings.duration_s = SHORT_S;
    settings.formation.start_s = 0.0;
    Ok(Experiment::new(settings, &model))
}

/// The paper's robot, and the robot with each effect of the catalogue.
fn robots() -> Vec<(String, String)> {
    let mut robots = vec![(
        "paper".to_owned(),
        robot_toml::to_text(&RobotModel::paper_with_slip()),
    )];
    for info in CATALOGUE {
        let alternatives = info.parameters.iter().filter(|p| p.alternative).count();
        for chosen in 0..alternatives.max(1) {
            let mut others = 0;
            let mut parameters = Vec::new();
            for parameter in info.parameters {
                let skipped = parameter.alternative && others != chosen;
                others += usize::from(parameter.alternative);
                match parameter.domain {
                    _ if skipped => {}
                    Domain::Number { lower, probes, .. } => {
                        let value = probes.first().copied().unwrap_or(lower.max(0.0));
                        parameters.push(format!("{} = {value:?}", parameter.name));
                    }
                    Domain::Text(words) => {
                        parameters.push(format!("{} = {:?}", parameter.name, words[0]));
                    }
                    Domain::List { .. } => {
                        parameters.push(format!("{} = [0.0, 1.0]", parameter.name));
                    }
                }
            }
            let slip = RobotModel::paper_with_slip();
            let base = if info.id == "wheel_slip" {
                RobotModel::default()
            } else {
                slip
            };
            let mut text = robot_toml::to_text(&base);
            if !text.contains("[effects]\n") {
                text.push_str("[effects]\n");
            }
            // Only the line of the effect is varied: the robot itself stands above.
            text.push_str(&format!("{} = {{ {} }}\n", info.id, parameters.join(", ")));
            robots.push((info.id.to_owned(), only_last_line_varies(&text)));
        }
    }
    robots
}

/// Marks all lines but the last as fixed.
fn only_last_line_varies(text: &str) -> String {
    let last = text.lines().count() - 1;
    let mark = |(line, content): (usize, &str)| {
        if line == last {
            format!("{content}\n")
        } else {
            format!("{content} # fixed\n")
        }
    };
    text.lines().enumerate().map(mark).collect()
}

/// Begin and end of every number in a line that is not fixed.
fn numbers(line: &str) -> Vec<(usize, usize)> {
    let mut found = Vec::new();
    let mut from = 0;
    while let Some(equals) = line[from..].find("= ") {
        let begin = from + equals + 2;
        let end = line[begin..]
            .find([',', ' '])
            .map_or(line.len(), |length| begin + length);
        if line[begin..end].parse::<f64>().is_ok() && !line.contains("# fixed") {
            found.push((begin, end));
        }
        from = begin;
    }
    found
}

/// The text with another value in place of a number.
fn replace(text: &str, line: usize, number: usize, value: &str) -> String {
    let change = |(i, content): (usize, &str)| {
        if i != line {
            return format!("{content}\n");
        }
        let (begin, end) = numbers(content)[number];
        format!("{}{value}{}\n", &content[..begin], &content[end..])
    };
    text.lines().enumerate().map(change).collect()
}
