//! Pages about the files of a recording and the model of a robot.

use slipstream_bus::RobotModel;
use slipstream_recording::{
    Field, LINKS, ROUND_TRIPS, StreamKind, TIME, recording_toml as recording, robot_toml as robot,
};

use crate::markdown::{code, head, table};

fn fields(fields: &[Field], name: &str) -> String {
    let rows = fields.iter().map(|field| {
        vec![
            code(field.name),
            field.unit.to_owned(),
            field.meaning.to_owned(),
        ]
    });
    table(&[name, "unit", "meaning"], rows)
}

fn keys(title: &str, keys: &[Field]) -> String {
    let title = format!("\n## {title}\n");
    if keys.iter().all(|key| key.symbol.is_empty()) {
        return title + &fields(keys, "key");
    }
    let rows = keys.iter().map(|key| {
        vec![
            code(key.name),
            key.unit.to_owned(),
            key.symbol.to_owned(),
            key.meaning.to_owned(),
        ]
    });
    title + &table(&["key", "unit", "symbol", "meaning"], rows)
}

pub(crate) fn columns() -> String {
    let mut text = head("CSV files and their columns", "`tools/recording/src/table`");
    text += "
A recording is a folder: `recording.toml`, and one folder for each robot with one CSV file for each stream. Each stream
keeps its own rate and times. Any file may be missing. A cell may be empty where a sensor did not see that component.
Columns that are not listed here are kept, with a warning. x points forward, y to the left, yaw is counter-clockwise.

Every file of a robot begins with this column:
";
    text += &fields(&[TIME], "column");
    for kind in StreamKind::ALL {
        text += &format!("\n## {}.csv\n\n{}\n", kind.name(), kind.meaning());
        let sets = kind.column_sets();
        if sets.len() > 1 {
            text += "\nThe file has one of these sets of columns.\n";
        }
        for set in sets {
            text += &match set.required {
                all if all == set.columns.len() => String::new(),
                0 => "\nAny of these columns; the others may be missing.\n".to_owned(),
                1 => "\nThe first column is required.\n".to_owned(),
                some => format!("\nThe first {some} columns are required.\n"),
            };
            text += &fields(set.columns, "column");
        }
    }
    text += "\n## links.csv\n\nPosition messages between robots. It stands beside the folders of the robots, and has no `t_s`.\n";
    text += &fields(&LINKS, "column");
    text += "\n## rtt.csv\n\nRound trips that were measured on a network, to be replayed as delay of links. It needs no robot, and has no `t_s`.\n";
    text + &fields(&ROUND_TRIPS, "column")
}

pub(crate) fn recording_toml() -> String {
    let source = "`tools/recording/src/toml_files/recording_toml.rs`";
    let mut text = head("recording.toml", source);
    text += "
The description of a recording. Keys that are not listed here are kept as notes.

```toml
format = 1
name = \"corridor\"
origin = \"the small robot, motion capture\"
[robots.r1]
encoder_counts_per_rev = 1856
pose_point = \"axle\"
[robots.r1.noise]
pose_m = 0.002
```
";
    text += &keys("The file", &recording::FILE);
    text += &keys("[robots.NAME]", &recording::ROBOT);
    text + &keys("[robots.NAME.noise]", &recording::NOISE)
}

pub(crate) fn robot_toml() -> String {
    let source = "`tools/recording/src/toml_files/robot_toml.rs`";
    let mut text = head("robot.toml", source);
    text += &format!(
        "
The model of a robot. Symbols are those of the paper ([glossary](../glossary.md)). A key that is absent is unknown, not
zero. A kinematic model has `wheel_radius_m` and `half_track_m` alone: enough where speeds are commanded, or nothing is.
A dynamic model has all keys of `[robot]`. Keys that are not listed here are an error.

This is the robot of the paper, on the floor of the paper:

```toml
{}```
",
        robot::to_text(&RobotModel::paper_with_slip())
    );
    text += &keys("The file", &robot::FILE);
    text += &keys("[robot]", &robot::BODY);
    text += &keys("[motor]", &robot::MOTOR);
    text += "\nWith a voltage V, the torque at the wheel is τ_stall V / V_nominal − (τ_stall / ω_0) ω. \
             Where masses are not given, wheels turn as fast as motors without a load: ω = ω_0 V / V_nominal.\n";
    text += &keys("[encoder]", &robot::ENCODER);
    text += "\n## [effects]\n\nOne key for each effect, with its parameters: `id = { … }`, or `id = [{ … }, { … }]` where it occurs more than once. \
             The [catalogue of effects](effects.md) lists ids and parameters.\n";
    text
}
