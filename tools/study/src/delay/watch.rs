//! What of a run the study keeps: each follower's outer ticks with a reference from a message, what
//! the robot ahead knew at the same instant, and how old the message was.

use slipstream_bus::Experiment;
use slipstream_bus::record::{EventKind, OuterTick, Record, Recorder};
use slipstream_bus::time::{ns_from_s, s_from_ns};

/// One outer tick of a follower in formation. Positions are x of c by odometry.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Tick {
    /// When (s).
    pub t_s: f64,
    /// The follower's x (m).
    pub x_m: f64,
    /// v_d before limiting (m/s).
    pub desired_m_s: f64,
    /// Where the robot ahead wants it now, if messages took no time: x_r (m).
    pub x_r_m: f64,
    /// v_r that would come without delay (m/s).
    pub v_r_m_s: f64,
    /// How old the position in use is (s): from its sampling to this tick.
    pub age_s: f64,
}

/// Hears one run.
#[derive(Debug)]
pub struct Watch {
    start_ns: i64,
    spacing_m: f64,
    robots: Vec<Robot>,
}

#[derive(Debug, Default)]
struct Robot {
    /// Time (s), x_r that it asks of its follower (m) and v_r (m/s), at its own outer ticks.
    asks: Vec<[f64; 3]>,
    /// When each of its messages was sampled (ns), by number.
    sampled_ns: Vec<i64>,
    ticks: Vec<Tick>,
    max_desired_m_s: f64,
    /// It slows down for want of messages: Eq. 12 is not in force.
    watchdog: bool,
}

impl Watch {
    /// Before a run.
    pub fn new(experiment: &Experiment) -> Self {
        let formation = &experiment.settings.formation;
        Self {
            start_ns: ns_from_s(formation.start_s),
            spacing_m: formation.spacing_m,
            robots: experiment.robots.iter().map(|_| Robot::default()).collect(),
        }
    }

    /// The largest desired speed of any follower since coordination began (m/s).
    pub fn max_desired_m_s(&self) -> f64 {
        let speeds = self
            .robots
            .iter()
            .skip(1)
            .map(|robot| robot.max_desired_m_s);
        speeds.fold(0.0, f64::max)
    }

    /// Every follower's ticks, and for each the x_r (m) and v_r (m/s) of `age_s` before it.
    pub fn ticks(&self, age_s: f64) -> impl Iterator<Item = (&Tick, [f64; 2])> {
        self.robots.windows(2).flat_map(move |pair| {
            let ticks = pair[1].ticks.iter();
            ticks.map(move |tick| (tick, pair[0].asked(tick.t_s - age_s)))
        })
    }

    /// How old the positions in use were on average (s); 0 when there were none.
    pub fn mean_age_s(&self) -> f64 {
        let (mut sum, mut count) = (0.0, 0.0);
        for tick in self.robots.iter().flat_map(|robot| &robot.ticks) {
            sum += tick.age_s;
            count += 1.0;
        }
        if count > 0.0 { sum / count } else { 0.0 }
    }

    fn outer(&mut self, tick: &OuterTick) {
        let index = tick.robot as usize;
        let t_s = s_from_ns(tick.t_ns);
        let x_r = tick.pose[0] - self.spacing_m;
        let v_r = tick.reference_velocity[0];
        self.robots[index].asks.push([t_s, x_r, v_r]);
        if index == 0 || tick.t_ns < self.start_ns {
            return;
        }
        let ahead = &self.robots[index - 1];
        let sampled_ns = tick
            .message
            .and_then(|seq| ahead.sampled_ns.get(seq as usize).copied());
        let asked = ahead.asks.last().copied();
        let watchdog = self.robots[index].watchdog;
        let robot = &mut self.robots[index];
        robot.max_desired_m_s = robot.max_desired_m_s.max(tick.desired[0].abs());
        if let (Some(sampled_ns), Some([_, x_r_m, v_r_m_s]), false) = (sampled_ns, asked, watchdog)
        {
            robot.ticks.push(Tick {
                t_s,
                x_m: tick.pose[0],
                desired_m_s: tick.desired[0],
                x_r_m,
                v_r_m_s,
                age_s: s_from_ns(tick.t_ns - sampled_ns),
            });
        }
    }
}

impl Robot {
    /// What it asked of its follower at a time, straight lines between its outer ticks.
    fn asked(&self, t_s: f64) -> [f64; 2] {
        let after = self.asks.partition_point(|&[t, ..]| t <= t_s);
        let at = |index: usize| self.asks.get(index).copied();
        match (after.checked_sub(1).and_then(at), at(after)) {
            (Some([t0, x0, v0]), Some([t1, x1, v1])) => {
                let share = (t_s - t0) / (t1 - t0);
                [x0 + share * (x1 - x0), v0 + share * (v1 - v0)]
            }
            (Some([_, x, v]), None) | (None, Some([_, x, v])) => [x, v],
            (None, None) => [0.0; 2],
        }
    }
}

impl Recorder for Watch {
    fn record(&mut self, record: &Record) {
        match record {
            Record::Outer(tick) => self.outer(tick),
            Record::Sent { position, .. } => {
                let sent = &mut self.robots[position.from as usize].sampled_ns;
                sent.push(position.sampled_ns);
            }
            Record::Event {
                robot: Some(robot),
                kind,
                ..
            } => match kind {
                // told after the tick's own record: that tick is the first without Eq. 12
                EventKind::WatchdogFired => {
                    let robot = &mut self.robots[*robot as usize];
                    robot.watchdog = true;
                    robot.ticks.pop();
                }
                EventKind::WatchdogCleared => self.robots[*robot as usize].watchdog = false,
                _ => {}
            },
            _ => {}
        }
    }
}
