"""Writes bags whose poses need several transforms, one after the other. All motions are known in closed form.

usage: write_chains.py OUT
"""

import sys
from math import cos, pi, sin
from pathlib import Path

import numpy as np
from rosbags.rosbag2 import StoragePlugin, Writer
from rosbags.typesys import Stores, get_typestore

STORE = get_typestore(Stores.ROS2_HUMBLE)
TYPES = STORE.types
START_NS = 1_700_000_000_000_000_000
SECOND_NS = 1_000_000_000


def header(t_ns, frame):
    stamp = TYPES["builtin_interfaces/msg/Time"](sec=t_ns // SECOND_NS, nanosec=t_ns % SECOND_NS)
    return TYPES["std_msgs/msg/Header"](stamp=stamp, frame_id=frame)


def tf(t_ns, parent, child, x, y, yaw):
    transform = TYPES["geometry_msgs/msg/Transform"](
        TYPES["geometry_msgs/msg/Vector3"](x, y, 0.0),
        TYPES["geometry_msgs/msg/Quaternion"](0.0, 0.0, sin(yaw / 2), cos(yaw / 2)),
    )
    stamped = TYPES["geometry_msgs/msg/TransformStamped"](header(t_ns, parent), child, transform)
    return TYPES["tf2_msgs/msg/TFMessage"]([stamped])


def on_circle(t_s):
    """A circle of 2 m around (0, 2), at 0.5 rad/s."""
    return 2 * sin(t_s / 2), 2 - 2 * cos(t_s / 2), t_s / 2


def correction(k):
    """What a localisation has found after k updates: map to odom."""
    return 1 + 0.1 * k, -0.5, 0.02 * k


def wheels(t_ns, k):
    return TYPES["sensor_msgs/msg/JointState"](
        header=header(t_ns, ""),
        name=["wheel_left_joint", "wheel_right_joint"],
        position=np.array([0.1 * k, 0.12 * k]),
        velocity=np.zeros(2),
        effort=np.array([]),
    )


def odometry(out):
    """Joint states and odom to base_link at 50 Hz for 10 s: (time of reception, topic, message)."""
    for k in range(501):
        t_ns = START_NS + k * 20_000_000
        yield t_ns + 1_000_000, "/joint_states", wheels(t_ns, k)
        if out != "captured":
            yield t_ns + 1_000_000, "/tf", tf(t_ns, "odom", "base_link", *on_circle(k * 0.02))


def localised(ahead_ns):
    """map to odom at 10 Hz, 7 ms after odometry; a new one each second."""
    for k in range(100):
        t_ns = START_NS + k * 100_000_000 + 7_000_000
        yield t_ns + (0 if ahead_ns else 5_000_000), "/tf", tf(t_ns + ahead_ns, "map", "odom", *correction(k // 10))


def with_world():
    """As localised, and where the map lies in the world: again and again, as ROS 1 does."""
    yield from localised(0)
    for k in range(200):
        t_ns = START_NS + k * 50_000_000
        yield t_ns, "/tf", tf(t_ns, "world", "map", 5.0, 5.0, 0.0)


def captured():
    """A marker on a circle, at 100 Hz; where it is on the robot is said at the end, with a stamp of 0."""
    for k in range(1001):
        t_ns = START_NS + k * 10_000_000 + 3_000_000
        yield t_ns + 1_000_000, "/tf", tf(t_ns, "world", "marker", *on_circle(k * 0.01 + 0.003))
    yield START_NS + 11 * SECOND_NS, "/tf_static", tf(0, "marker", "base_link", -0.2, 0.1, pi / 2)


def constant():
    """A localisation that finds nothing."""
    for k in range(100):
        t_ns = START_NS + k * 100_000_000
        yield t_ns, "/tf", tf(t_ns, "map", "odom", 1.0, 0.0, 0.0)


BAGS = {
    "localised": lambda: localised(0),
    "with_world": with_world,
    "ahead": lambda: localised(900_000_000),
    "captured": captured,
    "constant": constant,
    "odometry": lambda: (),
}


def main(out):
    out.mkdir(parents=True, exist_ok=True)
    for name, more in BAGS.items():
        messages = sorted([*odometry(name), *more()], key=lambda own: own[0])
        with Writer(out / name, version=9, storage_plugin=StoragePlugin.MCAP) as writer:
            connections = {}
            for t_ns, topic, message in messages:
                if topic not in connections:
                    connections[topic] = writer.add_connection(topic, message.__msgtype__, typestore=STORE)
                writer.write(connections[topic], t_ns, STORE.serialize_cdr(message, message.__msgtype__))


if __name__ == "__main__":
    main(Path(sys.argv[1]))
