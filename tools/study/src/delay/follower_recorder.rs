//! Recorder of a study's run: every follower's outer ticks that use a message, beside what the robot
//! ahead asked for at the same instant and the age of the message.

use slipstream_bus::Experiment;
use slipstream_bus::record::{EventKind, OuterTick, Record, Recorder};
use slipstream_bus::time::{ns_from_s, s_from_ns};

/// One outer tick of a follower in formation. Positions are x of the centre of mass by odometry.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FollowerTick {
    /// Time (s).
    pub t_s: f64,
    /// The follower's x (m).
    pub x_m: f64,
    /// v_d before limiting (m/s).
    pub desired_m_s: f64,
    /// x_r without delay: where the robot ahead wants the follower at this instant (m).
    pub x_r_m: f64,
    /// v_r without delay (m/s).
    pub v_r_m_s: f64,
    /// Age of the position in use (s): from its sampling to this tick.
    pub age_s: f64,
}

/// Records one run.
#[derive(Debug)]
pub struct FollowerRecorder {
    start_ns: i64,
    spacing_m: f64,
    robots: Vec<RecordedFollower>,
}

#[derive(Debug, Default)]
struct RecordedFollower {
    /// Reference for its follower at its own outer ticks: time (s), x_r (m), v_r (m/s).
    references: Vec<[f64; 3]>,
    /// When the position in each of its messages was sampled (ns), by sequence number.
    sampled_ns: Vec<i64>,
    ticks: Vec<FollowerTick>,
    max_desired_m_s: f64,
    /// Its watchdog slows it down because no messages arrive: Eq. 12 is not in force.
    watchdog: bool,
}

impl FollowerRecorder {
    /// An empty recorder for a run of this experiment.
    pub fn new(experiment: &Experiment) -> Self {
        let formation = &experiment.settings.formation;
        Self {
            start_ns: ns_from_s(formation.start_s),
            spacing_m: formation.spacing_m,
            robots: experiment
                .robots
                .iter()
                .map(|_| RecordedFollower::default())
                .collect(),
        }
    }

    /// The largest desired speed of any follower from the start of coordination on (m/s).
    pub fn max_desired_m_s(&self) -> f64 {
        let speeds = self
            .robots
            .iter()
            .skip(1)
            .map(|robot| robot.max_desired_m_s);
        speeds.fold(0.0, f64::max)
    }

    /// Every follower's ticks, each with the x_r (m) and v_r (m/s) of `age_s` (s) earlier.
    pub fn ticks(&self, age_s: f64) -> impl Iterator<Item = (&FollowerTick, [f64; 2])> {
        self.robots.windows(2).flat_map(move |pair| {
            let ticks = pair[1].ticks.iter();
            ticks.map(move |tick| (tick, pair[0].reference_at(tick.t_s - age_s)))
        })
    }

    /// Mean age of the positions in use (s); 0 if there were none.
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
        self.robots[index].references.push([t_s, x_r, v_r]);
        if index == 0 || tick.t_ns < self.start_ns {
            return;
        }
        let ahead = &self.robots[index - 1];
        let sampled_ns = tick
            .message
            .and_then(|seq| ahead.sampled_ns.get(seq as usize).copied());
        let reference = ahead.references.last().copied();
        let watchdog = self.robots[index].watchdog;
        let robot = &mut self.robots[index];
        robot.max_desired_m_s = robot.max_desired_m_s.max(tick.desired[0].abs());
        if let (Some(sampled_ns), Some([_, x_r_m, v_r_m_s]), false) =
            (sampled_ns, reference, watchdog)
        {
            robot.ticks.push(FollowerTick {
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

impl RecordedFollower {
    /// x_r (m) and v_r (m/s) for its follower at a time, interpolated linearly between its outer ticks.
    fn reference_at(&self, t_s: f64) -> [f64; 2] {
        let after = self.references.partition_point(|&[t, ..]| t <= t_s);
        let at = |index: usize| self.references.get(index).copied();
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

impl Recorder for FollowerRecorder {
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
                // This event follows the record of its tick, which is the first without Eq. 12.
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
