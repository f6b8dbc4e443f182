//! Properties that hold for every log, and the answer read back from its JSON.

mod chance;

use chance::Chance;
use slipstream_bus::record::Fate;
use slipstream_trace::{Clock, LatencyAnswer, Log, Loop, Step, Topic, against, answer};

/// Adds message `seq` from r1 to r2 with stages of random length; some chains end early.
fn one_message(log: &mut Log, seq: u32, chance: &mut Chance) {
    let due_ns = i64::from(seq) * 50_000_000;
    let mut now_ns = due_ns;
    let mut later = || {
        now_ns += chance.below(6_000_000);
        now_ns
    };
    let [sampled_ns, began_ns, sent_ns, queued_ns] = [(); 4].map(|()| later());
    let [available_ns, taken_ns, obeyed_ns, applied_ns] = [(); 4].map(|()| later());
    let outer = |robot: u32, began_ns: i64| Step::Outer {
        robot,
        due_ns,
        began_ns,
        done_ns: began_ns,
        message: None,
    };
    let (from, to) = (0, 1);
    log.take(outer(from, began_ns));
    log.take(Step::Sent {
        from,
        to,
        seq,
        sampled_ns,
        tick_ns: due_ns,
        sent_ns,
        queued_ns,
    });
    let fate = [
        Fate::Used,
        Fate::Used,
        Fate::Stale,
        Fate::Superseded,
        Fate::Unused,
    ];
    let fate = fate[seq as usize % fate.len()];
    let lost = seq.is_multiple_of(7);
    log.take(Step::Arrived {
        from,
        to,
        seq,
        available_ns: (!lost).then_some(available_ns),
    });
    if lost {
        return;
    }
    log.take(Step::Taken {
        from,
        to,
        seq,
        tick_ns: due_ns,
        fate,
    });
    log.take(outer(to, taken_ns));
    log.take(Step::Inner {
        robot: to,
        due_ns: due_ns + 1,
        began_ns: obeyed_ns,
        done_ns: obeyed_ns,
        outer_ns: due_ns,
    });
    // Some torques are never applied by the plant.
    if !seq.is_multiple_of(11) {
        log.take(Step::Applied {
            robot: to,
            tick_ns: due_ns + 1,
            taken_ns: applied_ns,
        });
    }
}

#[test]
fn stages_of_a_million_messages_add_up_and_every_message_is_counted() {
    let mut log = Log::default();
    let mut chance = Chance(1);
    let messages = 1_000_000;
    for seq in 0..messages {
        one_message(&mut log, seq, &mut chance);
    }
    let answer = answer(&log, &[]);
    let hop = &answer.hops[0];
    assert_eq!((answer.hops.len(), &*hop.from, &*hop.to), (1, "r1", "r2"));
    assert_eq!(hop.largest_sum_error_s, 0.0);
    let number =
        |class: &dyn Fn(u32) -> bool| (0..messages).filter(|&seq| class(seq)).count() as u64;
    let used = |seq: u32| !seq.is_multiple_of(7) && seq % 5 < 2;
    assert_eq!(hop.sent, u64::from(messages));
    assert_eq!(
        hop.messages,
        number(&|seq| used(seq) && !seq.is_multiple_of(11))
    );
    let others = &hop.incomplete;
    assert_eq!(others.lost, number(&|seq| seq.is_multiple_of(7)));
    assert_eq!(
        others.stale,
        number(&|seq| !seq.is_multiple_of(7) && seq % 5 == 2)
    );
    assert_eq!(
        others.superseded,
        number(&|seq| seq % 7 != 0 && seq % 5 == 3)
    );
    assert_eq!(
        others.under_way,
        number(&|seq| seq % 7 != 0 && seq % 5 == 4)
    );
    assert_eq!(
        others.overwritten,
        number(&|seq| used(seq) && seq.is_multiple_of(11))
    );
    assert_eq!((others.untold, others.receiver_died), (0, 0));
}

/// A dead receiver and the end of the recording are distinguished.
#[test]
fn a_dead_receiver_differs_from_the_end_of_the_recording() {
    for (death_ns, died) in [(None, 0), (Some(5), 0), (Some(20), 1)] {
        let mut log = Log::default();
        log.take(Step::Sent {
            from: 0,
            to: 1,
            seq: 0,
            sampled_ns: 0,
            tick_ns: 0,
            sent_ns: 10,
            queued_ns: 11,
        });
        if let Some(t_ns) = death_ns {
            log.take(Step::Died { robot: 1, t_ns });
        }
        let others = answer(&log, &[]).hops[0].incomplete;
        assert_eq!((others.receiver_died, others.under_way), (died, 1 - died));
    }
}

/// A damaged or hostile file may contain any number; no computation overflows.
#[test]
fn extreme_times_and_robots_do_not_overflow() {
    let mut chance = Chance(7);
    for _ in 0..2000 {
        let mut log = Log::default();
        for _ in 0..40 {
            let times = [i64::MIN, -1, 0, 1, i64::MAX];
            let mut time = || times[usize::try_from(chance.below(5)).unwrap_or(0)];
            let times = [(); 6].map(|()| time());
            let robots = [0, 1, u32::MAX];
            let mut robot = || robots[usize::try_from(chance.below(3)).unwrap_or(0)];
            let (from, to) = (robot(), robot());
            log.take(any_step(from, to, times, chance.below(10)));
        }
        let answer = answer(&log, &[]);
        let _ = slipstream_trace::timeline(&log, &[]);
        let _ = slipstream_trace::round_trips(&log);
        let _ = against(&log, &log, &[]);
        for hop in &answer.hops {
            let others = hop.incomplete;
            let counted = others.lost + others.stale + others.superseded + others.overwritten;
            let counted = counted + others.under_way + others.receiver_died + others.untold;
            assert_eq!(hop.messages + counted, hop.sent);
        }
    }
}

fn any_step(from: u32, to: u32, [a, b, c, d, e, f]: [i64; 6], kind: i64) -> Step {
    match kind {
        0 => Step::Sent {
            from,
            to,
            seq: 0,
            sampled_ns: a,
            tick_ns: b,
            sent_ns: c,
            queued_ns: d,
        },
        1 => Step::Arrived {
            from,
            to,
            seq: 0,
            available_ns: Some(b),
        },
        2 => Step::Taken {
            from,
            to,
            seq: 0,
            tick_ns: a,
            fate: Fate::Used,
        },
        3 => Step::Outer {
            robot: from,
            due_ns: a,
            began_ns: b,
            done_ns: c,
            message: Some(0),
        },
        4 => Step::Applied {
            robot: to,
            tick_ns: f,
            taken_ns: c,
        },
        7 => Step::Crossed {
            from,
            to,
            seq: 0,
            t_ns: a,
        },
        8 => Step::Host {
            robot: from,
            host: to.to_string(),
        },
        9 => Step::Clock {
            host: to.to_string(),
            clock: Clock {
                t_ns: a,
                offset_ns: b,
                bound_ns: c,
                drift_ppb: Some(d),
                round_trip_ns: e,
                error_ns: f,
            },
        },
        5 => Step::Deadline {
            robot: (from == 0).then_some(to),
            of: Loop::Step,
            due_ns: a,
            began_ns: b,
            done_ns: c,
            missed: d > 0,
        },
        _ => Step::Inner {
            robot: to,
            due_ns: f,
            began_ns: d,
            done_ns: c,
            outer_ns: e,
        },
    }
}

/// Ticks 10 ms apart that begin late by 0, 3, 1 and 1 ms; then one is left out.
#[test]
fn lateness_jitter_and_missed_deadlines_are_those_of_the_ticks() {
    let mut log = Log::default();
    for (k, late_ms) in [(1, 0), (2, 3), (3, 1), (5, 1)] {
        let due_ns = k * 10_000_000;
        let began_ns = due_ns + late_ms * 1_000_000;
        log.take(Step::Deadline {
            robot: None,
            of: Loop::Step,
            due_ns,
            began_ns,
            done_ns: began_ns + 8_000_000,
            missed: late_ms > 2,
        });
    }
    let answer = answer(&log, &[]);
    let figures = &answer.loops[0];
    assert_eq!((&*figures.process, &*figures.name), ("plant", "step"));
    assert_eq!((figures.ticks, figures.missed, figures.left_out), (4, 1, 1));
    assert_eq!((figures.late.p50_s, figures.late.max_s), (0.001, 0.003));
    let jitter = figures.jitter.unwrap();
    assert_eq!((jitter.p50_s, jitter.max_s), (0.002, 0.003));
}

/// The JSON of an answer, with and without a comparison, is read back as the same answer.
#[test]
fn an_answer_is_read_back_from_its_json() {
    let log = |seed: u64| {
        let mut log = Log::default();
        let mut chance = Chance(seed);
        for seq in 0..500 {
            one_message(&mut log, seq, &mut chance);
        }
        log
    };
    let (here, other) = (log(3), log(5));
    let plain = answer(&here, &[]);
    let compared = LatencyAnswer {
        against: Some(against(&here, &other, &[])),
        ..plain.clone()
    };
    for answer in [plain, compared] {
        let text = serde_json::to_string(&answer).unwrap();
        let again: LatencyAnswer = serde_json::from_str(&text).unwrap();
        assert_eq!(again, answer);
        assert_eq!(serde_json::to_string(&again).unwrap(), text);
    }
}

/// What robots tell is as old as it arrives after its stamp; a command takes from the end of its tick to its topic. A
/// simulated run has no topics.
#[test]
fn topics_of_real_robots_have_their_delays() {
    let tick = |k: i64| {
        let due_ns = k * 20_000_000;
        [
            Step::Inner {
                robot: 0,
                due_ns,
                began_ns: due_ns + 1000,
                done_ns: due_ns + 5000,
                outer_ns: due_ns,
            },
            Step::Applied {
                robot: 0,
                tick_ns: due_ns,
                taken_ns: due_ns + 305_000,
            },
        ]
    };
    let heard = |k: i64| Step::Heard {
        robot: 0,
        of: Topic::Wheels,
        measured_ns: k * 20_000_000,
        arrived_ns: k * 20_000_000 + (k % 4) * 1_000_000,
    };
    let names = ["r1".to_owned()];
    let simulated = Log::new((0..100).flat_map(tick));
    assert_eq!(answer(&simulated, &names).topics, []);
    let real = Log::new((0..100).flat_map(tick).chain((0..100).map(heard)));
    let topics = answer(&real, &names).topics;
    let told: Vec<(&str, u64, f64, f64)> = topics
        .iter()
        .map(|own| {
            (
                own.topic.as_ref(),
                own.messages,
                own.figures.p50_s,
                own.figures.max_s,
            )
        })
        .collect();
    assert_eq!(
        told,
        [("wheels", 100, 1e-3, 3e-3), ("command", 100, 3e-4, 3e-4)]
    );
}
