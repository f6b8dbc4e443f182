"""A robot that shares no code with slipstream: eclipse-zenoh carries its topics, rosbags makes and reads its messages.

Usage: peer.py PORT WIRE OUT.json. It follows the commands that it hears without error until its input ends, and writes what
it heard and sent.
"""

import json
import math
import sys
import threading
import time

import numpy as np
import zenoh
from rosbags.typesys import Stores, get_typestore

PORT, WIRE, OUT = sys.argv[1], sys.argv[2], sys.argv[3]
RADIUS_M, HALF_TRACK_M = 0.033, 0.08
DOMAIN = 7

types = get_typestore(Stores.ROS2_JAZZY)
Header = types.types["std_msgs/msg/Header"]
Time = types.types["builtin_interfaces/msg/Time"]


def key(topic, kind):
    """The key of a topic whose messages have this type."""
    if WIRE == "ros2dds":
        return topic
    package, _, name = kind.split("/")
    return f"{DOMAIN}/{topic}/{package}::msg::dds_::{name}_/{types.hash_rihs01(kind)}"


def header():
    now = time.time_ns()
    return Header(stamp=Time(sec=now // 10**9, nanosec=now % 10**9), frame_id="world")


lock = threading.Lock()
twist = [0.0, 0.0]
heard, sent, attachments = [], [], []


def on_command(sample):
    message = types.deserialize_cdr(bytes(sample.payload), "geometry_msgs/msg/TwistStamped")
    with lock:
        twist[0], twist[1] = message.twist.linear.x, message.twist.angular.z
        heard.append([twist[0], twist[1]])
        if sample.attachment is not None:
            attachments.append(bytes(sample.attachment).hex())


config = zenoh.Config()
config.insert_json5("mode", '"peer"')
config.insert_json5("listen/endpoints", json.dumps([f"tcp/127.0.0.1:{PORT}"]))
config.insert_json5("scouting/multicast/enabled", "false")
session = zenoh.open(config)
session.declare_subscriber(key("tb1/cmd_vel", "geometry_msgs/msg/TwistStamped"), on_command)
joints = session.declare_publisher(key("tb1/joint_states", "sensor_msgs/msg/JointState"))
poses = session.declare_publisher(key("vrpn/tb1/pose", "geometry_msgs/msg/PoseStamped"))

over = threading.Event()
threading.Thread(target=lambda: (sys.stdin.read(), over.set()), daemon=True).start()

JointState = types.types["sensor_msgs/msg/JointState"]
PoseStamped = types.types["geometry_msgs/msg/PoseStamped"]
Pose = types.types["geometry_msgs/msg/Pose"]
Point = types.types["geometry_msgs/msg/Point"]
Quaternion = types.types["geometry_msgs/msg/Quaternion"]

x, y, yaw = 0.6096, 0.0, 0.0
right, left = 3.0, -2.0
last = time.monotonic()
while not over.is_set():
    time.sleep(0.02)
    now = time.monotonic()
    with lock:
        v, w = twist
    dt, last = now - last, now
    x += v * math.cos(yaw) * dt
    y += v * math.sin(yaw) * dt
    yaw += w * dt
    right += (v + HALF_TRACK_M * w) / RADIUS_M * dt
    left += (v - HALF_TRACK_M * w) / RADIUS_M * dt
    state = JointState(
        header=header(),
        name=["caster", "wheel_left_joint", "wheel_right_joint"],
        position=np.array([0.0, left, right]),
        velocity=np.array([]),
        effort=np.array([]),
    )
    joints.put(bytes(types.serialize_cdr(state, "sensor_msgs/msg/JointState")))
    pose = PoseStamped(
        header=header(),
        pose=Pose(
            position=Point(x=x, y=y, z=0.1),
            orientation=Quaternion(x=0.0, y=0.0, z=math.sin(yaw / 2), w=math.cos(yaw / 2)),
        ),
    )
    poses.put(bytes(types.serialize_cdr(pose, "geometry_msgs/msg/PoseStamped")))
    sent.append([x, y])

with open(OUT, "w") as file:
    json.dump({"heard": heard, "sent": sent, "attachments": attachments}, file)
session.close()
