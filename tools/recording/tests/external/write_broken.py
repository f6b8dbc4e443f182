"""Writes bags that are damaged, or that a careless program wrote.

usage: write_broken.py FOLDER OUT

FOLDER is what write_formats.py takes. OUT gets one bag of each kind.
"""

import shutil
import sys
from pathlib import Path

from rosbags.rosbag1 import Writer as Writer1
from rosbags.rosbag2 import StoragePlugin, Writer as Writer2
from write_formats import ROS1, ROS2, START_NS, TOPICS, message, read, write_ros1, write_ros2, write_split

LZ4 = Writer1.CompressionFormat.LZ4


def half(path, out):
    """The first half of a file."""
    content = path.read_bytes()
    out.write_bytes(content[: len(content) // 2])


def damage(path, out, at=0.5, count=4000):
    """A file with bytes of its middle set to zero."""
    content = bytearray(path.read_bytes())
    start = int(len(content) * at)
    content[start : start + count] = bytes(min(count, len(content) - start))
    out.write_bytes(content)


def without_index(path, out):
    """A ROS 1 bag as a recorder that was killed leaves it: the index at its end is missing."""
    content = bytearray(path.read_bytes())
    place = content.index(b"index_pos=") + len(b"index_pos=")
    index = int.from_bytes(content[place : place + 8], "little")
    content[place : place + 8] = bytes(8)
    out.write_bytes(content[:index])


def one_bag(out, events, change, second=None):
    """An MCAP bag whose messages are changed before they are written."""
    folder = out.with_suffix("")
    with Writer2(folder, version=9, storage_plugin=StoragePlugin.MCAP) as writer:
        connections = {}
        for t, stream, row in events:
            topic, kind = TOPICS[stream]
            if stream not in connections:
                connections[stream] = writer.add_connection(topic, kind, typestore=ROS2)
            t_ns = START_NS + t
            for own, log_ns in change(stream, t_ns, row):
                writer.write(connections[stream], log_ns, ROS2.serialize_cdr(own, kind))
    [file] = folder.glob("*.mcap")
    shutil.move(file, out)
    shutil.rmtree(folder)


def stamped(stream, stamp_ns, row):
    return message(ROS2, stream, stamp_ns, row)


def main(folder, out):
    events = read(folder)
    out.mkdir(parents=True, exist_ok=True)
    whole = out / "whole"
    whole.mkdir()
    write_ros1(events, whole / "ros1.bag")
    write_ros1(events, whole / "ros1_lz4.bag", LZ4)
    [mcap] = write_ros2(events, whole / "mcap", StoragePlugin.MCAP).glob("*.mcap")
    [db3] = write_ros2(events, whole / "db3", StoragePlugin.SQLITE3).glob("*.db3")

    half(mcap, out / "cut.mcap")
    half(db3, out / "cut.db3")
    half(whole / "ros1.bag", out / "cut.bag")
    half(whole / "ros1_lz4.bag", out / "cut_lz4.bag")
    damage(mcap, out / "index_lost.mcap", 0.98)
    without_index(whole / "ros1.bag", out / "index_lost.bag")
    damage(db3, out / "damaged.db3")
    damage(whole / "ros1_lz4.bag", out / "damaged_lz4.bag", count=200)
    write_split(events, out / "part_missing", StoragePlugin.MCAP, "mcap")
    (out / "part_missing" / "part_missing_1.mcap").unlink()
    write_split(events, out / "no_metadata", StoragePlugin.SQLITE3, "db3")
    (out / "no_metadata" / "metadata.yaml").unlink()

    one_bag(out / "stamps_zero.mcap", events, lambda s, t, row: [(stamped(s, 0, row), t)])
    one_bag(
        out / "simulated_time.mcap",
        events,
        lambda s, t, row: [(stamped(s, t - START_NS + 1, row), t + 3_000_000)],
    )

    def two_robots(stream, t_ns, row):
        if stream != "wheels":
            return [(stamped(stream, t_ns, row), t_ns)]
        other = row | {"angle_right_rad": 500.0 - 2 * row["angle_right_rad"], "angle_left_rad": 300.0}
        later = t_ns + 5_000_000
        return [(stamped(stream, t_ns, row), t_ns), (stamped(stream, later, other), later)]

    one_bag(out / "two_robots.mcap", events, two_robots)

    def no_values(stream, t_ns, row):
        own = stamped(stream, t_ns, row)
        if stream == "wheels":
            own.position = own.position[:0]
        return [(own, t_ns)]

    one_bag(out / "no_values.mcap", events, no_values)
    shutil.rmtree(whole)


if __name__ == "__main__":
    main(Path(sys.argv[1]), Path(sys.argv[2]))
