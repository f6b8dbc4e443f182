//! A lab of boxes: its files and its processes.

use std::fmt::Write as _;
use std::path::{Path, PathBuf};
use std::process::{Child, Output};
use std::sync::atomic::{AtomicU16, Ordering};
use std::time::Duration;

use rustix::process::Signal;

use crate::common::faults::signal;
use crate::common::{command, wait_for};

/// What robots may be told: speed (m/s), yaw rate (rad/s), and their changes (m/s², rad/s²).
pub(crate) const LIMITS: [f64; 4] = [0.8, 2.5, 3.0, 20.0];

/// What robots take.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Takes {
    Twists,
    Torques,
}

/// Largest torque of a wheel (N m).
pub(crate) const TORQUE_NM: f64 = 0.3;

/// The nominal model of robots that take torques: the paper's.
const PAPER: &str = "format = 1
[robot]
body_mass_kg = 1.5
body_yaw_inertia_kg_m2 = 0.009753
wheel_mass_kg = 0.064
wheel_spin_inertia_kg_m2 = 0.001168
wheel_yaw_inertia_kg_m2 = 0.000584
wheel_radius_m = 0.0365
half_track_m = 0.105
com_to_axle_m = 0.055
com_to_caster_m = 0.095
com_height_m = 0.0216
[motor]
nominal_voltage_v = 12.0
no_load_speed_rad_s = 36.65
stall_torque_nm = 0.78
[encoder]
counts_per_rev = 1856
";

/// The nominal model of robots that take twists.
const MODEL: &str = "format = 1\n[robot]\nwheel_radius_m = 0.033\nhalf_track_m = 0.08\n[encoder]\ncounts_per_rev = 4096\n";

/// Boxes and their files. They end with it.
pub(crate) struct Lab {
    folder: tempfile::TempDir,
    boxes: Vec<Child>,
}

/// A free port of this computer, below those that the system gives to connections: none takes it before a box listens.
pub(crate) fn port() -> u16 {
    static NEXT: AtomicU16 = AtomicU16::new(0);
    let first = 20_000 + (std::process::id() % 100) as u16 * 100;
    loop {
        let port = first + NEXT.fetch_add(1, Ordering::Relaxed) % 2_000;
        if std::net::TcpListener::bind(("127.0.0.1", port)).is_ok() {
            return port;
        }
    }
}

impl Lab {
    /// Boxes with these lines of `[effects]`, each behind a port of its own, for a lab whose file has the lines `more` at its
    /// head. `through`: the port at which a run finds a box that listens at another one.
    pub(crate) fn start(
        takes: Takes,
        effects: &[&str],
        more: &str,
        arguments: &[&str],
        through: impl Fn(u16) -> u16,
    ) -> Self {
        let folder = tempfile::tempdir().unwrap();
        let ports: Vec<u16> = effects.iter().map(|_| port()).collect();
        let found: Vec<u16> = ports.iter().map(|&own| through(own)).collect();
        let write =
            |name: &str, text: &str| std::fs::write(folder.path().join(name), text).unwrap();
        let nominal = match takes {
            Takes::Twists => MODEL,
            Takes::Torques => PAPER,
        };
        write("tb.toml", nominal);
        write("boxes.toml", &robots_toml(takes, &ports, more));
        write("robots.toml", &robots_toml(takes, &found, more));
        let mut boxes = Vec::new();
        for (i, effects) in (1..).zip(effects) {
            let model = format!("box{i}.toml");
            write(&model, &format!("{nominal}[effects]\n{effects}\n"));
            let (name, log, json) = (format!("r{i}"), format!("r{i}.csv"), format!("r{i}.json"));
            let mut all = vec!["robot-in-a-box", "boxes.toml", &name, "--robot", &model];
            all.extend(["--log", &log, "--json", &json]);
            all.extend(arguments);
            boxes.push(command(folder.path(), &all).spawn().unwrap());
        }
        Self { folder, boxes }
    }

    /// Boxes that listen where a run finds them.
    pub(crate) fn of(effects: &[&str]) -> Self {
        Self::start(Takes::Twists, effects, "", &[], |port| port)
    }

    /// As [`Self::of`], of boxes that take torques.
    pub(crate) fn by_torques(effects: &[&str]) -> Self {
        Self::start(Takes::Torques, effects, "", &[], |port| port)
    }

    pub(crate) fn folder(&self) -> &Path {
        self.folder.path()
    }

    pub(crate) fn file(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    /// Runs `slipstream` there, which must succeed, and returns what it prints.
    pub(crate) fn succeeds(&self, arguments: &[&str]) -> String {
        let output = self.runs(arguments);
        let said = String::from_utf8_lossy(&output.stderr).into_owned();
        assert!(output.status.success(), "{arguments:?}: {said}");
        String::from_utf8(output.stdout).unwrap()
    }

    /// Runs `slipstream` there.
    pub(crate) fn runs(&self, arguments: &[&str]) -> Output {
        command(self.folder(), arguments).output().unwrap()
    }

    /// Ends the boxes, so that what they have seen is written.
    pub(crate) fn end_boxes(&mut self) {
        for child in &mut self.boxes {
            signal(child.id(), Signal::INT);
        }
        for mut child in self.boxes.drain(..) {
            wait_for("the end of a box", Duration::from_secs(20), || {
                child.try_wait().unwrap().is_some()
            });
        }
    }

    /// Every change of what a box has followed: when (ns of the monotonic clock), v (m/s), w (rad/s).
    pub(crate) fn log(&self, robot: usize) -> Vec<(i64, [f64; 2])> {
        let text = std::fs::read_to_string(self.file(&format!("r{}.csv", robot + 1))).unwrap();
        let line = |line: &str| {
            let mut parts = line.split(',');
            let t_ns = parts.next()?.parse().ok()?;
            let mut number = || parts.next()?.parse().ok();
            Some((t_ns, [number()?, number()?]))
        };
        text.lines().filter_map(line).collect()
    }
}

impl Drop for Lab {
    fn drop(&mut self) {
        for child in &mut self.boxes {
            let _ = child.kill();
            let _ = child.wait();
        }
    }
}

fn robots_toml(takes: Takes, ports: &[u16], more: &str) -> String {
    let [v, w, a, alpha] = LIMITS;
    let mut text = format!(
        "format = 1\n{more}\n[limits]\nspeed_m_s = {v}\nyaw_rate_rad_s = {w}\nacceleration_m_s2 = {a}\n\
         yaw_acceleration_rad_s2 = {alpha}\n"
    );
    for (i, port) in (1..).zip(ports) {
        let kind = match (takes, i) {
            (Takes::Twists, 1) => "\"Twist\"".to_owned(),
            (Takes::Twists, _) => "\"TwistStamped\"".to_owned(),
            (Takes::Torques, _) => {
                format!("\"Float64MultiArray\", order = \"left_right\", torque_nm = {TORQUE_NM}")
            }
        };
        write!(
            text,
            "[robots.r{i}]\nconnect = \"tcp/127.0.0.1:{port}\"\nmodel = \"tb.toml\"\n\
             command = {{ topic = \"tb{i}/cmd_vel\", type = {kind} }}\n\
             wheels = {{ topic = \"tb{i}/joint_states\", right = \"wheel_right_joint\", left = \"wheel_left_joint\" }}\n\
             pose = {{ topic = \"vrpn/tb{i}/pose\" }}\n"
        )
        .unwrap();
        if takes == Takes::Torques {
            write!(
                text,
                "odometry = {{ topic = \"tb{i}/odom\" }}\nimu = {{ topic = \"tb{i}/imu\" }}\n"
            )
            .unwrap();
        }
    }
    text
}
