//! Runs across hosts: what the clocks of the hosts leave open, against stamps of one true clock.

#![expect(clippy::unwrap_used, clippy::panic, reason = "helpers of tests")]

mod chance;

use std::collections::BTreeMap;

use chance::Chance;
use slipstream_bus::record::Fate as LinkFate;
use slipstream_trace::{
    Chain, Clock, Fate, LatencyAnswer, Log, Step, TracedMessage, Uncertainty, against, answer,
    follow, timeline,
};

/// The links: from the plant's host to b, within b, from b to c, and back to the plant's host.
const LINKS: [(u32, u32); 4] = [(0, 1), (1, 2), (2, 3), (3, 0)];
/// The host of each robot; 0 is the plant's.
const HOST_OF: [usize; 4] = [0, 1, 1, 2];
/// Names of the hosts.
const NAMES: [&str; 3] = ["", "b", "c"];
/// Time between two messages (ns).
const PERIOD_NS: i64 = 50_000_000;
/// Messages between two records of a clock.
const WINDOW: u32 = 20;
/// Messages of a run.
const MESSAGES: u32 = 1200;

impl Chance {
    /// Between the ends, which are drawn as often as all between them.
    fn within(&mut self, largest: i64) -> i64 {
        match self.below(4) {
            0 => largest,
            1 => -largest,
            _ => self.below(2 * largest + 1) - largest,
        }
    }
}

/// What a host's clock is known to, from one second to the next.
struct Known {
    records: Vec<Clock>,
}

impl Known {
    /// Records of 0.01 ms to 0.5 ms of error; the first is before the start.
    fn new(chance: &mut Chance) -> Self {
        let record = |k: u32| {
            let bound_ns = 10_000 + chance.below(240_000);
            Clock {
                t_ns: i64::from(k * WINDOW) * PERIOD_NS - 1_000_000,
                offset_ns: 1_000_000_000_000 + i64::from(k) * 12_000,
                bound_ns,
                drift_ppb: (k > 2).then_some(12_000 + i64::from(k)),
                round_trip_ns: 90_000 + chance.below(100_000),
                error_ns: bound_ns + chance.below(250_000),
            }
        };
        Self {
            records: (0..=MESSAGES / WINDOW).map(record).collect(),
        }
    }

    /// The largest error of a stamp while message `seq` is under way: no record is at that time.
    fn error_ns(&self, seq: u32) -> i64 {
        let before = (seq / WINDOW) as usize;
        let pair = &self.records[before..=before + 1];
        pair.iter().map(|clock| clock.error_ns).max().unwrap()
    }
}

/// The true instants of a message, from the encoder sample to the torque (ns).
fn instants(seq: u32, chance: &mut Chance) -> [i64; 8] {
    let mut now_ns = i64::from(seq) * PERIOD_NS + 1_000_000;
    // The longest transport is shorter than what the clocks tell apart at worst.
    [9, 5, 200, 40, 15_000, 15_000, 12_000, 300].map(|limit_us| {
        now_ns += chance.below(limit_us * 1000);
        now_ns
    })
}

/// The steps of a message whose stamps are wrong by `errors_ns` on the three hosts.
fn steps(seq: u32, instants_ns: [i64; 8], errors_ns: [i64; 3], is_apart: bool) -> Vec<Step> {
    let (from, to) = LINKS[(seq % 4) as usize];
    let due_ns = i64::from(seq) * PERIOD_NS;
    let [sender_ns, receiver_ns] = [from, to].map(|robot| errors_ns[HOST_OF[robot as usize]]);
    let [sampled_ns, tick_ns, sent_ns, queued_ns, rest @ ..] = instants_ns;
    let [available_ns, outer_ns, inner_ns, applied_ns] = rest;
    let crosses = is_apart && HOST_OF[from as usize] != HOST_OF[to as usize];
    let outer = |robot, began_ns, message| Step::Outer {
        robot,
        due_ns,
        began_ns,
        done_ns: began_ns,
        message,
    };
    let crossed = Step::Crossed {
        from,
        to,
        seq,
        t_ns: queued_ns + receiver_ns,
    };
    let mut steps = vec![
        outer(from, tick_ns + sender_ns, None),
        outer(to, outer_ns + receiver_ns, Some(seq)),
        Step::Sent {
            from,
            to,
            seq,
            sampled_ns,
            tick_ns: due_ns,
            sent_ns: sent_ns + sender_ns,
            // The bus of the sender's host does not know when a message is through the network.
            queued_ns: if crosses { sent_ns } else { queued_ns } + sender_ns,
        },
        Step::Arrived {
            from,
            to,
            seq,
            available_ns: Some(available_ns + receiver_ns),
        },
        Step::Taken {
            from,
            to,
            seq,
            tick_ns: due_ns,
            fate: LinkFate::Used,
        },
        Step::Inner {
            robot: to,
            due_ns: due_ns + 1,
            began_ns: inner_ns + receiver_ns,
            done_ns: inner_ns + receiver_ns,
            outer_ns: due_ns,
        },
        Step::Applied {
            robot: to,
            tick_ns: due_ns + 1,
            taken_ns: applied_ns,
        },
    ];
    steps.extend(crosses.then_some(crossed));
    steps
}

/// Where the agents of the robots run.
fn placed() -> impl Iterator<Item = Step> {
    (0..)
        .zip(HOST_OF)
        .filter(|(_, host)| *host > 0)
        .map(|(robot, host)| Step::Host {
            robot,
            host: NAMES[host].to_owned(),
        })
}

/// A run: its steps as the hosts stamp them, and as one true clock would.
struct Run {
    /// Without hosts and their clocks.
    stamped: Vec<Step>,
    hosts: Vec<Step>,
    truth: Log,
}

impl Run {
    /// `way`: seed of the true instants; `clocks`: seed of the clocks.
    fn new(way: u64, clocks: u64) -> Self {
        let (mut way, mut chance) = (Chance(way), Chance(clocks));
        let known = [(); 2].map(|()| Known::new(&mut chance));
        let (mut stamped, mut truth) = (Vec::new(), Log::default());
        for seq in 0..MESSAGES {
            let instants_ns = instants(seq, &mut way);
            let [b, c] = [0, 1].map(|host: usize| chance.within(known[host].error_ns(seq)));
            stamped.extend(steps(seq, instants_ns, [0, b, c], true));
            let exact = steps(seq, instants_ns, [0; 3], false);
            exact.into_iter().for_each(|step| truth.take(step));
        }
        let clock = |(host, clock): (&&str, Clock)| Step::Clock {
            host: (*host).to_owned(),
            clock,
        };
        let clocks = NAMES[1..].iter().zip(known);
        let clocks =
            clocks.flat_map(|(host, known)| known.records.into_iter().map(move |r| (host, r)));
        Self {
            stamped,
            hosts: placed().chain(clocks.map(clock)).collect(),
            truth,
        }
    }

    fn log(&self) -> Log {
        Log::new(self.hosts.iter().chain(&self.stamped).cloned())
    }
}

/// The chain of a message that was used.
fn chain(message: &TracedMessage) -> Chain {
    match message.fate {
        Fate::Used(chain) => chain,
        other => panic!("{message:?}: {other:?}"),
    }
}

/// What is left open of a stage (ns).
fn ns(uncertainty: Uncertainty) -> i64 {
    match uncertainty {
        Uncertainty::Exact => 0,
        Uncertainty::Within(ns) => ns,
        Uncertainty::Unknown => panic!("the clocks are known"),
    }
}

/// For every message the true stage is within the stage ± its uncertainty, which is reached; the sum of the
/// stages is exact.
#[test]
fn the_true_stage_is_within_the_uncertainty() {
    // The stages of each link that end on another host than they begin: plant to b, b to b, b to c, c to plant.
    let uncertain: [&[usize]; 4] = [&[2, 6], &[0, 6], &[0, 2, 6], &[0, 2]];
    let (mut reached, mut negative) = ([[false; 7]; 4], 0);
    for seed in 1..9 {
        let run = Run::new(seed, 100 + seed);
        let log = run.log();
        let (found, truth) = (follow(&log), follow(&run.truth));
        assert_eq!(found.len(), MESSAGES as usize);
        for (message, truth) in found.iter().zip(&truth) {
            let (own, truth) = (chain(message), chain(truth));
            assert_eq!(own.stages_ns().iter().sum::<i64>(), truth.end_to_end_ns());
            assert_eq!(own.end_to_end_ns(), truth.end_to_end_ns());
            let link = message.from as usize;
            let stages = own.stages_ns().into_iter().zip(truth.stages_ns());
            for (stage, (found_ns, true_ns)) in stages.enumerate() {
                let within_ns = ns(own.uncertainty[stage]);
                let off_ns = (found_ns - true_ns).abs();
                assert!(off_ns <= within_ns, "{message:?} {stage}: {off_ns}");
                let is_uncertain = uncertain[link].contains(&stage);
                assert_eq!(
                    !own.uncertainty[stage].is_exact(),
                    is_uncertain,
                    "{message:?}"
                );
                reached[link][stage] |= is_uncertain && off_ns == within_ns;
                negative += u32::from(found_ns < 0);
            }
        }
    }
    let expected: [[bool; 7]; 4] = uncertain.map(|link| std::array::from_fn(|i| link.contains(&i)));
    assert_eq!(reached, expected);
    assert!(negative > 100, "{negative}");
}

/// Each median of the answer is that of the true clock within its uncertainty, and each maximum within the largest of a
/// message; what begins and ends on the plant's host is the same.
#[test]
fn the_true_median_is_within_the_uncertainty_of_each_link() {
    for seed in 1..9 {
        let run = Run::new(seed, 200 + seed);
        let log = run.log();
        let (found, truth) = (answer(&log, &[]), answer(&run.truth, &[]));
        let mut largest = BTreeMap::new();
        for message in follow(&log) {
            let own = largest.entry(message.from).or_insert([0; 7]);
            *own = std::array::from_fn(|i| own[i].max(ns(chain(&message).uncertainty[i])));
        }
        assert_eq!(
            (found.hops.len(), found.platoon.len()),
            (4, truth.platoon.len())
        );
        assert_eq!(found.platoon, truth.platoon);
        for ((hop, truth), largest) in found.hops.iter().zip(&truth.hops).zip(largest.values()) {
            assert_eq!(hop.end_to_end, truth.end_to_end);
            assert_eq!((hop.messages, hop.largest_sum_error_s), (300, 0.0));
            for ((stage, truth), largest_ns) in hop.stages.iter().zip(&truth.stages).zip(largest) {
                let median_ns = ns(stage.uncertainty_s);
                assert_eq!(stage.uncertainty_s.is_exact(), *largest_ns == 0);
                assert!(median_ns <= *largest_ns, "{stage:?}");
                let off = |found: f64, truth: f64| ((found - truth).abs() * 1e9).round() as i64;
                let (found, truth) = (stage.figures, truth.figures);
                assert!(off(found.p50_s, truth.p50_s) <= median_ns, "{stage:?}");
                assert!(off(found.max_s, truth.max_s) <= *largest_ns, "{stage:?}");
            }
        }
    }
    let run = Run::new(3, 4);
    let (found, truth) = (answer(&run.log(), &[]), answer(&run.truth, &[]));
    // r1 is on the plant's host; the others read the time of their tick on their own.
    let ages: Vec<_> = found
        .at_outer_ticks
        .iter()
        .zip(&truth.at_outer_ticks)
        .collect();
    assert_eq!(ages.len(), 4);
    for (age, truth) in ages {
        assert_eq!(age.uncertainty_s.is_exact(), age.to == "r1", "{age:?}");
        let s = age.uncertainty_s.seconds().unwrap() + 1e-12;
        assert!(
            (age.figures.p50_s - truth.figures.p50_s).abs() <= s,
            "{age:?}"
        );
        assert!(age.to == "r1" || age.figures != truth.figures, "{age:?}");
    }
}

/// The JSON of a run on one host is as it was before there were several; that of several is read back.
#[test]
fn a_run_on_one_host_has_no_new_keys() {
    let run = Run::new(5, 6);
    let json = |log: &Log| {
        let answer = LatencyAnswer {
            against: Some(against(log, &run.truth, &[])),
            ..answer(log, &[])
        };
        let text = serde_json::to_string(&answer).unwrap();
        let again: LatencyAnswer = serde_json::from_str(&text).unwrap();
        assert_eq!(again, answer);
        text
    };
    let keys = ["\"uncertainty_s\":", "\"hosts\":"];
    let has = |text: &str| keys.map(|key| text.contains(key));
    assert_eq!(has(&json(&run.truth)), [false; 2]);
    assert_eq!(has(&json(&run.log())), [true; 2]);
}

fn clock(t_ms: i64, bound_ns: i64, error_ns: i64, drift_ppb: Option<i64>) -> Step {
    let clock = Clock {
        t_ns: t_ms * 1_000_000,
        offset_ns: 5_000_000_000 + t_ms,
        bound_ns,
        drift_ppb,
        round_trip_ns: 80_000 + t_ms,
        error_ns,
    };
    Step::Clock {
        host: "b".to_owned(),
        clock,
    }
}

/// The error of a stamp is that of the worse record beside it; records may come in any order.
#[test]
fn the_worse_record_beside_a_stamp_counts() {
    let host = Step::Host {
        robot: 1,
        host: "b".to_owned(),
    };
    let clocks = [
        clock(1000, 30, 34, None),
        clock(-2000, 9000, 9000, None),
        clock(0, 40, 100, Some(1500)),
        clock(-1000, 600, 700, None),
        clock(2000, 20, 20, None),
    ];
    let expected = [
        (-3000, 9000),
        (-1500, 9000),
        (-500, 700),
        (0, 100),
        (500, 100),
        (1500, 34),
        (2000, 20),
        (2500, 20),
    ];
    for (t_ms, error_ns) in expected {
        let instants_ns = std::array::from_fn(|_| t_ms * 1_000_000);
        let steps = steps(0, instants_ns, [0; 3], true).into_iter();
        let log = Log::new(clocks.iter().cloned().chain([host.clone()]).chain(steps));
        let uncertainty = chain(&follow(&log)[0]).uncertainty;
        assert_eq!(uncertainty[6], Uncertainty::Within(error_ns), "{t_ms}");
        let hosts = answer(&log, &[]).hosts;
        let [b] = &hosts[..] else { panic!("{hosts:?}") };
        assert_eq!(
            (&*b.host, &b.robots[..], b.windows),
            ("b", &["r2".to_owned()][..], 5)
        );
        assert_eq!([b.offset_s, b.drift_ppm], [Some(5.000002), Some(1.5)]);
        // The bound before the start is the largest; the error counts from the start on.
        assert_eq!([b.bound_s, b.error_s], [Some(9000e-9), Some(100e-9)]);
        assert_eq!(b.round_trip_s, Some(78e-6));
    }
}

/// What the recording does not tell is said to be unknown, or missing.
#[test]
fn what_is_not_recorded_is_not_exact() {
    let run = Run::new(7, 8);
    let without = |left_out: &dyn Fn(&Step) -> bool| {
        let steps = run.hosts.iter().chain(&run.stamped);
        Log::new(steps.filter(|step| !left_out(step)).cloned())
    };
    let uncertain = |log: &Log, from: u32| {
        let message = follow(log).into_iter().find(|message| message.from == from);
        chain(&message.unwrap()).uncertainty
    };
    let unknown = |uncertainty: [Uncertainty; 7]| uncertainty.map(|u| u == Uncertainty::Unknown);
    // No clock of c: what begins or ends there.
    let log = without(&|step| matches!(step, Step::Clock { host, .. } if host == "c"));
    let [no, yes] = [false, true];
    assert_eq!(unknown(uncertain(&log, 0)), [no; 7]);
    assert_eq!(unknown(uncertain(&log, 2)), [no, no, yes, no, no, no, yes]);
    assert_eq!(unknown(uncertain(&log, 3)), [yes, no, yes, no, no, no, no]);
    let found = answer(&log, &[]);
    let text = serde_json::to_string(&found).unwrap();
    assert!(text.contains("\"uncertainty_s\":null"), "{text}");
    assert_eq!(serde_json::from_str::<LatencyAnswer>(&text).unwrap(), found);
    let c = &found.hosts[1];
    assert_eq!(
        (&*c.host, c.windows, c.error_s, c.offset_s),
        ("c", 0, None, None)
    );
    let changes = against(&log, &run.log(), &[]);
    let transport = |hop: usize| &changes[hop].stages[2];
    assert!(transport(0).ci95_s.is_some() && transport(2).ci95_s.is_none());
    // No hosts of the robots, although messages crossed.
    let log = without(&|step| matches!(step, Step::Host { .. }));
    assert_eq!(unknown(uncertain(&log, 0)), [no, no, yes, no, no, no, no]);
    // No time at which the messages between hosts came out of the network.
    let log = without(&|step| matches!(step, Step::Crossed { .. }));
    let untold = answer(&log, &[])
        .hops
        .into_iter()
        .map(|hop| hop.incomplete.untold);
    assert_eq!(untold.collect::<Vec<_>>(), [300, 0, 300, 300]);
}

/// A message that a tick used was through the network, whatever was recorded later.
#[test]
fn a_message_crossed_before_the_tick_that_used_it() {
    let late = |log: &mut Log| {
        log.take(Step::Crossed {
            from: 0,
            to: 1,
            seq: 0,
            t_ns: 40_000_000,
        });
        chain(&follow(log)[0]).instants_ns
    };
    let ms = [1, 2, 3, 0, 6, 7, 8, 9].map(|ms: i64| ms * 1_000_000);
    let steps = steps(0, ms, [0; 3], true).into_iter();
    let mut log =
        Log::new(placed().chain(steps.filter(|step| !matches!(step, Step::Crossed { .. }))));
    let [.., queued_ns, available_ns, began_ns, _, _] = late(&mut log);
    assert_eq!(
        [queued_ns, available_ns, began_ns].map(|ns| ns / 1_000_000),
        [7, 7, 7]
    );
    // It may be recorded twice: it was there the first time.
    log.take(Step::Crossed {
        from: 0,
        to: 1,
        seq: 0,
        t_ns: 4_000_000,
    });
    assert_eq!(late(&mut log)[3..5], [4_000_000, 6_000_000]);
}

/// Two runs with the same ways and other errors of the clocks: only a reader that takes the stamps for those
/// of one clock finds a change.
#[test]
fn clocks_alone_are_no_change() {
    // The errors of all messages have one sign, as those of a biased estimate.
    let runs = [1, -1].map(|sign| {
        let mut way = Chance(11);
        let error_ns = sign * 150_000;
        let steps = (0..MESSAGES).flat_map(|seq| {
            let errors_ns = [0, error_ns, -error_ns];
            steps(seq, instants(seq, &mut way), errors_ns, true)
        });
        steps.collect::<Vec<_>>()
    });
    let known = |bound_ns| {
        let clock = move |host: &&str| Step::Clock {
            host: (*host).to_owned(),
            clock: Clock {
                t_ns: 0,
                offset_ns: 0,
                bound_ns,
                drift_ppb: None,
                round_trip_ns: 0,
                error_ns: bound_ns,
            },
        };
        let hosts = NAMES[1..].iter().map(clock);
        placed().chain(hosts).collect::<Vec<_>>()
    };
    let changed = |bound_ns| {
        let logs = runs
            .each_ref()
            .map(|run| Log::new(known(bound_ns).iter().chain(run).cloned()));
        let changes = against(&logs[0], &logs[1], &[]);
        let stages = changes
            .iter()
            .map(|hop| hop.stages.iter().filter(|stage| stage.changed));
        stages.map(Iterator::count).collect::<Vec<_>>()
    };
    assert_eq!(changed(150_000), [0; 4]);
    // Bounds that are too small: transport and wait for the plant, both waits, and so on.
    assert_eq!(changed(100), [2, 2, 3, 2]);
}

/// Viewers get the ends of all stages after their beginnings and the points of an arrow in order, although
/// stages are negative.
#[test]
fn the_timeline_is_in_order() {
    let log = Run::new(9, 10).log();
    let negative = follow(&log)
        .iter()
        .filter(|m| chain(m).stages_ns().iter().any(|ns| *ns < 0))
        .count();
    assert!(negative > 20, "{negative}");
    let timeline = timeline(&log, &[]);
    let mut open: BTreeMap<String, Option<String>> = BTreeMap::new();
    let mut arrows: BTreeMap<String, String> = BTreeMap::new();
    for event in timeline["traceEvents"].as_array().unwrap() {
        let (id, name) = (event["id"].to_string(), event["name"].to_string());
        match event["ph"].as_str().unwrap() {
            "b" => assert_eq!(open.insert(id, Some(name)).flatten(), None, "{event}"),
            "e" => assert_eq!(open.insert(id, None).flatten(), Some(name), "{event}"),
            phase @ ("s" | "t" | "f") => arrows.entry(id).or_default().push_str(phase),
            _ => {}
        }
    }
    assert_eq!(arrows.len(), MESSAGES as usize);
    assert!(arrows.values().all(|arrow| arrow == "sttf"));
    assert!(open.values().all(Option::is_none));
    let lengths = timeline["traceEvents"].as_array().unwrap().iter();
    let lengths = lengths.filter_map(|event| event["args"]["length_ns"].as_i64());
    assert!(lengths.min() < Some(0));
}

/// A message that did not arrive, while a later one of the same link did, was lost by the network. The last one may be
/// under way.
#[test]
fn a_message_that_the_network_lost_is_counted() {
    let run = Run::new(7, 8);
    // Of the link from the plant's host to b: one in the middle, and the last.
    let (lost, last) = (400, MESSAGES - 4);
    let is_of = |step: &Step, wanted: u32| match step {
        Step::Arrived { seq, .. } | Step::Taken { seq, .. } | Step::Crossed { seq, .. } => {
            *seq == wanted
        }
        _ => false,
    };
    let arrived = run.stamped.iter();
    let arrived = arrived.filter(|step| !is_of(step, lost) && !is_of(step, last));
    let log = Log::new(run.hosts.iter().chain(arrived).cloned());
    let fates: Vec<Fate> = follow(&log)
        .iter()
        .filter(|message| [lost, last].contains(&message.seq))
        .map(|message| message.fate)
        .collect();
    assert_eq!(fates, [Fate::Lost, Fate::UnderWay]);
}
