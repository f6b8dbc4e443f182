//! The times of a bag's messages: stamps of their senders, and times of reception.
//!
//! Both mostly count from 1970. Where they do not agree (simulated time, a bag that was played and recorded again, a
//! clock that was set), messages without a stamp are moved onto the clock of the stamps.

/// The times of one topic's messages.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Times {
    /// Number of messages with a stamp, with a stamp of 0, and of a type that has none.
    pub(super) stamped: u64,
    pub(super) zero: u64,
    pub(super) unstamped: u64,
    first_stamp_ns: Option<i64>,
    /// First time of reception of all messages, and of those without a stamp (ns).
    first_log_ns: Option<i64>,
    first_unstamped_ns: Option<i64>,
    /// Shortest and longest time from stamp to reception (ns).
    delay_ns: Option<[i64; 2]>,
}

impl Times {
    /// Adds a message.
    pub(super) fn add(&mut self, stamp_ns: Option<i64>, log_ns: i64) {
        let mut one = Self {
            first_log_ns: Some(log_ns),
            ..Self::default()
        };
        match stamp_ns.filter(|stamp| *stamp != 0) {
            Some(stamp_ns) => {
                one.stamped = 1;
                one.first_stamp_ns = Some(stamp_ns);
                one.delay_ns = Some([log_ns.saturating_sub(stamp_ns); 2]);
            }
            None => {
                one.zero = u64::from(stamp_ns.is_some());
                one.unstamped = u64::from(stamp_ns.is_none());
                one.first_unstamped_ns = Some(log_ns);
            }
        }
        self.join(&one);
    }

    /// Adds the messages of another topic.
    fn join(&mut self, other: &Self) {
        self.stamped += other.stamped;
        self.zero += other.zero;
        self.unstamped += other.unstamped;
        let least = |a: Option<i64>, b: Option<i64>| a.into_iter().chain(b).min();
        self.first_stamp_ns = least(self.first_stamp_ns, other.first_stamp_ns);
        self.first_log_ns = least(self.first_log_ns, other.first_log_ns);
        self.first_unstamped_ns = least(self.first_unstamped_ns, other.first_unstamped_ns);
        let delays = self.delay_ns.into_iter().chain(other.delay_ns);
        self.delay_ns = delays.reduce(|a, b| [a[0].min(b[0]), a[1].max(b[1])]);
    }
}

/// Clocks that differ by less (ns) are taken for one: so long may a message be on its way.
const SAME_CLOCK_NS: u64 = 2_000_000_000;

/// The clock of a recording.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Clock {
    /// Use times of reception alone.
    use_log: bool,
    /// What is taken off times of reception (ns).
    log_ahead_ns: i64,
    /// Time of the first message (ns).
    pub(super) start_ns: i64,
}

impl Clock {
    /// The clock of the topics that are read. What is unusual about it is added to `warnings`.
    pub(super) fn of<'a>(
        topics: impl Iterator<Item = &'a Times>,
        use_log: bool,
        warnings: &mut Vec<String>,
    ) -> Self {
        let mut all = Times::default();
        topics.for_each(|times| all.join(times));
        let mut clock = Self {
            use_log,
            log_ahead_ns: 0,
            start_ns: 0,
        };
        if use_log {
            clock.start_ns = all.first_log_ns.unwrap_or_default();
            return clock;
        }
        let without_stamp = all.zero + all.unstamped;
        let [least, most] = all.delay_ns.unwrap_or_default();
        if all.stamped == 0 && without_stamp > 0 {
            warnings.push("no message has a stamp: times are those of reception".to_owned());
        } else if without_stamp > 0 && least.unsigned_abs().min(most.unsigned_abs()) > SAME_CLOCK_NS
        {
            clock.log_ahead_ns = least;
            warnings.push(format!(
                "stamps and times of reception differ by {:.3} s: {without_stamp} messages without a stamp are moved by that",
                least as f64 * 1e-9,
            ));
        }
        if most.abs_diff(least) > SAME_CLOCK_NS {
            warnings.push(format!(
                "the time from stamp to reception varies by {:.1} s, as if clocks of stamps did not agree; stamps = \"log\" in a map \
                 for --topics uses times of reception alone",
                most.abs_diff(least) as f64 * 1e-9
            ));
        }
        let unstamped_ns = all.first_unstamped_ns;
        let unstamped_ns = unstamped_ns.map(|log_ns| log_ns.saturating_sub(clock.log_ahead_ns));
        let first = unstamped_ns.into_iter().chain(all.first_stamp_ns).min();
        clock.start_ns = first.unwrap_or_default();
        clock
    }

    /// Time of a message since the first one (ns).
    pub(super) fn time_ns(self, stamp_ns: Option<i64>, log_ns: i64) -> i64 {
        let t_ns = match stamp_ns {
            Some(stamp_ns) if stamp_ns != 0 && !self.use_log => stamp_ns,
            _ => log_ns.saturating_sub(self.log_ahead_ns),
        };
        t_ns.saturating_sub(self.start_ns)
    }
}
