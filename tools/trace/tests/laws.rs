//! What holds for every log, whatever is in it.

use slipstream_bus::message::Position;
use slipstream_bus::record::{EventKind, Fate, InnerTick, OuterTick, Record, Recorder};
use slipstream_trace::{Log, answer};

/// Numbers without a pattern (an xorshift generator).
struct Chance(u64);

impl Chance {
    fn below(&mut self, limit: i64) -> i64 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        (self.0 >> 1).cast_signed() % limit
    }
}

/// Message `seq` from r1 to r2 with stages of any length; some ways end early.
fn one_message(log: &mut Log, seq: u32, chance: &mut Chance) {
    let due_ns = i64::from(seq) * 50_000_000;
    let mut now_ns = due_ns;
    let mut later = || {
        now_ns += chance.below(6_000_000);
        now_ns
    };
    let [sampled_ns, began_ns, sent_ns, queued_ns] = [(); 4].map(|()| later());
    let [available_ns, taken_ns, obeyed_ns, applied_ns] = [(); 4].map(|()| later());
    let position = Position {
        seq,
        sampled_ns,
        tick_ns: due_ns,
        sent_ns,
        ..Position::default()
    };
    let outer = |robot: u32, began_ns: i64| OuterTick {
        t_ns: due_ns,
        began_ns,
        robot,
        ..OuterTick::default()
    };
    let (from, to) = (0, 1);
    log.record(&Record::Outer(outer(from, began_ns)));
    log.record(&Record::Sent {
        to,
        position,
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
    log.record(&Record::Arrived {
        from,
        to,
        seq,
        sent_ns,
        available_ns: (!lost).then_some(available_ns),
    });
    if lost {
        return;
    }
    log.record(&Record::Taken {
        from,
        to,
        seq,
        tick_ns: due_ns,
        fate,
    });
    log.record(&Record::Outer(outer(to, taken_ns)));
    log.record(&Record::Inner(InnerTick {
        t_ns: due_ns + 1,
        began_ns: obeyed_ns,
        robot: to,
        outer_ns: due_ns,
        ..InnerTick::default()
    }));
    // Now and then a torque that no plant took up.
    if !seq.is_multiple_of(11) {
        log.record(&Record::Applied {
            t_ns: applied_ns,
            taken_ns: applied_ns,
            robot: to,
            tick_ns: due_ns + 1,
            torque_nm: [0.0; 2],
        });
    }
}

#[test]
fn a_million_sums_are_exact_and_no_message_is_missing() {
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

/// A receiver that died is told from a recording that ends.
#[test]
fn a_death_is_told_from_the_end() {
    for (death_ns, died) in [(None, 0), (Some(5), 0), (Some(20), 1)] {
        let mut log = Log::default();
        let position = Position {
            sent_ns: 10,
            ..Position::default()
        };
        let queued_ns = 11;
        log.record(&Record::Sent {
            to: 1,
            position,
            queued_ns,
        });
        if let Some(t_ns) = death_ns {
            let (robot, kind) = (Some(1), EventKind::Died);
            log.record(&Record::Event { t_ns, robot, kind });
        }
        let others = answer(&log, &[]).hops[0].incomplete;
        assert_eq!((others.receiver_died, others.under_way), (died, 1 - died));
    }
}

/// A damaged or hostile file may say anything; the answer is still an answer.
#[test]
fn no_time_and_no_robot_is_too_large() {
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
            log.record(&any_record(from, to, times, chance.below(5)));
        }
        let answer = answer(&log, &[]);
        let _ = slipstream_trace::timeline(&log, &[]);
        let _ = slipstream_trace::round_trips(&log);
        let _ = slipstream_trace::against(&log, &log, &[]);
        for hop in &answer.hops {
            let others = hop.incomplete;
            let counted = others.lost + others.stale + others.superseded + others.overwritten;
            let counted = counted + others.under_way + others.receiver_died + others.untold;
            assert_eq!(hop.messages + counted, hop.sent);
        }
    }
}

fn any_record(from: u32, to: u32, [a, b, c, d, e, f]: [i64; 6], kind: i64) -> Record {
    match kind {
        0 => Record::Sent {
            to,
            position: Position {
                from,
                sampled_ns: a,
                tick_ns: b,
                sent_ns: c,
                ..Position::default()
            },
            queued_ns: d,
        },
        1 => Record::Arrived {
            from,
            to,
            seq: 0,
            sent_ns: a,
            available_ns: Some(b),
        },
        2 => Record::Taken {
            from,
            to,
            seq: 0,
            tick_ns: a,
            fate: Fate::Used,
        },
        3 => Record::Outer(OuterTick {
            t_ns: a,
            began_ns: b,
            robot: from,
            message: Some(0),
            ..OuterTick::default()
        }),
        _ => {
            let tick_ns = f;
            if a > 0 {
                return Record::Applied {
                    t_ns: b,
                    taken_ns: c,
                    robot: to,
                    tick_ns,
                    torque_nm: [0.0; 2],
                };
            }
            Record::Inner(InnerTick {
                t_ns: tick_ns,
                began_ns: d,
                robot: to,
                outer_ns: e,
                ..InnerTick::default()
            })
        }
    }
}
