//! The runs of each machine, which are judged together.

use super::motion::Windows;
use super::report::Finding;
use super::{wheel_scale, wheels};
use crate::recording::Recording;

/// What a run adds to its machine: the motion, and what torques tell.
pub(super) struct OfRun {
    pub(super) windows: Windows,
    pub(super) of_torques: Vec<Finding>,
}

/// One machine: its first run, and the windows of all.
struct MachineWindows<'a> {
    /// The robot, and the recording of the first run; `None` where all robots of a recording are one machine.
    of: Option<&'a str>,
    recording: usize,
    robot: &'a str,
    windows: Windows,
}

/// All machines, and what is said of them behind what the wheels alone tell.
#[derive(Default)]
pub(super) struct Machines<'a> {
    all: Vec<MachineWindows<'a>>,
    /// What torques tell, with the number of its recording.
    of_torques: Vec<(usize, Finding)>,
}

impl<'a> Machines<'a> {
    /// Adds a run of a robot in the recording of this number. Robots of one name are one machine in several
    /// recordings, and all of them are in recordings of the same robot.
    pub(super) fn add(&mut self, recording: (usize, &'a Recording), robot: &'a str, run: OfRun) {
        let (number, recording) = recording;
        let OfRun {
            windows,
            of_torques,
        } = run;
        let of = (!recording.same_robot).then_some(robot);
        let of_torques = of_torques.into_iter().map(|finding| (number, finding));
        self.of_torques.extend(of_torques);
        match self.all.iter_mut().find(|machine| machine.of == of) {
            Some(machine) => machine.windows.append(windows),
            None => self.all.push(MachineWindows {
                of,
                recording: number,
                robot,
                windows,
            }),
        }
    }

    /// What all runs of each machine tell of its wheels, with the number of its first recording.
    pub(super) fn findings(self) -> Vec<(usize, Finding)> {
        let mut all = Vec::new();
        for machine in self.all {
            let mut findings = Vec::new();
            wheel_scale::check(machine.robot, &machine.windows, &mut findings);
            wheels::check(machine.robot, &machine.windows, &mut findings);
            all.extend(findings.into_iter().map(|own| (machine.recording, own)));
        }
        all.extend(self.of_torques);
        all
    }
}
