//! A number of a finding as it is typed: as many digits as its interval lets count, and what it was.

use crate::{Finding, ParameterEstimate, in_digits};

/// A number of a finding.
#[derive(Debug, Clone, Copy)]
pub(super) struct Quantity {
    /// What it is now.
    pub(super) value: f64,
    /// Where it lies with 95 % confidence.
    pub(super) interval: [f64; 2],
    /// What it was before.
    pub(super) was: Option<f64>,
}

impl Quantity {
    /// The number `name` of a finding.
    pub(super) fn of(finding: &Finding, name: &str) -> Option<Self> {
        let own = finding.parameters.iter().find(|own| own.name == name)?;
        Self::estimated(own)
    }

    fn estimated(own: &ParameterEstimate) -> Option<Self> {
        let value = own.estimate?;
        Some(Self {
            value,
            interval: own.ci95.unwrap_or([value; 2]),
            was: own.nominal,
        })
    }

    /// Whether it is another than before, beyond its interval; than zero, where it was not known.
    pub(super) fn differs(&self) -> bool {
        let [low, high] = self.interval;
        let was = self.was.unwrap_or(0.0);
        !(low..=high).contains(&was)
    }

    /// What a monotonic function makes of it.
    pub(super) fn map(self, of: impl Fn(f64) -> f64) -> Self {
        let [a, b] = self.interval.map(&of);
        Self {
            value: of(self.value),
            interval: [a.min(b), a.max(b)],
            was: self.was.map(of),
        }
    }

    /// `value` with the digits of this number.
    pub(super) fn write(self, value: f64) -> String {
        let [text, ..] = in_digits(value, self.interval);
        // no minus in front of nothing
        let is_zero = text.bytes().all(|byte| matches!(byte, b'-' | b'0' | b'.'));
        if is_zero {
            text.trim_start_matches('-').to_owned()
        } else {
            text
        }
    }

    /// The number now.
    pub(super) fn now(self) -> String {
        self.write(self.value)
    }

    /// The number now, with three digits that count even where its interval is wider: in a model, numbers have to
    /// fit each other.
    fn precise(self) -> String {
        let order = self.value.abs().log10().floor();
        let least = if order.is_finite() {
            (2.0 - order).clamp(0.0, 9.0) as usize
        } else {
            0
        };
        let now = self.now();
        let digits = now.split_once('.').map_or(0, |(_, behind)| behind.len());
        if digits < least {
            format!("{:.least$}", self.value)
        } else {
            now
        }
    }

    /// The number now, and what it was where that reads otherwise.
    pub(super) fn text(self) -> String {
        self.text_with(&|own| own)
    }

    /// The same of a text that is made of the number.
    pub(super) fn text_with(self, words: &dyn Fn(String) -> String) -> String {
        let now = words(self.now());
        let was = self.was.map(|was| words(self.write(was)));
        match was.filter(|was| *was != now) {
            Some(was) => format!("{now} (was {was})"),
            None => now,
        }
    }
}

/// A finding as a line of `[effects]` in robot.toml; `None` where a number is missing.
fn toml_line(finding: &Finding) -> Option<String> {
    let info = slipstream_sim::effects::find(&finding.effect)?;
    let pairs: Option<Vec<String>> = finding
        .parameters
        .iter()
        .map(|own| match &own.text {
            Some(word) => Some(format!("{} = \"{word}\"", own.name)),
            None => Some(format!(
                "{} = {}",
                own.name,
                Quantity::estimated(own)?.precise()
            )),
        })
        .collect();
    let pairs = pairs.filter(|own| !own.is_empty())?.join(", ");
    Some(if info.repeats {
        format!("{} = [{{ {pairs} }}]", info.id)
    } else {
        format!("{} = {{ {pairs} }}", info.id)
    })
}

/// The action that puts a finding into a model.
pub(super) fn into_model(finding: &Finding) -> Option<String> {
    let line = toml_line(finding)?;
    Some(format!("set {line} in [effects] of robot.toml"))
}
