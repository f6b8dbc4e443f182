//! Injected delays are recovered: distributions (Kolmogorov-Smirnov test), replayed and exported round trips.

use slipstream_trace::{Fate, follow};

use crate::common::{run_json, slipstream};
use crate::helpers::messages;

/// Kolmogorov-Smirnov statistic: the largest distance between the empirical distribution of the delays and
/// `cdf`, times √n. For samples of `cdf` it exceeds 1.63 with probability 0.01.
fn kolmogorov_smirnov(mut delays_s: Vec<f64>, cdf: impl Fn(f64) -> f64) -> f64 {
    delays_s.sort_by(f64::total_cmp);
    let n = delays_s.len() as f64;
    let gap = |(i, &delay_s): (usize, &f64)| {
        let probability = cdf(delay_s);
        (probability - i as f64 / n).max((i as f64 + 1.0) / n - probability)
    };
    delays_s.iter().enumerate().map(gap).fold(0.0, f64::max) * n.sqrt()
}

/// Cumulative distribution function of the standard normal distribution, by Simpson's rule.
fn normal_cdf(z: f64) -> f64 {
    let density = |z: f64| (-z * z / 2.0).exp() / (2.0 * std::f64::consts::PI).sqrt();
    let h = (z + 9.0) / 400.0;
    let piece = |i: i32| {
        let a = -9.0 + f64::from(i) * h;
        (density(a) + 4.0 * density(a + h / 2.0) + density(a + h)) * h / 6.0
    };
    (0..400).map(piece).sum()
}

#[test]
fn each_distribution_is_recovered() {
    let (mean, sd) = (0.2_f64, 0.04_f64);
    let normal_s = |s: f64| normal_cdf((s - mean) / sd);
    let uniform_s = |s: f64| ((s - mean) / (12f64.sqrt() * sd) + 0.5).clamp(0.0, 1.0);
    let spread = (1.0 + (sd / mean).powi(2)).ln().sqrt();
    let lognormal_s = |s: f64| normal_cdf((s.ln() - mean.ln()) / spread + spread / 2.0);
    let names = ["normal", "uniform", "lognormal"];
    let cdfs: [&dyn Fn(f64) -> f64; 3] = [&normal_s, &uniform_s, &lognormal_s];
    for (i, name) in names.iter().enumerate() {
        let key = format!("links.distribution={name}");
        let arguments = [
            "--set",
            "links.protocol=periodic",
            "--set",
            "links.delay_s=0.2",
            "--set",
            "links.jitter_s=0.04",
            "--set",
            "duration_s=100",
            "--set",
            &key,
        ];
        let messages = messages(&arguments);
        let delays = messages.iter().filter_map(|message| message.delay_ns);
        let delays_s: Vec<f64> = delays.map(|ns| ns as f64 / 1e9).collect();
        assert!(delays_s.len() > 3900, "{}", delays_s.len());
        for (j, cdf) in cdfs.iter().enumerate() {
            let d = kolmogorov_smirnov(delays_s.clone(), cdf);
            assert_eq!(d < 1.63, i == j, "{name} against {}: {d}", names[j]);
        }
    }
}

#[test]
fn replayed_round_trips_give_their_halves() {
    let rtt_ms = [Some(150.0), Some(163.25), None, Some(40.5), Some(3.000002)];
    let rows = rtt_ms.iter().enumerate();
    let rows: Vec<String> = rows
        .map(|(seq, ms)| {
            format!(
                "{seq},{}",
                ms.map_or(String::new(), |ms: f64| ms.to_string())
            )
        })
        .collect();
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("rtt.csv");
    std::fs::write(&file, format!("seq,rtt_ms\n{}\n", rows.join("\n"))).unwrap();
    let key = format!("links.trace={}", file.display());
    let arguments = [
        "--set",
        "links.protocol=periodic",
        "--set",
        "links.reorder=true",
        "--set",
        &key,
        "--set",
        "duration_s=6",
    ];
    let messages = messages(&arguments);
    assert!(messages.len() > 200);
    for message in messages.iter().filter(|message| message.seq < 100) {
        let half_ns =
            rtt_ms[message.seq as usize % rtt_ms.len()].map(|ms| (ms * 5e5).round() as i64);
        assert_eq!(message.delay_ns, half_ns, "{message:?}");
        assert_eq!(message.fate == Fate::Lost, half_ns.is_none(), "{message:?}");
    }
}

/// Round trip: a run that replays the exported delays of another run has the same messages.
#[test]
fn exported_delays_replay_the_same_messages() {
    let folder = tempfile::tempdir().unwrap();
    let common = [
        "--in-process",
        "--set",
        "links.protocol=periodic",
        "--robots",
        "2",
    ];
    let impairment = [
        "--set",
        "links.delay_s=0.12",
        "--set",
        "links.jitter_s=0.05",
        "--set",
        "links.loss=0.1",
    ];
    let log = |name: &str, arguments: &[&str]| {
        run_json(
            folder.path(),
            &[&["--out", name], &common[..], arguments].concat(),
        );
        slipstream_trace::read(&folder.path().join(name))
            .unwrap()
            .log
    };
    let first = log("a.mcap", &impairment);
    let output = slipstream(folder.path(), &["trace", "a.mcap", "--rtt", "rtt.csv"]);
    assert!(output.status.success());
    let second = log("b.mcap", &["--set", "links.trace=rtt.csv", "--seed", "9"]);
    let (first, second) = (follow(&first), follow(&second));
    let lost = first
        .iter()
        .filter(|message| message.fate == Fate::Lost)
        .count();
    assert!(first.len() > 250 && lost > 10, "{} {lost}", first.len());
    assert_eq!(first, second);
}
