"""Writes one recording with images beside the topics of a robot: an MCAP file with chunks and index, a database, a ROS 1 bag.

usage: write_images.py OUT
"""

import sys
from pathlib import Path

import numpy as np
from mcap.writer import CompressionType
from mcap.writer import Writer as McapWriter
from rosbags.rosbag1 import Writer as Writer1
from rosbags.rosbag2 import StoragePlugin
from rosbags.rosbag2 import Writer as Writer2
from rosbags.typesys import Stores, get_typestore

ROS1 = get_typestore(Stores.ROS1_NOETIC)
ROS2 = get_typestore(Stores.ROS2_HUMBLE)
START_NS = 1_700_000_000_000_000_000
NOISE = np.random.default_rng(1).integers(0, 255, 100_000, dtype=np.uint8)


def messages(store):
    """(time in ns, topic, message): joint states and poses at 50 Hz, three images at once at 10 Hz."""
    types = store.types
    seq = {"seq": 0} if store is ROS1 else {}
    for k in range(100):
        t_ns = START_NS + k * 20_000_000
        stamp = types["builtin_interfaces/msg/Time"](sec=t_ns // 10**9, nanosec=t_ns % 10**9)
        header = types["std_msgs/msg/Header"](**seq, stamp=stamp, frame_id="world")
        yield t_ns, "/joint_states", types["sensor_msgs/msg/JointState"](
            header=header,
            name=["wheel_left_joint", "wheel_right_joint"],
            position=np.array([0.1 * k, 0.12 * k]),
            velocity=np.array([]),
            effort=np.array([]),
        )
        pose = types["geometry_msgs/msg/Pose"](
            position=types["geometry_msgs/msg/Point"](0.01 * k, 0.0, 0.0),
            orientation=types["geometry_msgs/msg/Quaternion"](0.0, 0.0, 0.0, 1.0),
        )
        yield t_ns, "/mocap/pose", types["geometry_msgs/msg/PoseStamped"](header=header, pose=pose)
        for _ in range(3 if k % 5 == 0 else 0):
            yield t_ns, "/camera/image", types["sensor_msgs/msg/Image"](
                header=header, height=100, width=1000, encoding="mono8", is_bigendian=0, step=1000, data=NOISE
            )


def write(writer, store, serialize):
    connections = {}
    for t_ns, topic, message in messages(store):
        if topic not in connections:
            connections[topic] = writer.add_connection(topic, message.__msgtype__, typestore=store)
        writer.write(connections[topic], t_ns, serialize(message, message.__msgtype__))


def write_mcap(path):
    """With the program of the format's authors: a chunk ends with the message that makes it too long."""
    with path.open("wb") as stream:
        writer = McapWriter(stream, chunk_size=50_000, compression=CompressionType.ZSTD)
        writer.start(profile="ros2", library="test")
        channels = {}
        for t_ns, topic, message in messages(ROS2):
            kind = message.__msgtype__
            if topic not in channels:
                definition = ROS2.generate_msgdef(kind, ros_version=2)[0].encode()
                channels[topic] = writer.register_channel(topic, "cdr", writer.register_schema(kind, "ros2msg", definition))
            writer.add_message(channels[topic], t_ns, bytes(ROS2.serialize_cdr(message, kind)), t_ns)
        writer.finish()


def main(out):
    out.mkdir(parents=True)
    write_mcap(out / "images.mcap")
    with Writer2(out / "images", version=9, storage_plugin=StoragePlugin.SQLITE3) as writer:
        write(writer, ROS2, ROS2.serialize_cdr)
    with Writer1(out / "images.bag") as writer:
        write(writer, ROS1, ROS1.serialize_ros1)


if __name__ == "__main__":
    main(Path(sys.argv[1]))
