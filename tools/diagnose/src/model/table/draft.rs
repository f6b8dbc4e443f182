//! A term before its parameters have their numbers: what it moves, and what it is reported as.

use crate::estimate::Prior;
use crate::estimate::term::{Acts, Attribution, Link, Search, Value};

/// Which filter reads a parameter.
#[derive(Clone, Copy)]
pub(super) enum Place {
    Reference(usize),
    Drive(usize),
}

/// One parameter of the machine.
pub(super) struct Row {
    pub(super) name: &'static str,
    pub(super) number: usize,
    pub(super) moves: Vec<(Place, f64)>,
    pub(super) prior: Prior,
    pub(super) resolution: f64,
    pub(super) repeatability: f64,
}

pub(super) fn about(deviation: f64) -> Prior {
    Prior {
        mean: 0.0,
        deviation,
        has_tails: false,
    }
}

/// Mostly within `scale` of 0, and anything at times.
pub(super) fn mostly(scale: f64) -> Prior {
    Prior {
        has_tails: true,
        ..about(scale)
    }
}

/// What rows act on.
pub(super) fn acts(rows: &[Drafted]) -> Acts {
    let mut acts = Acts::default();
    for row in rows {
        match row {
            Drafted::Run { .. } => acts.on_reference = true,
            Drafted::Machine(row) => {
                for (place, _) in &row.moves {
                    match place {
                        Place::Reference(_) => acts.on_reference = true,
                        Place::Drive(_) => acts.on_drive = true,
                    }
                }
            }
        }
    }
    acts
}

/// A parameter of a term.
pub(super) enum Drafted {
    Machine(Row),
    Run {
        name: &'static str,
        run: usize,
        place: usize,
        deviation: f64,
    },
}

/// A parameter of an effect: its name, how it changes, and weights by place among the parameters of a term.
pub(super) type Shows = (&'static str, Link, Vec<(usize, f64)>);

/// What a term is reported as.
pub(super) struct Shown {
    pub(super) effect: &'static str,
    pub(super) word: Option<(&'static str, &'static str)>,
    pub(super) run: Option<usize>,
    pub(super) values: Vec<Shows>,
    pub(super) confused: Vec<&'static str>,
    pub(super) mirror: Option<(&'static str, f64)>,
}

impl Shown {
    pub(super) fn new(effect: &'static str, values: Vec<Shows>) -> Self {
        Self {
            effect,
            word: None,
            run: None,
            values,
            confused: Vec::new(),
            mirror: None,
        }
    }

    /// A single number, the first parameter of its term.
    pub(super) fn plain(effect: &'static str, name: &'static str) -> Self {
        Self::scaled(effect, name, 1.0)
    }

    /// The same, as a number in which a unit of the parameter is so much.
    pub(super) fn scaled(effect: &'static str, name: &'static str, scale: f64) -> Self {
        Self::new(effect, vec![(name, Link::Identity, vec![(0, scale)])])
    }

    /// Factors of both wheels, from what they share and right over left.
    pub(super) fn wheels(effect: &'static str, names: [&'static str; 2]) -> Self {
        let [right, left] = names;
        Self::new(
            effect,
            vec![
                (right, Link::Log, vec![(0, 1.0), (1, 0.5)]),
                (left, Link::Log, vec![(0, 1.0), (1, -0.5)]),
            ],
        )
    }

    pub(super) fn attribution(self, parameters: &[usize]) -> Attribution {
        let mut own: Vec<usize> = Vec::new();
        let values = self.values.into_iter().map(|(name, link, weights)| {
            let weights: Vec<(usize, f64)> = weights
                .into_iter()
                .map(|(i, w)| (parameters[i], w))
                .collect();
            own.extend(weights.iter().map(|(index, _)| *index));
            Value {
                name,
                link,
                weights,
            }
        });
        let values: Vec<Value> = values.collect();
        if values.is_empty() {
            own.extend(parameters);
        }
        own.sort_unstable();
        own.dedup();
        Attribution {
            effect: self.effect,
            word: self.word,
            run: self.run,
            values,
            parameters: own,
            confused: self.confused,
            mirror: self.mirror,
        }
    }
}

/// A term before its parameters have their numbers.
pub(super) struct Draft {
    pub(super) name: &'static str,
    pub(super) rows: Vec<Drafted>,
    pub(super) shown: Vec<Shown>,
    pub(super) inflation: f64,
    pub(super) cost: f64,
    pub(super) search: Search,
    pub(super) positive: bool,
    pub(super) needs_relevance: bool,
    /// Runs from before share it only where they needed it.
    pub(super) later: bool,
    /// It is no effect, and differs between recordings.
    pub(super) varies: bool,
}

impl Draft {
    pub(super) fn new(name: &'static str, rows: Vec<Row>, shown: Vec<Shown>) -> Self {
        Self {
            name,
            rows: rows.into_iter().map(Drafted::Machine).collect(),
            shown,
            inflation: 1.0,
            cost: 0.0,
            search: Search::Smooth(Vec::new()),
            positive: false,
            needs_relevance: false,
            later: false,
            varies: false,
        }
    }

    pub(super) fn from(mut self, starts: impl IntoIterator<Item = Vec<f64>>) -> Self {
        self.search = Search::Smooth(starts.into_iter().collect());
        self
    }
}
