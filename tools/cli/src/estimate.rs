//! `--dry-run` of studies and trials: core hours, estimated from a few seconds of the work, and a number of
//! shards for the array jobs of a cluster.

use std::time::{Duration, Instant};

use crate::exit::Error;
use crate::print::print_line;

/// A shard should take about this long (s).
const SHARD_S: f64 = 900.0;
/// Options that the command line of a shard has in another form or not at all; they have values.
const REPLACED: [&str; 5] = ["--json", "--report", "--out", "--shard", "--threads"];
/// Ticks of the times in /proc (1/s).
const TICKS_PER_S: f64 = 100.0;

/// What a few pieces of the work have cost.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Sample {
    /// Number of pieces.
    pub(crate) pieces: usize,
    /// Time on cores for one piece, in the mean (s).
    pub(crate) core_s: f64,
    /// For the cheapest and the dearest piece (s).
    pub(crate) range_s: [f64; 2],
}

/// Measures `work` on the pieces in turn: `least` of them, and more until `time` has passed.
///
/// # Errors
/// The error of `work`; a system without /proc.
pub(crate) fn sample(
    pieces: impl Iterator<Item = usize>,
    least: usize,
    time: Duration,
    mut work: impl FnMut(usize) -> Result<(), Error>,
) -> Result<Sample, Error> {
    let (start, first) = (Instant::now(), core_seconds()?);
    let (mut count, mut last) = (0, first);
    let mut range_s = [f64::INFINITY, 0.0];
    for piece in pieces {
        if count >= least && start.elapsed() >= time {
            break;
        }
        work(piece)?;
        count += 1;
        let now = core_seconds()?;
        range_s = [range_s[0].min(now - last), range_s[1].max(now - last)];
        last = now;
    }
    Ok(Sample {
        pieces: count,
        core_s: (last - first) / (count.max(1) as f64),
        range_s,
    })
}

/// The indices of `count` items. The first few are spread over all.
pub(crate) fn spread(count: usize) -> Vec<usize> {
    const GOLDEN_RATIO: f64 = 0.618_033_988_749_895;
    let mut indices: Vec<usize> = (0..count).collect();
    // The multiples of the golden ratio, modulo 1, fill the largest gap between those before them.
    let key = |index: &usize| ((*index as f64 + 1.0) * GOLDEN_RATIO).fract();
    indices.sort_by(|one, other| key(one).total_cmp(&key(other)));
    // The rank of each multiple is the item that it stands for.
    let mut order = vec![0; count];
    for (rank, index) in indices.into_iter().enumerate() {
        order[index] = rank;
    }
    order
}

/// Work that can be divided into shards.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Work {
    /// Number of pieces, and what they are called.
    pub(crate) pieces: usize,
    pub(crate) name: &'static str,
    /// The largest number of shards.
    pub(crate) divisible_by: usize,
    /// Threads of one shard.
    pub(crate) threads: usize,
}

/// Prints core hours, number of shards and the command line of the first. `more` are its further arguments.
pub(crate) fn print(work: Work, sample: Sample, more: &str) {
    let core_s = sample.core_s * work.pieces as f64;
    // Ticks do not resolve less.
    let range = match sample.range_s {
        [least, most] if sample.pieces > 1 && least > 10.0 / TICKS_PER_S => {
            format!(" ({} to {} s)", digits(least), digits(most))
        }
        _ => String::new(),
    };
    print_line!(
        "About {} core hours: an estimate from {} of the {}, {} s each{range} on one core of this machine.",
        digits(core_s / 3600.0),
        sample.pieces,
        work.name,
        digits(sample.core_s)
    );
    let threads = work.threads.max(1) as f64;
    let shards = (core_s / threads / SHARD_S).ceil() as usize;
    let shards = shards.clamp(1, work.divisible_by.max(1));
    let minutes = core_s / threads / 60.0 / shards as f64;
    let of_cores = match work.threads {
        0 | 1 => "one core".to_owned(),
        threads => format!("{threads} cores"),
    };
    let (noun, each) = if shards == 1 {
        ("shard", "")
    } else {
        ("shards", " each")
    };
    print_line!(
        "{shards} {noun} of about {} minutes{each} on {of_cores}. The first:",
        digits(minutes)
    );
    let words = shard_words(std::env::args().skip(1));
    print_line!("slipstream {words}{more} --shard 1/{shards} --json shard-1.json");
}

/// The words of this command line that a shard has too.
fn shard_words(arguments: impl Iterator<Item = String>) -> String {
    let mut words = Vec::new();
    let mut is_value = false;
    for word in arguments {
        let joined = |option: &&str| word.starts_with(&format!("{option}="));
        if std::mem::take(&mut is_value) || word == "--dry-run" || REPLACED.iter().any(joined) {
            continue;
        }
        is_value = REPLACED.contains(&word.as_str());
        if !is_value {
            words.push(quoted(&word));
        }
    }
    words.join(" ")
}

/// A word as a shell reads it.
fn quoted(word: &str) -> String {
    let is_plain = |c: char| c.is_ascii_alphanumeric() || "-_./,=:+@%".contains(c);
    if !word.is_empty() && word.chars().all(is_plain) {
        word.to_owned()
    } else {
        format!("'{}'", word.replace('\'', "'\\''"))
    }
}

/// A number with two digits that count.
fn digits(value: f64) -> String {
    let after_point = (1.0 - value.abs().max(1e-9).log10().floor()).clamp(0.0, 4.0) as usize;
    format!("{value:.after_point$}")
}

/// Time on cores of this process and of its children that have ended (s).
fn core_seconds() -> Result<f64, Error> {
    let path = "/proc/self/stat";
    let text =
        std::fs::read_to_string(path).map_err(|error| Error::Failed(format!("{path}: {error}")))?;
    // The name of the program, in parentheses, may contain spaces. After it stand the state and ten more
    // fields, then the times of user and system, and those of the children.
    let after_name = text.rsplit(')').next().unwrap_or_default();
    let times = after_name.split_whitespace().skip(11).take(4);
    let ticks: f64 = times.filter_map(|ticks| ticks.parse::<f64>().ok()).sum();
    Ok(ticks / TICKS_PER_S)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn items_are_spread_and_complete() {
        let order = spread(100);
        let mut sorted = order.clone();
        sorted.sort_unstable();
        assert_eq!(sorted, (0..100).collect::<Vec<_>>());
        let mut first = order[..5].to_vec();
        first.sort_unstable();
        let gaps = first.windows(2).map(|pair| pair[1] - pair[0]);
        assert!(gaps.clone().all(|gap| gap > 10), "{first:?}");
        assert!(spread(0).is_empty());
    }

    #[test]
    fn the_command_line_of_a_shard_keeps_what_matters() {
        let line = "study delay --dry-run --delay 0,0.1 --json all.json --report=a.html --threads 4 --force";
        let words = line.split(' ').map(str::to_owned);
        assert_eq!(shard_words(words), "study delay --delay 0,0.1 --force");
        assert_eq!(quoted("it's"), "'it'\\''s'");
    }

    #[test]
    fn work_costs_core_time() {
        let busy = |_| {
            let start = Instant::now();
            let mut sum = 0u64;
            while start.elapsed() < Duration::from_millis(100) {
                sum = std::hint::black_box(sum + 1);
            }
            Ok(())
        };
        let sample = sample(0..9, 3, Duration::from_millis(1), busy).unwrap();
        assert_eq!(sample.pieces, 3);
        // Other processes may take the core meanwhile; other tests may run in this one.
        assert!(sample.core_s > 0.005, "{sample:?}");
    }

    #[test]
    fn numbers_have_two_digits() {
        let text = [12.34, 0.0123, 1234.0, 0.0].map(digits);
        assert_eq!(text, ["12", "0.012", "1234", "0.0000"]);
    }
}
