//! A term: physics that a model has or not, and what it is reported as.

/// How a parameter of the catalogue changes with what is fitted.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Link {
    /// What is fitted is added.
    Identity,
    /// What is fitted is the logarithm of a factor.
    Log,
    /// What is fitted is the logarithm of what a share leaves.
    LogLoss,
}

/// A parameter of the catalogue as a sum of fitted ones.
#[derive(Debug, Clone)]
pub(crate) struct Value {
    pub(crate) name: &'static str,
    pub(crate) link: Link,
    /// Fitted parameters with their weights.
    pub(crate) weights: Vec<(usize, f64)>,
}

/// An effect of the catalogue that a term is reported as.
#[derive(Debug, Clone)]
pub(crate) struct Attribution {
    pub(crate) effect: &'static str,
    /// A parameter that is a word, and the word.
    pub(crate) word: Option<(&'static str, &'static str)>,
    /// The run for which it holds; all without it.
    pub(crate) run: Option<usize>,
    pub(crate) values: Vec<Value>,
    /// Fitted parameters that it explains.
    pub(crate) parameters: Vec<usize>,
    /// Effects that move the same streams by the same amounts: no recording of this kind tells them apart.
    pub(crate) confused: Vec<&'static str>,
    /// The effect that it is when its value is negative, and the sign of that effect's value.
    pub(crate) mirror: Option<(&'static str, f64)>,
}

/// Which part of a likelihood a term acts on: it has to be of use for the predictions of one of them.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub(crate) struct Acts {
    pub(crate) on_reference: bool,
    pub(crate) on_drive: bool,
}

/// How a term is searched.
#[derive(Debug, Clone, PartialEq)]
pub(crate) enum Search {
    /// By score and Fisher information from the values of the model without it, and from these starts.
    Smooth(Vec<Vec<f64>>),
    /// By trying values, which rise: the likelihood has no derivative by it.
    Profiled(Vec<f64>),
    /// From where the likelihood finds that it may act: at one place, at one time, or when something gives way.
    Located,
}

/// Physics that is there or not.
#[derive(Debug, Clone)]
pub(crate) struct Term {
    /// Its name among all terms.
    pub(crate) name: &'static str,
    /// Its parameters.
    pub(crate) parameters: Vec<usize>,
    /// Variance of each below which integrators or conventions of stamps differ.
    pub(crate) resolution: Vec<f64>,
    /// Variance of each by which two recordings of one unchanged machine differ.
    pub(crate) repeatability: Vec<f64>,
    /// Inflation of its standard errors: what wanders more slowly than a block is seen by no jackknife.
    pub(crate) inflation: f64,
    /// Prior log-odds against it (nats), beside terms that fit as well.
    pub(crate) cost: f64,
    pub(crate) search: Search,
    /// Most robots have it: one search begins with everything usual.
    pub(crate) usual: bool,
    /// Where it does nothing it has no derivative: what it would do begins at its first start.
    pub(crate) kinked: bool,
    /// It cannot be negative.
    pub(crate) positive: bool,
    /// It acts all the time: it has to be of use for predictions.
    pub(crate) needs_relevance: bool,
    /// It acts at moments: its gain decides, not how blocks of time agree.
    pub(crate) rare: bool,
    pub(crate) acts: Acts,
    /// What it is reported as; nothing of a nuisance.
    pub(crate) shown: Vec<Attribution>,
}

impl Term {
    /// Whether it was set by trying values, and its gain alone decides.
    pub(crate) fn is_profiled(&self) -> bool {
        matches!(self.search, Search::Profiled(_))
    }

    /// Whether its gain alone decides.
    pub(crate) fn is_decided_by_gain(&self) -> bool {
        self.is_profiled() || self.rare
    }

    /// Whether the likelihood has a derivative by it where it does nothing.
    pub(crate) fn is_smooth(&self) -> bool {
        matches!(self.search, Search::Smooth(_))
    }

    /// Whether it is no effect.
    pub(crate) fn is_nuisance(&self) -> bool {
        self.shown.is_empty()
    }
}
