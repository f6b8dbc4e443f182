//! What the run of a recording was to do, from the experiment that came with it.

use std::path::Path;

use crate::attached::attached;

/// Name of the experiment among the attachments of an MCAP file, or in a folder.
const NAME: &str = "experiment.toml";

/// What is asked of an experiment.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Experiment {
    /// Distance of a follower to the robot ahead along the path that it drove (m); `None` in open loop, where nobody follows.
    pub spacing_m: Option<f64>,
}

impl Experiment {
    /// Reads the experiment of a recording: attached to an MCAP file that slipstream wrote, or the file `experiment.toml` in a
    /// folder. `None` if there is none, or none that says the spacing.
    pub fn of(recording: &Path) -> Option<Self> {
        Self::parse(&text(recording)?)
    }

    fn parse(text: &str) -> Option<Self> {
        let keys: toml::Table = text.parse().ok()?;
        let key = |table: &str, key: &str| keys.get(table)?.get(key).cloned();
        let spacing = key("formation", "spacing_m")?;
        let whole = || spacing.as_integer().map(|own| own as f64);
        let spacing_m = spacing.as_float().or_else(whole);
        let spacing_m = spacing_m.filter(|m| m.is_finite() && *m > 0.0)?;
        let is_open_loop = key("open_loop", "enabled").and_then(|own| own.as_bool());
        Some(Self {
            spacing_m: (is_open_loop != Some(true)).then_some(spacing_m),
        })
    }
}

fn text(recording: &Path) -> Option<String> {
    if recording.is_dir() {
        return std::fs::read_to_string(recording.join(NAME)).ok();
    }
    attached(recording).ok()?.remove(NAME)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_spacing_is_read_where_robots_follow() {
        let of = |text: &str| Experiment::parse(text).map(|own| own.spacing_m);
        let keys = "formation.spacing_m = 0.6096 # built in\nopen_loop.enabled = false\n";
        assert_eq!(of(keys), Some(Some(0.6096)));
        assert_eq!(of("[formation]\nspacing_m = 1\n"), Some(Some(1.0)));
        let open_loop = "formation.spacing_m = 0.5\nopen_loop.enabled = true\n";
        assert_eq!(of(open_loop), Some(None));
        for nothing in [
            "",
            "formation.spacing_m = -1.0",
            "formation = 3",
            "=",
            "formation.spacing_m = nan",
        ] {
            assert_eq!(of(nothing), None, "{nothing}");
        }
    }
}
