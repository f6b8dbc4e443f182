"""Makes the bag of this example: a cart that differs from its description, driven for 40 s under a camera.

usage: python make.py     (needs rosbags and numpy)
"""

import math
import shutil
from pathlib import Path

import numpy as np
from rosbags.rosbag2 import CompressionFormat, CompressionMode, StoragePlugin, Writer
from rosbags.typesys import Stores, get_typestore

# What cart.urdf and controller.yaml say.
RADIUS_M, HALF_TRACK_M = 0.05, 0.12
# What the cart is.
SCALE_RIGHT, SCALE_LEFT, TRACK = 0.96, 0.98, 1.05
CAMERA_X_M, CAMERA_Y_M = 0.09, 0.02
LATENCY_S, LAG_S = 0.08, 0.12
# Noise of the camera, of the encoders, and of the floor.
POSE_M, POSE_RAD, WHEEL_RAD, FLOOR_RAD_S = 0.002, 0.004, 0.001, 0.02

STEP_S, LENGTH_S, START_NS = 0.002, 40.0, 1_750_000_000_000_000_000
STORE = get_typestore(Stores.ROS2_HUMBLE)
TYPES = STORE.types


def command(t_s):
    """Speed (m/s) and yaw rate (rad/s) that are asked for: straight lines and curves, forwards and backwards."""
    phase = int(t_s / 2.5) % 8
    v = [0.4, 0.4, 0.25, 0.0, 0.35, -0.3, 0.45, 0.2][phase]
    w = [0.0, 0.9, -1.2, 1.5, -0.6, 0.4, 0.0, -1.6][phase]
    return v, w


def simulate():
    """Times, wheel angles (right, left) and poses of the axle's middle."""
    random = np.random.default_rng(7)
    steps = int(LENGTH_S / STEP_S)
    speed, angle, pose = np.zeros(2), np.zeros(2), np.zeros(3)
    angles, poses = [], []
    radius = RADIUS_M * np.array([SCALE_RIGHT, SCALE_LEFT])
    for k in range(steps):
        angles.append(angle.copy())
        poses.append(pose.copy())
        v, w = command(k * STEP_S)
        target = np.array([v + w * HALF_TRACK_M, v - w * HALF_TRACK_M]) / RADIUS_M
        before = speed.copy()
        speed += (target - speed) * (1 - math.exp(-STEP_S / LAG_S))
        mean = (before + speed) / 2
        angle += mean * STEP_S
        over_floor = (mean + random.normal(0, FLOOR_RAD_S / math.sqrt(STEP_S), 2)) * radius
        forward = over_floor.mean()
        turn = (over_floor[0] - over_floor[1]) / (2 * HALF_TRACK_M * TRACK)
        middle = pose[2] + turn * STEP_S / 2
        pose += np.array([forward * math.cos(middle), forward * math.sin(middle), turn]) * STEP_S
    return np.array(angles), np.array(poses)


def header(t_ns, frame):
    stamp = TYPES["builtin_interfaces/msg/Time"](sec=t_ns // 10**9, nanosec=t_ns % 10**9)
    return TYPES["std_msgs/msg/Header"](stamp=stamp, frame_id=frame)


def joint_state(t_ns, angle):
    return TYPES["sensor_msgs/msg/JointState"](
        header=header(t_ns, ""),
        name=["lift_joint", "left_wheel_joint", "right_wheel_joint"],
        position=np.array([0.2, angle[1], angle[0]]),
        velocity=np.array([]),
        effort=np.array([]),
    )


def twist(v, w):
    vector = TYPES["geometry_msgs/msg/Vector3"]
    return TYPES["geometry_msgs/msg/Twist"](vector(v, 0.0, 0.0), vector(0.0, 0.0, w))


def pose_stamped(t_ns, x, y, yaw):
    return TYPES["geometry_msgs/msg/PoseStamped"](
        header=header(t_ns, "world"),
        pose=TYPES["geometry_msgs/msg/Pose"](
            position=TYPES["geometry_msgs/msg/Point"](x, y, 0.0),
            orientation=TYPES["geometry_msgs/msg/Quaternion"](0.0, 0.0, math.sin(yaw / 2), math.cos(yaw / 2)),
        ),
    )


def messages():
    """Time of reception (ns), topic and message."""
    random = np.random.default_rng(11)
    angles, poses = simulate()
    for k in range(len(angles)):
        t_s = k * STEP_S
        t_ns = START_NS + round(t_s * 1e9)
        if k % 25 == 0:
            yield t_ns, "/cmd_vel", twist(*command(t_s))
        if k % 10 == 0:
            yield t_ns, "/joint_states", joint_state(t_ns, angles[k] + random.normal(0, WHEEL_RAD, 2))
        if k % 20 == 7:
            x, y, yaw = poses[k]
            x += CAMERA_X_M * math.cos(yaw) - CAMERA_Y_M * math.sin(yaw) + random.normal(0, POSE_M)
            y += CAMERA_X_M * math.sin(yaw) + CAMERA_Y_M * math.cos(yaw) + random.normal(0, POSE_M)
            late_ns = t_ns + round(LATENCY_S * 1e9)
            yield late_ns, "/mocap/cart/pose", pose_stamped(late_ns, x, y, yaw + random.normal(0, POSE_RAD))


def main(folder):
    shutil.rmtree(folder, ignore_errors=True)
    writer = Writer(folder, version=9, storage_plugin=StoragePlugin.MCAP)
    writer.set_compression(CompressionMode.STORAGE, CompressionFormat.ZSTD)
    connections = {}
    with writer:
        for t_ns, topic, message in sorted(messages(), key=lambda item: item[0]):
            kind = message.__msgtype__
            if topic not in connections:
                connections[topic] = writer.add_connection(topic, kind, typestore=STORE)
            writer.write(connections[topic], t_ns, STORE.serialize_cdr(message, kind))


if __name__ == "__main__":
    main(Path(__file__).with_name("bag"))
