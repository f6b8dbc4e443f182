//! Wheels and their track, and where the tracked point is mounted.

use super::draft::Place::Reference;
use super::draft::{Draft, Drafted, Row, Shown, about, mostly};
use super::known::Known;
use super::sizes::{FACTOR, LENGTH_SHARE, MOUNTINGS_RAD, PAIR, SIZE, repeatability};
use crate::estimate::term::Link;
use crate::model::wheel_parameters::{
    ASYMMETRY, COMMON, OFFSET_X, OFFSET_Y, OFFSET_YAW, RUN_SCALE, RUN_TRACK, TRACK,
};

impl Known<'_> {
    pub(super) fn track(&self) -> Row {
        Row {
            name: "track",
            number: 0,
            moves: vec![(Reference(TRACK), 1.0)],
            // steering by skidding, the contact lies anywhere between the wheels and twice beyond
            prior: if self.streams.reference.skids {
                about(0.6)
            } else {
                mostly(SIZE)
            },
            resolution: FACTOR,
            repeatability: repeatability::TRACK,
        }
    }

    pub(super) fn geometry(&self, all: &mut Vec<Draft>) {
        let crude = self.streams.reference.crude_scale;
        let radii = self.factors(
            "radius",
            [
                vec![(Reference(COMMON), 1.0)],
                vec![(Reference(ASYMMETRY), 1.0)],
            ],
            [mostly(SIZE), mostly(PAIR)],
        );
        let names = ["right_scale", "left_scale"];
        let mut radius = if self.has_pose {
            Shown::wheels("wheel_radius", names)
        } else {
            let of = |name, half| (name, Link::Log, vec![(0, half)]);
            Shown::new("wheel_radius", vec![of(names[0], 0.5), of(names[1], -0.5)])
        };
        radius.confused = vec!["slip_ratio"];
        if self.is_commanded {
            radius.confused.push("motor_gain");
        } else if self.streams.drive.is_none() {
            radius.confused.push("encoder_scale");
        }
        let track = |place: usize| {
            Shown::new(
                "track_width",
                vec![("scale", Link::Log, vec![(place, 1.0)])],
            )
        };
        let [by_scale, by_track, _] = self.asked.by_run;
        if !self.has_pose {
            // a gyro sees turns alone: a common factor of both wheels and the track are one
            if by_track {
                self.of_runs(all, "track of runs", "run track", RUN_TRACK);
            } else {
                all.push(Draft::new("track", vec![self.track()], vec![track(0)]));
            }
            let mut rows = radii;
            let mut radii = Draft::new("radii", vec![rows.remove(1)], vec![radius]);
            radii.needs_relevance = self.is_commanded;
            all.push(radii);
            return;
        }
        let mut rows = radii;
        let mut shown = vec![radius];
        if by_scale {
            self.of_runs(all, "scale of runs", "run scale", RUN_SCALE);
            rows.remove(0);
            shown.clear();
        }
        if by_track {
            self.of_runs(all, "track of runs", "run track", RUN_TRACK);
        } else {
            shown.push(track(rows.len()));
            rows.push(self.track());
        }
        let mut geometry = Draft::new("geometry", rows, shown);
        geometry.needs_relevance = self.is_commanded;
        if crude != 0.0 && !by_scale {
            geometry =
                geometry.from([vec![crude, 0.0, 0.0][..2 + usize::from(!by_track)].to_vec()]);
        }
        all.push(geometry);
    }

    /// Scale or track of each run of today by itself.
    pub(super) fn of_runs(
        &self,
        all: &mut Vec<Draft>,
        name: &'static str,
        row: &'static str,
        place: usize,
    ) {
        let reference = self.streams.reference;
        let runs: Vec<usize> = (reference.before.runs..reference.runs.len()).collect();
        let deviation = match (place, reference.skids) {
            (RUN_TRACK, true) => 0.6,
            _ => 0.3,
        };
        let shown = runs.iter().enumerate().map(|(i, run)| {
            let values = if place == RUN_TRACK {
                vec![("scale", Link::Log, vec![(i, 1.0)])]
            } else {
                vec![("ratio", Link::LogLoss, vec![(i, 1.0)])]
            };
            let effect = if place == RUN_TRACK {
                "track_width"
            } else {
                "slip_ratio"
            };
            let mut shown = Shown::new(effect, values);
            shown.run = Some(*run);
            if place == RUN_SCALE {
                shown.confused = vec!["wheel_radius"];
            }
            shown
        });
        let mut draft = Draft::new(name, Vec::new(), shown.collect());
        draft.rows = runs
            .iter()
            .map(|run| Drafted::Run {
                name: row,
                run: *run,
                place,
                deviation,
            })
            .collect();
        draft.needs_relevance = self.is_commanded;
        all.push(draft);
    }

    pub(super) fn mounting(&self, all: &mut Vec<Draft>) {
        if !self.has_pose {
            return;
        }
        let length = |number: usize, index: usize| Row {
            name: "offset",
            number,
            moves: vec![(Reference(index), 1.0)],
            prior: about(4.0 * self.half_track_m),
            resolution: LENGTH_SHARE * self.half_track_m,
            repeatability: repeatability::OFFSET * 2.0 * self.half_track_m,
        };
        let mut rows = vec![length(0, OFFSET_X), length(1, OFFSET_Y)];
        let mut values = vec![
            ("x_m", Link::Identity, vec![(0, 1.0)]),
            ("y_m", Link::Identity, vec![(1, 1.0)]),
        ];
        let mut starts = Vec::new();
        if self.has_heading {
            rows.push(Row {
                name: "offset",
                number: 2,
                moves: vec![(Reference(OFFSET_YAW), 1.0)],
                prior: about(1.0),
                resolution: FACTOR,
                repeatability: repeatability::YAW_RAD,
            });
            values.push(("yaw_rad", Link::Identity, vec![(2, 1.0)]));
            starts.extend(MOUNTINGS_RAD.map(|yaw| vec![0.0, 0.0, yaw]));
        }
        let shown = vec![Shown::new("pose_offset", values)];
        all.push(Draft::new("offset", rows, shown).from(starts));
    }
}
