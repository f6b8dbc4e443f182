"""Writes one recording as bags of every kind, as another robot would, with other programs.

usage: write_formats.py FOLDER OUT

FOLDER is a folder of CSV files of one robot with wheels and poses. OUT gets: csv (a folder of CSV files whose wheels are
angles), plain.mcap, plain.db3, split_mcap, split_db3_zstd, messages_zstd, ros1.bag, ros1_lz4.bag, ros1_bz2.bag. Bags have Unix time, names that
the format does not define, and a third joint.
"""

import csv
import math
import shutil
import sys
from pathlib import Path

import numpy as np
from rosbags.rosbag1 import Writer as Writer1
from rosbags.rosbag2 import CompressionFormat, CompressionMode, StoragePlugin
from rosbags.rosbag2 import Writer as Writer2
from rosbags.typesys import Stores, get_typestore

START_NS = 1_700_000_000_000_000_000
ROS1 = get_typestore(Stores.ROS1_NOETIC)
ROS2 = get_typestore(Stores.ROS2_HUMBLE)
TOPICS = {
    "wheels": ("/base/joint_states", "sensor_msgs/msg/JointState"),
    "pose": ("/vicon/cart/pose", "geometry_msgs/msg/PoseStamped"),
    "command": ("/cmd_vel", "geometry_msgs/msg/Twist"),
}


def rows(path):
    """The rows of a CSV file as dictionaries of numbers."""
    if not path.exists():
        return []
    with path.open() as stream:
        return [{name: float(cell) for name, cell in row.items()} for row in csv.DictReader(stream)]


def ns(t_s):
    return round(t_s * 1e9)


def read(folder):
    """Rows of the robot's streams: (time in ns, stream, row), in the order of time."""
    import tomllib

    description = tomllib.loads((folder / "recording.toml").read_text())
    name, robot = next(iter(description["robots"].items()))
    wheels = rows(folder / name / "wheels.csv")
    if wheels and "ticks_right" in wheels[0]:
        per_count = math.tau / robot["encoder_counts_per_rev"]
        for row in wheels:
            row["angle_right_rad"] = row.pop("ticks_right") * per_count
            row["angle_left_rad"] = row.pop("ticks_left") * per_count
    streams = {
        "command": rows(folder / name / "command.csv"),
        "wheels": wheels,
        "pose": rows(folder / name / "pose.csv"),
    }
    return sorted(
        ((ns(row["t_s"]), stream, row) for stream, own in streams.items() for row in own),
        key=lambda item: item[0],
    )


def write_csv(events, folder):
    """The folder of CSV files: times since the first row, wheels as angles."""
    start = events[0][0]
    (folder / "robot").mkdir(parents=True)
    (folder / "recording.toml").write_text('format = 1\n[robots.robot]\npose_point = "axle"\n')
    for stream in TOPICS:
        own = [(t, row) for t, kind, row in events if kind == stream]
        if not own:
            continue
        names = [name for name in own[0][1] if name != "t_s"]
        with (folder / "robot" / f"{stream}.csv").open("w") as out:
            print("t_s", *names, sep=",", file=out)
            for t, row in own:
                print(repr((t - start) / 1e9), *(repr(row[name]) for name in names), sep=",", file=out)


def message(store, stream, t_ns, row):
    """The message of a row."""
    types = store.types
    seq = {"seq": 0} if store is ROS1 else {}
    stamp = types["builtin_interfaces/msg/Time"](sec=t_ns // 10**9, nanosec=t_ns % 10**9)
    header = types["std_msgs/msg/Header"](**seq, stamp=stamp, frame_id="world")
    vector = types["geometry_msgs/msg/Vector3"]
    if stream == "wheels":
        return types["sensor_msgs/msg/JointState"](
            header=header,
            name=["pan_tilt_joint", "wheel_left_joint", "wheel_right_joint"],
            position=np.array([0.3, row["angle_left_rad"], row["angle_right_rad"]]),
            velocity=np.array([]),
            effort=np.array([]),
        )
    if stream == "command":
        return types["geometry_msgs/msg/Twist"](
            linear=vector(row["v_m_s"], 0.0, 0.0), angular=vector(0.0, 0.0, row["w_rad_s"])
        )
    half = row["yaw_rad"] / 2
    return types["geometry_msgs/msg/PoseStamped"](
        header=header,
        pose=types["geometry_msgs/msg/Pose"](
            position=types["geometry_msgs/msg/Point"](row["x_m"], row["y_m"], 0.0),
            orientation=types["geometry_msgs/msg/Quaternion"](0.0, 0.0, math.sin(half), math.cos(half)),
        ),
    )


def write(writer, store, serialize, events):
    """Writes all events with an open writer."""
    connections = {}
    for t, stream, row in events:
        topic, kind = TOPICS[stream]
        if stream not in connections:
            connections[stream] = writer.add_connection(topic, kind, typestore=store)
        t_ns = START_NS + t
        writer.write(connections[stream], t_ns, serialize(message(store, stream, t_ns, row), kind))


def write_ros2(events, folder, storage, compression=None):
    writer = Writer2(folder, version=9, storage_plugin=storage)
    if compression:
        writer.set_compression(compression, CompressionFormat.ZSTD)
    with writer:
        write(writer, ROS2, ROS2.serialize_cdr, events)
    return folder


def write_ros1(events, path, compression=None):
    writer = Writer1(path)
    if compression:
        writer.set_compression(compression)
    with writer:
        write(writer, ROS1, ROS1.serialize_ros1, events)


def write_split(events, folder, storage, ending, compression=None):
    """A bag of three files, each with a third of the time, as `ros2 bag record --max-bag-duration` writes it."""
    folder.mkdir()
    third = len(events) // 3
    parts = [events[:third], events[third : 2 * third], events[2 * third :]]
    names = []
    for k, part in enumerate(parts):
        own = write_ros2(part, folder / f"part{k}", storage, compression)
        [file] = [file for file in own.iterdir() if file.name != "metadata.yaml"]
        name = f"{folder.name}_{k}.{ending}"
        file.rename(folder / name)
        names.append(name)
        shutil.rmtree(own)
    files = "\n".join(f"  - {name}" for name in names)
    (folder / "metadata.yaml").write_text(
        f"rosbag2_bagfile_information:\n  version: 5\n  relative_file_paths:\n{files}\n"
    )


def main(folder, out):
    events = read(folder)
    out.mkdir(parents=True, exist_ok=True)
    write_csv(events, out / "csv")
    for storage, ending in [(StoragePlugin.MCAP, "mcap"), (StoragePlugin.SQLITE3, "db3")]:
        own = write_ros2(events, out / f"whole_{ending}", storage)
        [file] = own.glob(f"*.{ending}")
        shutil.copy(file, out / f"plain.{ending}")
    mode = CompressionMode
    write_split(events, out / "split_mcap", StoragePlugin.MCAP, "mcap")
    write_split(events, out / "split_db3_zstd", StoragePlugin.SQLITE3, "db3.zstd", mode.FILE)
    write_ros2(events, out / "messages_zstd", StoragePlugin.SQLITE3, mode.MESSAGE)
    write_ros1(events, out / "ros1.bag")
    write_ros1(events, out / "ros1_lz4.bag", Writer1.CompressionFormat.LZ4)
    write_ros1(events, out / "ros1_bz2.bag", Writer1.CompressionFormat.BZ2)


if __name__ == "__main__":
    main(Path(sys.argv[1]), Path(sys.argv[2]))
