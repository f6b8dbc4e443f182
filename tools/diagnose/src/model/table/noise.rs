//! Noise sizes.

use super::draft::about;
use super::known::Asked;
use super::parameters::{Key, Table, robot};
use crate::estimate::pairs;
use crate::model::command_to_wheels::{CommandToWheels, TIMES};
use crate::model::drive::DRIVE;
use crate::model::run::is_process;
use crate::model::wheel_parameters::RUN_NOISE_FIRST;

impl Table {
    /// Noise sizes: the sensors' of all runs together, beside first guesses of each run; what moves the pose of
    /// each run by itself, for floors differ.
    pub(super) fn add_noise(&mut self, asked: &Asked<'_>) {
        let reference = asked.streams.reference;
        let shared = reference.shared(0);
        let (of_runs, shares): (Vec<usize>, Vec<usize>) = reference
            .noise()
            .into_iter()
            .partition(|index| *index < shared);
        let width = reference.of_run(1, 0) - reference.of_run(0, 0);
        let place = |index: usize| {
            let beyond = index - reference.of_run(0, 0);
            (beyond / width, beyond % width)
        };
        let mut numbers: Vec<usize> = of_runs.iter().map(|index| place(*index).1).collect();
        numbers.sort_unstable();
        numbers.dedup();
        let key = |name, robot, number| Key {
            name,
            robot,
            number,
            is_shared: false,
        };
        for number in &numbers {
            let own = of_runs.iter().filter(|index| place(**index).1 == *number);
            let weights = own.map(|index| (*index, 1.0)).collect();
            self.noise_of(key("noise", None, *number), weights, false, 2.0);
        }
        if reference.runs.len() > 1 {
            for (run, own) in reference.runs.iter().enumerate() {
                let of = robot(own.robot, reference.before.robots);
                let process = of_runs.iter().filter(|index| {
                    let (of, number) = place(**index);
                    of == run && is_process(number - RUN_NOISE_FIRST)
                });
                let weights = process.map(|index| (*index, 1.0)).collect();
                self.noise_of(key("noise of a run", Some(of), 0), weights, false, 1.0);
            }
        }
        for index in shares {
            let own = key("share", None, index - shared);
            self.noise_of(own, vec![(index, 1.0)], true, 2.0);
        }
        let first = asked.streams.drive_first();
        for index in asked.streams.drive.iter().flat_map(|drive| drive.noise()) {
            let is_share = index == CommandToWheels::SHARE;
            let number = index - DRIVE;
            let key = Key {
                name: if is_share {
                    "share of the drive"
                } else {
                    "noise of the drive"
                },
                robot: None,
                number,
                is_shared: false,
            };
            // the time of a disturbance is known to lie between some tenths of a second and some seconds
            let deviation = if TIMES.contains(&number) { 1.0 } else { 2.0 };
            self.noise_of(key, vec![(first + index, 1.0)], is_share, deviation);
        }
    }

    fn noise_of(&mut self, key: Key, weights: Vec<(usize, f64)>, is_share: bool, deviation: f64) {
        let (deviation, longest) = if is_share {
            (pairs::DEVIATION, pairs::LONGEST)
        } else {
            (deviation, 1.0)
        };
        let at = self.push(key, weights, about(deviation), longest);
        self.noise.push(at);
    }
}
