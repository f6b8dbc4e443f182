//! A recording cut into windows, each with an initial state of its own: what is unknown before a
//! window cannot spoil it.

use slipstream_sim::{Command, Robot, Scalar, State};

use crate::track::Track;

/// Length of a window (s).
pub(crate) const WINDOW_S: f64 = 5.0;

/// How far a window's start may be moved to where the robot rolls gently (s).
const SEARCH_S: f64 = 0.8;

/// Longest step of a simulation in the fit (s).
const STEP_S: f64 = 2e-3;

/// Unknowns of a window's start: pose (3), surge and yaw rate, angles of both wheels.
pub(crate) const LOCALS: usize = 7;

/// One window: what was told and measured in it.
#[derive(Debug, Clone)]
pub(crate) struct Window {
    pub(crate) from_s: f64,
    pub(crate) to_s: f64,
    /// Of the track's commands, the one that holds at the start, and the end of the range.
    commands: [usize; 2],
    wheels: [usize; 2],
    poses: [usize; 2],
}

/// Cuts `track` into windows that start where the torque is small.
pub(crate) fn cut(track: &Track) -> Vec<Window> {
    let [begin, end] = track.span_s();
    let mut windows = Vec::new();
    let mut from_s = begin;
    while from_s + 1.0 < end {
        let wanted = from_s + WINDOW_S;
        let to_s = if wanted + 1.0 > end {
            end
        } else {
            gentle(track, wanted)
        };
        windows.push(Window::new(track, from_s, to_s));
        from_s = to_s;
    }
    windows
}

/// The instant near `wanted_s` at which a command begins that asks for the least.
fn gentle(track: &Track, wanted_s: f64) -> f64 {
    let near = track
        .commands
        .iter()
        .filter(|(t_s, _)| (t_s - wanted_s).abs() <= SEARCH_S);
    let size = |command: &Command| match *command {
        Command::Torque { right_nm, left_nm } => right_nm.abs() + left_nm.abs(),
        Command::Voltage { right_v, left_v } => right_v.abs() + left_v.abs(),
        Command::Speed { .. } | Command::Twist { .. } => 0.0,
    };
    let best = near.min_by(|(a_s, a), (b_s, b)| {
        let apart = |t_s: f64| (t_s - wanted_s).abs() * 1e-6;
        (size(a) + apart(*a_s)).total_cmp(&(size(b) + apart(*b_s)))
    });
    best.map_or(wanted_s, |(t_s, _)| *t_s)
}

fn range<T>(rows: &[(f64, T)], from_s: f64, to_s: f64) -> [usize; 2] {
    let first = rows.partition_point(|(t_s, _)| *t_s < from_s);
    let end = rows.partition_point(|(t_s, _)| *t_s < to_s);
    [first, end]
}

impl Window {
    fn new(track: &Track, from_s: f64, to_s: f64) -> Self {
        let [first, end] = range(&track.commands, from_s + 1e-9, to_s - 1e-9);
        Self {
            from_s,
            to_s,
            commands: [first.saturating_sub(1), end],
            wheels: range(&track.wheels, from_s, to_s),
            poses: range(&track.poses, from_s, to_s),
        }
    }

    /// The first `over_s` of this window.
    pub(crate) fn head(&self, track: &Track, over_s: f64) -> Self {
        Self::new(track, self.from_s, (self.from_s + over_s).min(self.to_s))
    }

    /// A first guess of the unknowns at the start, from the measurements near it.
    pub(crate) fn guess(&self, track: &Track, radius_m: f64, half_track_m: f64) -> [f64; LOCALS] {
        let poses = &track.poses[self.poses[0]..self.poses[1]];
        let wheels = &track.wheels[self.wheels[0]..self.wheels[1]];
        let pose = poses.first().map_or([0.0; 3], |(_, pose)| *pose);
        let angle = wheels.first().map_or([0.0; 2], |(_, angle)| *angle);
        let later = wheels.iter().find(|(t_s, _)| *t_s > self.from_s + 0.1);
        let speed = match (wheels.first(), later) {
            (Some((a_s, a)), Some((b_s, b))) if b_s > a_s => {
                [0, 1].map(|i| (b[i] - a[i]) / (b_s - a_s) * radius_m)
            }
            _ => [0.0; 2],
        };
        let rate = (speed[0] - speed[1]) / (2.0 * half_track_m);
        let yaw = if pose[2].is_finite() { pose[2] } else { 0.0 };
        [
            pose[0],
            pose[1],
            yaw,
            (speed[0] + speed[1]) / 2.0,
            rate,
            angle[0],
            angle[1],
        ]
    }

    /// Simulates the window and hands every residual, in standard deviations, to `take`, with its
    /// channel: 0 right wheel, 1 left wheel, 2 to 4 pose.
    pub(crate) fn simulate<S: Scalar>(
        &self,
        track: &Track,
        robot: &Robot<S>,
        start: &[S; LOCALS],
        mut take: impl FnMut(f64, usize, S),
    ) {
        let mut state = robot.start([start[0], start[1], start[2]]);
        let mut seen = Seen {
            track,
            robot,
            offset: [start[5], start[6]],
            wheels: self.wheels,
            poses: self.poses,
        };
        let commands = &track.commands[self.commands[0]..self.commands[1]];
        let mut first = true;
        for (i, (since_s, command)) in commands.iter().enumerate() {
            let command = lift(command);
            let from_s = since_s.max(self.from_s);
            let to_s = commands
                .get(i + 1)
                .map_or(self.to_s, |(t_s, _)| t_s.min(self.to_s));
            if to_s <= from_s {
                continue;
            }
            if first {
                robot.set_rolling(&mut state, start[3], start[4]);
                robot.settle_drive(&mut state, &command);
                first = false;
            }
            let steps = ((to_s - from_s) / STEP_S - 1e-6).ceil().max(1.0);
            let step_s = (to_s - from_s) / steps;
            for k in 0..steps as u32 {
                let t_s = from_s + f64::from(k) * step_s;
                let before = Knot::new(robot, &state);
                robot.step(&mut state, t_s, step_s, &command);
                let after = Knot::new(robot, &state);
                seen.between(t_s, step_s, &before, &after, &mut take);
            }
        }
    }
}

fn lift<S: Scalar>(command: &Command) -> Command<S> {
    let c = S::constant;
    match *command {
        Command::Torque { right_nm, left_nm } => Command::Torque {
            right_nm: c(right_nm),
            left_nm: c(left_nm),
        },
        Command::Voltage { right_v, left_v } => Command::Voltage {
            right_v: c(right_v),
            left_v: c(left_v),
        },
        Command::Speed {
            right_rad_s,
            left_rad_s,
        } => Command::Speed {
            right_rad_s: c(right_rad_s),
            left_rad_s: c(left_rad_s),
        },
        Command::Twist { v_m_s, w_rad_s } => Command::Twist {
            v_m_s: c(v_m_s),
            w_rad_s: c(w_rad_s),
        },
    }
}

/// A simulated instant: what a cubic between two of them needs.
struct Knot<S> {
    /// Pose of c, then encoder angles.
    at: [S; 5],
    /// Their rates.
    rate: [S; 5],
}

impl<S: Scalar> Knot<S> {
    fn new(robot: &Robot<S>, state: &State<S>) -> Self {
        let [x, y, yaw] = state.pose();
        let [u, w, turn] = state.velocity();
        let (sin, cos) = yaw.sin_cos();
        let [right, left] = robot.seen_angle(state);
        let speed = robot.seen_speed(state);
        Self {
            at: [x, y, yaw, right, left],
            rate: [
                u * cos - w * sin,
                u * sin + w * cos,
                turn,
                speed[0],
                speed[1],
            ],
        }
    }
}

/// The measurements that are still to come.
struct Seen<'a, S> {
    track: &'a Track,
    robot: &'a Robot<S>,
    offset: [S; 2],
    wheels: [usize; 2],
    poses: [usize; 2],
}

impl<S: Scalar> Seen<'_, S> {
    /// Compares what was measured between two instants.
    fn between(
        &mut self,
        t_s: f64,
        step_s: f64,
        before: &Knot<S>,
        after: &Knot<S>,
        take: &mut impl FnMut(f64, usize, S),
    ) {
        use slipstream_sim::Stream;
        let at = |part: usize, share: S| {
            let (s, h) = (share, step_s);
            let (s2, s3) = (s * s, s * s * s);
            let up = s2 * 3.0 - s3 * 2.0;
            before.at[part]
                + (after.at[part] - before.at[part]) * up
                + before.rate[part] * (s3 - s2 * 2.0 + s) * h
                + after.rate[part] * (s3 - s2) * h
        };
        while self.wheels[0] < self.wheels[1] {
            let (stamp_s, angle) = self.track.wheels[self.wheels[0]];
            let true_s = self.robot.true_s(Stream::Wheels, S::constant(stamp_s));
            if true_s.value() > t_s + step_s {
                break;
            }
            let share = (true_s - t_s) / step_s;
            for (i, angle) in angle.into_iter().enumerate() {
                let own = at(3 + i, share) + self.offset[i] - angle;
                take(stamp_s, i, own / self.track.wheel_rad);
            }
            self.wheels[0] += 1;
        }
        while self.poses[0] < self.poses[1] {
            let (stamp_s, measured) = self.track.poses[self.poses[0]];
            let true_s = self.robot.true_s(Stream::Pose, S::constant(stamp_s));
            if true_s.value() > t_s + step_s {
                break;
            }
            let share = (true_s - t_s) / step_s;
            let pose = self
                .robot
                .seen_pose([at(0, share), at(1, share), at(2, share)]);
            let (sin, cos) = pose[2].sin_cos();
            let ahead = self.track.tracked_ahead_m;
            let seen = [pose[0] + cos * ahead, pose[1] + sin * ahead, pose[2]];
            for i in 0..3 {
                if measured[i].is_finite() {
                    let mut apart = seen[i] - measured[i];
                    if i == 2 {
                        let turns = (apart.value() / std::f64::consts::TAU).round();
                        apart -= S::constant(turns * std::f64::consts::TAU);
                    }
                    take(stamp_s, 2 + i, apart / self.track.pose_deviation[i]);
                }
            }
            self.poses[0] += 1;
        }
    }
}
