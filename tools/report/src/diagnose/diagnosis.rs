//! What the page of a diagnosis shows, and the answer in one sentence.

use slipstream_answer::{Answer, Figures, Finding, Verdict};
use slipstream_bus::RobotModel;
use slipstream_recording::Recording;

use super::errors::reached;
use super::headline::{are_alike, headline};
use crate::parts::{Fact, capital};

/// Effects that the sentence names, and the share of the error that each has to take away.
const NAMED: usize = 3;
const LEAST_SHARE: f64 = 0.01;
/// What the page shows.
pub struct Diagnosis<'a> {
    /// Names of the recordings.
    pub subject: String,
    /// The answer.
    pub answer: &'a Answer,
    /// The figures of each machine.
    pub figures: &'a [Figures],
    /// What was diagnosed.
    pub recordings: &'a [Recording],
    /// The nominal model of each robot.
    pub model_of: &'a dyn Fn(&str) -> Option<RobotModel>,
    /// The improved model of each robot.
    pub improved: &'a [(String, RobotModel)],
    /// The command that made the answer.
    pub command_line: String,
    /// Program, files and origin, as the caller knows them.
    pub facts: Vec<Fact>,
}

impl Diagnosis<'_> {
    pub(super) fn model(&self, robot: &str) -> Option<RobotModel> {
        let own = || {
            let mut with = self
                .recordings
                .iter()
                .filter(|own| own.robot(robot).is_some());
            with.find_map(|own| own.model.clone())
        };
        (self.model_of)(robot)
            .or_else(own)
            .or_else(|| self.recordings.iter().find_map(|own| own.model.clone()))
    }

    /// Robots of the answer, in the order of the figures.
    pub(super) fn robots(&self) -> Vec<&str> {
        let mut robots: Vec<&str> = Vec::new();
        let drawn = self.figures.iter().map(|own| own.robot.as_str());
        let channels = self
            .answer
            .held_out
            .channels
            .iter()
            .map(|own| own.robot.as_str());
        for robot in drawn.chain(channels) {
            if !robots.contains(&robot) {
                robots.push(robot);
            }
        }
        robots
    }

    /// Findings in the order in which they are numbered: those that take most error away first.
    pub(super) fn numbered(&self) -> Vec<(usize, usize, &Finding)> {
        let mut order: Vec<(usize, &Finding)> = self.answer.findings.iter().enumerate().collect();
        order.sort_by(|a, b| self.share(b.1).total_cmp(&self.share(a.1)));
        let numbered = order.into_iter().enumerate();
        numbered
            .map(|(place, (index, finding))| (place + 1, index, finding))
            .collect()
    }

    /// Share of the error that a finding takes away, of position or heading.
    fn share(&self, finding: &Finding) -> f64 {
        let own = self
            .answer
            .budget
            .iter()
            .filter(|own| own.robot == finding.robot);
        let parts = own.filter_map(|own| {
            let part = own.part_of(&finding.effect)?;
            Some(part.share / own.before.max(1e-300))
        });
        parts.fold(0.0, f64::max)
    }

    /// Whether it is told what changed since other recordings.
    fn is_compared(&self) -> bool {
        !self.answer.against.is_empty()
    }

    /// Findings that say the same together, those that take most error away first.
    fn groups(&self) -> Vec<Vec<&Finding>> {
        let mut groups: Vec<Vec<&Finding>> = Vec::new();
        for (_, _, finding) in self.numbered() {
            let model = self.model(&finding.robot);
            let changed =
                |own: &Finding| slipstream_answer::change(own).filter(|_| self.is_compared());
            let alike = |own: &&mut Vec<&Finding>| {
                are_alike([own[0], finding], model.as_ref()) && changed(own[0]) == changed(finding)
            };
            match groups.iter_mut().find(alike) {
                Some(group) => group.push(finding),
                None => groups.push(vec![finding]),
            }
        }
        groups
    }

    /// On which robots, or in which runs, the findings of a group hold; empty where there is one of each.
    fn whose(&self, group: &[&Finding]) -> String {
        let robots = distinct(group.iter().map(|own| own.robot.as_str()));
        let runs = distinct(
            group
                .iter()
                .flat_map(|own| own.runs.iter().flatten())
                .map(String::as_str),
        );
        let named = |word: &str, all: &[&str]| match all {
            [one] => format!("{word} {one}, "),
            [one, other] => format!("{word} {one} and {other}, "),
            [one, rest @ ..] => format!("{word} {one} and {} more, ", rest.len()),
            [] => String::new(),
        };
        if !runs.is_empty() {
            named("in", &runs)
        } else if self.robots().len() > 1 {
            named("on", &robots)
        } else {
            String::new()
        }
    }

    /// The answer in one sentence.
    pub(super) fn sentence(&self) -> String {
        let mut groups = self.groups();
        // what takes hardly any error away is not the answer where something else is
        let counts = |group: &Vec<&Finding>| group.iter().any(|own| self.share(own) >= LEAST_SHARE);
        if groups.iter().any(counts) {
            groups.retain(counts);
        }
        let mut words: Vec<String> = groups
            .iter()
            .take(NAMED)
            .map(|group| {
                let changed = Some(group[0]).filter(|_| self.is_compared());
                let words = changed.and_then(slipstream_answer::change);
                self.whose(group)
                    + &words
                        .unwrap_or_else(|| headline(group, self.model(&group[0].robot).as_ref()))
            })
            .collect();
        if groups.len() > NAMED {
            words.push(format!("{} more", groups.len() - NAMED));
        }
        let before = listed(&self.answer.against);
        match (words.as_slice(), self.answer.verdict) {
            ([], Verdict::Match) if !before.is_empty() => {
                format!("Nothing changed since {before} beyond what its data show of themselves.")
            }
            (_, _) if !before.is_empty() && !words.is_empty() => {
                format!("Since {before}: {}.", listed(&words))
            }
            ([], Verdict::Match) => match reached(self.answer) {
                Some(text) => format!("The model matches: 5 s ahead it misses by {text}."),
                None => self.answer.statement.clone() + ".",
            },
            ([], _) => self.answer.statement.clone() + ".",
            _ => capital(&listed(&words)) + ".",
        }
    }
}

/// Texts without repetition.
fn distinct<'a>(texts: impl Iterator<Item = &'a str>) -> Vec<&'a str> {
    let mut own: Vec<&str> = Vec::new();
    for text in texts {
        if !own.contains(&text) {
            own.push(text);
        }
    }
    own
}

/// Words with commas, and an "and" before the last.
pub(super) fn listed(words: &[String]) -> String {
    match words {
        [] => String::new(),
        [one] => one.clone(),
        [one, other] => format!("{one}, and {other}"),
        [all @ .., last] => format!("{}, and {last}", all.join(", ")),
    }
}
