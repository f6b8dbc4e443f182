//! What begins at a time in a run: an effect of a robot, another delay of a link.

use super::change_table::ChangeTable;
use super::parameters::ParameterValue;
use super::settings::Settings;
use super::topology::Topology;
use crate::error::InputError;
use crate::message::{RobotIndex, robot_name};
use crate::range::{self, invalid, within};
use crate::robot::{EffectSpec, Parameter};
use crate::time::ns_from_s;

/// What begins at a time.
#[derive(Debug, Clone, PartialEq)]
pub struct Change {
    /// When (ns).
    pub at_ns: i64,
    /// What.
    pub what: Begins,
}

/// What begins.
#[derive(Debug, Clone, PartialEq)]
pub enum Begins {
    /// An effect of a robot.
    Effect(RobotIndex, EffectSpec),
    /// Another mean delay of a link, by sender and receiver (ns).
    Delay([RobotIndex; 2], i64),
}

impl Settings {
    /// What begins within the run, in the order of time.
    ///
    /// # Errors
    /// The first table that no run can have. Effects and their parameters are not known here.
    pub fn changes_in_time(&self) -> Result<Vec<Change>, InputError> {
        let topology = Topology::of(self);
        let tables = self.changes.iter().enumerate();
        let read = tables.map(|(number, table)| {
            let own = table.read(self, &topology);
            own.map_err(|error| InputError {
                place: "changes".to_owned(),
                problem: format!("entry {}: {} {}", number + 1, error.place, error.problem),
                ..error
            })
        });
        let mut changes: Vec<Change> = read.collect::<Result<_, _>>()?;
        changes.sort_by_key(|own| own.at_ns);
        Ok(changes)
    }

    /// How much later than others messages of a link come: from when on, and by how much beside `links.delay_s` (ns).
    pub fn later_ns(&self, link: [RobotIndex; 2]) -> Vec<(i64, i64)> {
        let usual_ns = ns_from_s(self.links.delay_s);
        let changes = self.changes_in_time().unwrap_or_default().into_iter();
        let own = changes.filter_map(|own| match own.what {
            Begins::Delay(known, delay_ns) if known == link => {
                Some((own.at_ns, delay_ns - usual_ns))
            }
            _ => None,
        });
        own.collect()
    }

    /// How much longer a token round may take by changes of links (ns).
    pub(super) fn longer_round_ns(&self) -> i64 {
        let usual_ns = ns_from_s(self.links.delay_s);
        let changes = self.changes_in_time().unwrap_or_default().into_iter();
        let longer = changes.map(|own| match own.what {
            Begins::Delay(_, delay_ns) => (delay_ns - usual_ns).max(0),
            Begins::Effect(..) => 0,
        });
        longer.sum()
    }
}

impl ChangeTable {
    fn read(&self, settings: &Settings, topology: &Topology) -> Result<Change, InputError> {
        let at_s = self.number("at_s", "give the time in s at which it begins")?;
        if !(0.0..settings.duration_s).contains(&at_s) {
            let remedy = format!("give a time before the end, {} s", settings.duration_s);
            return invalid("at_s", format!("is {at_s}"), remedy);
        }
        let what = match (
            self.entries().contains_key("robot"),
            self.entries().contains_key("link"),
        ) {
            (true, false) => self.effect(settings)?,
            (false, true) => self.delay(settings, topology)?,
            _ => {
                let remedy = "give robot and effect, or link and delay_s";
                return invalid("robot, link", "one of them is needed", remedy);
            }
        };
        let at_ns = ns_from_s(at_s);
        Ok(Change { at_ns, what })
    }

    fn effect(&self, settings: &Settings) -> Result<Begins, InputError> {
        let robot = index(settings, "robot", self.text("robot", "give r1 or another")?)?;
        let effect = self.text("effect", "give one; `slipstream effects` lists all")?;
        let others = self.entries().iter();
        let others = others.filter(|(key, _)| !["at_s", "robot", "effect"].contains(&key.as_str()));
        let parameters = others.map(|(key, value)| match value {
            ParameterValue::Number(number) => Ok((key.clone(), Parameter::Number(*number))),
            ParameterValue::Integer(whole) => Ok((key.clone(), Parameter::Number(*whole as f64))),
            ParameterValue::Text(text) => Ok((key.clone(), Parameter::Text(text.clone()))),
            ParameterValue::Numbers(all) => Ok((key.clone(), Parameter::List(all.clone()))),
            ParameterValue::Bool(own) => invalid(
                key,
                format!("is {own}"),
                "give a number, a text or a list of numbers",
            ),
        });
        let spec = EffectSpec {
            effect: effect.to_owned(),
            parameters: parameters.collect::<Result<_, _>>()?,
        };
        Ok(Begins::Effect(robot, spec))
    }

    fn delay(&self, settings: &Settings, topology: &Topology) -> Result<Begins, InputError> {
        let known = ["at_s", "link", "delay_s"];
        if let Some(key) = self
            .entries()
            .keys()
            .find(|own| !known.contains(&own.as_str()))
        {
            return invalid(key, "is not a key of a link", "give link and delay_s");
        }
        let form = "give sender and receiver, such as \"r1 to r2\"";
        let link = self.text("link", form)?;
        let Some((from, to)) = link.split_once(" to ") else {
            return invalid("link", format!("is \"{link}\""), form);
        };
        let [from, to] = [from, to].map(|name| index(settings, "link", name.trim()));
        let (from, to) = (from?, to?);
        if !topology.is_link(from, to) {
            let problem = format!("is \"{link}\", which is no link of the run");
            return invalid("link", problem, "give one that links.topology has");
        }
        let delay_s = self.number("delay_s", "give the delay from then on, in s")?;
        within("delay_s", delay_s, range::DELAY_S)?;
        Ok(Begins::Delay([from, to], ns_from_s(delay_s)))
    }
}

/// The robot of this name.
fn index(settings: &Settings, key: &str, name: &str) -> Result<RobotIndex, InputError> {
    let robots = settings.robots.count;
    let found = (0..robots).find(|robot| robot_name(*robot) == name);
    found.map_or_else(
        || {
            let problem = format!("names \"{name}\", which is no robot of the run");
            invalid(
                key,
                problem,
                format!("give r1 to {}", robot_name(robots - 1)),
            )
        },
        Ok,
    )
}

#[cfg(test)]
mod tests {
    use super::super::parameters::Parameters;
    use super::*;

    fn settings(tables: &[&[(&str, ParameterValue)]]) -> Settings {
        let table = |own: &&[(&str, ParameterValue)]| {
            let own = own.iter();
            ChangeTable::from(
                own.map(|(key, value)| ((*key).to_owned(), value.clone()))
                    .collect::<Parameters>(),
            )
        };
        Settings {
            changes: tables.iter().map(table).collect(),
            ..Settings::default()
        }
    }

    fn text(own: &str) -> ParameterValue {
        ParameterValue::Text(own.to_owned())
    }

    #[test]
    fn changes_are_in_the_order_of_time() {
        let number = ParameterValue::Number;
        let settings = settings(&[
            &[
                ("at_s", number(9.0)),
                ("link", text("r1 to r2")),
                ("delay_s", number(0.2)),
            ],
            &[
                ("at_s", ParameterValue::Integer(4)),
                ("robot", text("r3")),
                ("effect", text("payload")),
                ("mass_kg", number(1.0)),
            ],
        ]);
        let changes = settings.changes_in_time().unwrap();
        let payload = EffectSpec::new("payload", &[("mass_kg", 1.0)]);
        assert_eq!(changes[0].what, Begins::Effect(2, payload));
        assert_eq!(changes[1].at_ns, 9_000_000_000);
        assert_eq!(settings.later_ns([0, 1]), [(9_000_000_000, 200_000_000)]);
        assert_eq!(settings.later_ns([1, 2]), []);
        assert_eq!(settings.longer_round_ns(), 200_000_000);
        assert_eq!(settings.validate(), Ok(()));
    }

    #[test]
    fn what_no_run_can_have_is_said_with_a_remedy() {
        let number = ParameterValue::Number;
        let link = |own: &str| {
            vec![
                ("at_s", number(9.0)),
                ("link", text(own)),
                ("delay_s", number(0.2)),
            ]
        };
        let cases: [(&str, Vec<(&str, ParameterValue)>); 9] = [
            ("at_s is missing", vec![("robot", text("r1"))]),
            ("at_s is 99", vec![("at_s", number(99.0))]),
            ("robot, link one of them", vec![("at_s", number(1.0))]),
            (
                "effect is missing",
                vec![("at_s", number(1.0)), ("robot", text("r1"))],
            ),
            (
                "robot names \"r9\"",
                vec![("at_s", number(1.0)), ("robot", text("r9"))],
            ),
            ("link is \"r1\"", link("r1")),
            ("link names \"r7\"", link("r7 to r2")),
            ("link is \"r1 to r3\", which is no link", link("r1 to r3")),
            (
                "loss is not a key",
                [link("r1 to r2"), vec![("loss", number(0.1))]].concat(),
            ),
        ];
        for (problem, table) in cases {
            let error = settings(&[&table]).validate().unwrap_err();
            assert_eq!(error.place, "changes");
            let begin = format!("entry 1: {problem}");
            assert!(error.problem.starts_with(&begin), "{}", error.problem);
            assert!(!error.remedy.is_empty());
        }
    }
}
