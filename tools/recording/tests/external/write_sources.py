"""Writes bags of robots whose wheels are told in other ways than as joints with sides in their names.

usage: write_sources.py OUT
"""

import math
import sqlite3
import sys
from pathlib import Path

import numpy as np
from mcap.writer import Writer as WriterMcap
from rosbags.rosbag1 import Writer as Writer1
from rosbags.rosbag2 import StoragePlugin, Writer
from rosbags.typesys import Stores, get_types_from_msg, get_typestore
from write_guesses import (
    START_NS,
    STORE,
    TYPES,
    command,
    description,
    header,
    joint_state,
    odometry,
    pose,
    pose_stamped,
    pose_with_covariance,
    vector,
)

ROS1 = get_typestore(Stores.ROS1_NOETIC)
OWN = {
    "duckietown_msgs/msg/WheelEncoderStamped": "std_msgs/Header header\nint32 data\nuint16 resolution\nuint8 type",
    "turtlebot3_msgs/msg/SensorState": "uint8 BUMPER_FORWARD=1\nstd_msgs/Header header\nuint8 bumper\nfloat32 cliff\n"
    "int32 left_encoder\nint32 right_encoder\nfloat32 battery",
    "irobot_create_msgs/msg/WheelVels": "std_msgs/Header header\nfloat32 velocity_left\nfloat32 velocity_right",
    "base_msgs/msg/WheelStates": "std_msgs/Header header\n"
    + "".join(f"float64 {name}\n" for name in ["fr_position", "fl_position", "rr_position", "rl_position"])
    + "float32 right_command\nfloat32 left_command",
    "ackermann_msgs/msg/AckermannDrive": "float32 steering_angle\nfloat32 steering_angle_velocity\nfloat32 speed\n"
    "float32 acceleration\nfloat32 jerk",
    "ackermann_msgs/msg/AckermannDriveStamped": "std_msgs/Header header\nackermann_msgs/AckermannDrive drive",
    "base_msgs/msg/Motor": "string name\nfloat64 volts\nint64 counted",
    "base_msgs/msg/Telemetry": "bool on\nfloat64[<=4] cells\nbase_msgs/Motor[2] motors\nuint8 state",
}
for kind, text in OWN.items():
    types = get_types_from_msg(text, kind)
    STORE.register(types)
    ROS1.register(types)


def right(k):
    """The angle of the right wheel in row k (rad); the left one turns half as fast."""
    return 0.2 * k


def number(kind, side_factor, wrap=None):
    """A number alone in a message: 100 counts a radian."""

    def make(t_ns, k):
        count = round(100 * side_factor * right(k))
        if wrap:
            count = (count + wrap // 2) % wrap - wrap // 2
        return TYPES[kind](count)

    return kind, make


def encoder(side_factor):
    kind = "duckietown_msgs/msg/WheelEncoderStamped"
    return kind, lambda t_ns, k: STORE.types[kind](header(t_ns), round(100 * side_factor * right(k)), 135, 1)


def sensor_state():
    kind = "turtlebot3_msgs/msg/SensorState"
    return kind, lambda t_ns, k: STORE.types[kind](
        header(t_ns), k % 2, 0.5, round(50 * right(k)), round(100 * right(k)), 12.0 - 0.01 * k
    )


def wheel_speeds():
    kind = "irobot_create_msgs/msg/WheelVels"
    return kind, lambda t_ns, k: STORE.types[kind](header(t_ns), 2.0 + 0.1 * math.sin(k), 4.0 + 0.1 * math.sin(k))


def telemetry():
    kind, motor = "base_msgs/msg/Telemetry", "base_msgs/msg/Motor"

    def make(t_ns, k):
        motors = [STORE.types[motor](name, 1.5 * i, round(100 * i * right(k))) for i, name in [(0.5, "a"), (1, "bcd")]]
        return STORE.types[kind](True, np.array([3.7] * (k % 4)), motors, 7)

    return kind, make


def four():
    """A message with angles of four wheels, and what they were told."""
    kind = "base_msgs/msg/WheelStates"
    return kind, lambda t_ns, k: STORE.types[kind](
        header(t_ns), right(k), 0.5 * right(k), 0.9 * right(k), 0.4 * right(k), 0.1 * k, 0.2 * k
    )


def drive():
    kind = "ackermann_msgs/msg/AckermannDriveStamped"
    own = "ackermann_msgs/msg/AckermannDrive"
    return kind, lambda t_ns, k: STORE.types[kind](header(t_ns), STORE.types[own](0.1, 0.0, 1.0, 0.0, 0.0))


def counts():
    """Both counters in a list."""
    layout = TYPES["std_msgs/msg/MultiArrayLayout"]([], 0)
    kind = "std_msgs/msg/Int32MultiArray"
    return kind, lambda t_ns, k: TYPES[kind](
        layout, np.array([round(50 * right(k)), round(100 * right(k))], dtype=np.int32)
    )


def image():
    kind = "sensor_msgs/msg/Image"
    return kind, lambda t_ns, k: TYPES[kind](header(t_ns), 2, 2, "mono8", 0, 2, np.zeros(4, dtype=np.uint8))


def imu():
    kind = "sensor_msgs/msg/Imu"
    still = TYPES["geometry_msgs/msg/Quaternion"](0.0, 0.0, 0.0, 1.0)
    zeros = np.zeros(9)
    return kind, lambda t_ns, k: TYPES[kind](
        header(t_ns), still, zeros, vector(z=0.1), zeros, vector(x=0.01 * k, z=9.81), zeros
    )


def grid():
    kind = "nav_msgs/msg/OccupancyGrid"
    info = TYPES["nav_msgs/msg/MapMetaData"](TYPES["builtin_interfaces/msg/Time"](0, 0), 0.05, 2, 2, pose(0))
    return kind, lambda t_ns, k: TYPES[kind](header(t_ns), info, np.zeros(4, dtype=np.int8))


def idle_odometry(value):
    """An odometry whose twist is not filled."""
    kind, make = odometry()

    def idle(t_ns, k):
        message = make(t_ns, k)
        message.twist.twist = TYPES["geometry_msgs/msg/Twist"](vector(value), vector(z=value))
        return message

    return kind, idle


def odometry_pose():
    """The pose of an odometry, without its speeds."""
    kind = "geometry_msgs/msg/PoseStamped"
    return kind, lambda t_ns, k: TYPES[kind](header(t_ns, "odom"), pose(k))


def about(x, y, z, angle):
    """The rotation about an axis."""
    s, c = math.sin(angle / 2), math.cos(angle / 2)
    return x * s, y * s, z * s, c


def transform(t_ns, parent, child, place, rotation):
    return TYPES["geometry_msgs/msg/TransformStamped"](
        header(t_ns, parent),
        child,
        TYPES["geometry_msgs/msg/Transform"](vector(*place), TYPES["geometry_msgs/msg/Quaternion"](*rotation)),
    )


def tf(*links):
    """Links are (parent, child, function from row to place and rotation)."""
    return "tf2_msgs/msg/TFMessage", lambda t_ns, k: TYPES["tf2_msgs/msg/TFMessage"](
        [transform(t_ns, parent, child, *at(k)) for parent, child, at in links]
    )


def tf_once(*links):
    kind, make = tf(*links)
    return kind, lambda t_ns, k: make(t_ns, k) if k == 0 else None


STILL = (0.0, 0.0, 0.0, 1.0)
BASE = ("odom", "base_link", lambda k: ((0.01 * k, 0.0, 0.0), about(0, 0, 1, 0.02 * k)))
MAP = ("map", "odom", lambda k: ((0.001 * (k // 10), 0.0, 0.0), STILL))


def wheel(parent, child, y, factor, x=0.0):
    """A wheel that turns forward about the axis to the left."""
    return parent, child, lambda k: ((x, y, 0.05), about(0, 1, 0, factor * right(k)))


def fixed(parent, child, x, y, rotation=STILL):
    return parent, child, lambda k: ((x, y, 0.0), rotation)


URDF = (
    '<robot name="own"><link name="base_link"/>'
    + "".join(
        f'<link name="tyre_{k}"><collision><geometry><cylinder radius="0.05" length="0.02"/></geometry></collision></link>'
        f'<joint name="wheel_{k}" type="continuous"><parent link="base_link"/><child link="tyre_{k}"/>'
        f'<origin xyz="0 {y} 0"/><axis xyz="0 1 0"/></joint>'
        for k, y in [(1, 0.15), (2, -0.15)]
    )
    + "</robot>"
)

NUMBERED = joint_state("wheel_1", "wheel_2", "shoulder_pan_joint", "elbow_joint")
WHEEL_FRAMES = (wheel("base_link", "left_wheel_link", 0.15, 0.5), wheel("base_link", "right_wheel_link", -0.15, 1))
APART = {"/left_ticks": number("std_msgs/msg/Int32", 0.5), "/right_ticks": number("std_msgs/msg/Int32", 1)}

# Topics of each bag.
BAGS = {
    "everything": {
        "/cmd_vel": command(),
        "/cmd_vel_mux/input/teleop": command(),
        "/joint_states": NUMBERED,
        "/robot_description": description(URDF),
        **APART,
        "/tf": tf(BASE, MAP, *WHEEL_FRAMES),
        "/odom": idle_odometry(0.0),
        "/mocap/pose": pose_stamped(),
        "/amcl_pose": pose_with_covariance(),
        "/imu/data_raw": imu(),
        "/imu/data": imu(),
        "/gripper/joint_states": joint_state("left_finger_joint", "right_finger_joint"),
        "/camera/left/image_raw": image(),
        "/goal_pose": pose_stamped(),
        "/map": grid(),
    },
    "apart": {**APART, "/mocap/pose": pose_stamped()},
    "short": {
        "/lwheel": number("std_msgs/msg/Int16", 50, 65536),
        "/rwheel": number("std_msgs/msg/Int16", 100, 65536),
        "/mocap/pose": pose_stamped(),
    },
    "two": {
        "/r1/lwheel": number("std_msgs/msg/Int32", 0.5),
        "/r1/rwheel": number("std_msgs/msg/Int32", 1),
        "/r2/lwheel": number("std_msgs/msg/Int32", 5),
        "/r2/rwheel": number("std_msgs/msg/Int32", 10),
        "/mocap/r1/pose": pose_stamped(),
        "/mocap/r2/pose": pose_stamped(),
    },
    "stamped": {
        "/duckie/left_wheel_encoder_node/tick": encoder(0.5),
        "/duckie/right_wheel_encoder_node/tick": encoder(1),
        "/duckie/pose": pose_stamped(),
    },
    "four": {"/wheel_states": four(), "/drive": drive(), "/mocap/pose": pose_stamped()},
    "sensor_state": {"/sensor_state": sensor_state(), "/mocap/pose": pose_stamped()},
    "speeds": {"/wheel_vels": wheel_speeds(), "/mocap/pose": pose_stamped()},
    "lists": {"/encoders": counts(), "/telemetry": telemetry(), "/mocap/pose": pose_stamped()},
    "frames": {
        "/tf": tf(
            ("world", "base_link", BASE[2]),
            wheel("mount", "left_wheel_link", 0.1, -0.5),
            wheel("base_link", "right_wheel_link", -0.2, 1),
            # neither steering nor casters nor a sensor that spins
            ("base_link", "left_steer", lambda k: ((0.3, 0.2, 0.0), about(0, 0, 1, 0.3 * k))),
            ("base_link", "right_steer", lambda k: ((0.3, -0.2, 0.0), about(0, 0, 1, 0.3 * k))),
            wheel("left_steer", "front_left_wheel", 0.0, 0.5),
            wheel("right_steer", "front_right_wheel", 0.0, 1),
            ("base_link", "laser", lambda k: ((0.0, 0.0, 0.2), about(0, 0, 1, 0.5 * k))),
        ),
        # the left wheel's parent is mounted head down: its own axis points to the right
        "/tf_static": tf_once(("base_link", "mount", lambda k: ((0.0, 0.3, 0.1), about(1, 0, 0, math.pi)))),
    },
    "placed": {
        "/joint_states": joint_state("drive_a", "drive_b"),
        "/tf_static": tf_once(fixed("base_link", "drive_a_link", 0.0, 0.2), fixed("base_link", "drive_b_link", 0.0, -0.2)),
        "/mocap/pose": pose_stamped(),
    },
    "prefixed": {
        "/joint_states": joint_state("left_wheel", "right_wheel"),
        "/base/left_ticks": APART["/left_ticks"],
        "/base/right_ticks": APART["/right_ticks"],
        "/tf": tf(wheel("own/base_link", "own/left_wheel", 0.1, 0.5), wheel("own/base_link", "own/right_wheel", -0.1, 1)),
        "/mocap/pose": pose_stamped(),
    },
    "numbered": {"/joint_states": NUMBERED, "/mocap/pose": pose_stamped()},
    "poses": {"/odom_pose": odometry_pose(), "/mocap/pose": pose_stamped()},
    "arms": {
        "/joint_states": joint_state("left_wheel", "right_wheel"),
        "/manipulators/joint_states": joint_state("left_joint_1", "right_joint_1"),
        "/mocap/pose": pose_stamped(),
    },
    "not_a_number": {"/odom": idle_odometry(math.nan), "/mocap/pose": pose_stamped()},
}


def messages(topics, rows):
    """(time of reception, topic, type, message); topics of right wheels are 10 ms later."""
    for k in range(rows):
        for topic, (kind, make) in topics.items():
            t_ns = START_NS + k * 50_000_000 + (10_000_000 if topic[1:].startswith("r") else 0)
            message = make(t_ns, k)
            if message is not None:
                yield t_ns, topic, kind, message


def write(out, topics, plugin=StoragePlugin.MCAP, version=9, rows=100):
    with Writer(out, version=version, storage_plugin=plugin) as writer:
        connections = {topic: writer.add_connection(topic, kind, typestore=STORE) for topic, (kind, _) in topics.items()}
        for t_ns, topic, kind, message in messages(topics, rows):
            writer.write(connections[topic], t_ns, STORE.serialize_cdr(message, kind))


def ros1_message(kind, message):
    """The same message with the header of ROS 1."""
    if hasattr(message, "header"):
        own = message.header
        message.header = ROS1.types["std_msgs/msg/Header"](seq=5, stamp=own.stamp, frame_id=own.frame_id)
    return ROS1.serialize_ros1(message, kind)


def write_ros1(out, topics):
    with Writer1(out) as writer:
        connections = {topic: writer.add_connection(topic, kind, typestore=ROS1) for topic, (kind, _) in topics.items()}
        for t_ns, topic, kind, message in messages(topics, 100):
            writer.write(connections[topic], t_ns, ros1_message(kind, message))


def write_ros1_mcap(out, topics):
    """Messages of ROS 1 in an MCAP file, as converters write them."""
    with open(out, "wb") as stream:
        writer = WriterMcap(stream)
        writer.start()
        channels = {}
        for t_ns, topic, kind, message in messages(topics, 100):
            if topic not in channels:
                text, _ = ROS1.generate_msgdef(kind, ros_version=1)
                schema = writer.register_schema(kind.replace("/msg/", "/"), "ros1msg", text.encode())
                channels[topic] = writer.register_channel(topic, "ros1", schema)
            writer.add_message(channels[topic], t_ns, bytes(ros1_message(kind, message)), t_ns)
        writer.finish()


def write_json(out):
    """A pose in CDR, and wheels in JSON."""
    with open(out, "wb") as stream:
        writer = WriterMcap(stream)
        writer.start()
        text, _ = STORE.generate_msgdef("geometry_msgs/msg/PoseStamped", ros_version=2)
        schema = writer.register_schema("geometry_msgs/msg/PoseStamped", "ros2msg", text.encode())
        pose_channel = writer.register_channel("/mocap/pose", "cdr", schema)
        json_channel = writer.register_channel("/wheels", "json", 0)
        for t_ns, _, kind, message in messages({"/mocap/pose": pose_stamped()}, 100):
            writer.add_message(pose_channel, t_ns, bytes(STORE.serialize_cdr(message, kind)), t_ns)
            writer.add_message(json_channel, t_ns, b'{"left": 1}', t_ns)
        writer.finish()


def main(out):
    out.mkdir(parents=True, exist_ok=True)
    for name, topics in BAGS.items():
        write(out / name, topics)
    write(out / "apart_database", BAGS["apart"], StoragePlugin.SQLITE3, 8)
    write(out / "state_database", BAGS["sensor_state"], StoragePlugin.SQLITE3)
    # as ROS 2 wrote before Iron
    write(out / "state_undefined", BAGS["sensor_state"], StoragePlugin.SQLITE3, 8)
    [file] = (out / "state_undefined").glob("*.db3")
    with sqlite3.connect(file) as database:
        database.execute("DROP TABLE message_definitions")
    with sqlite3.connect(out / "apart_database" / "apart_database.db3") as database:
        database.execute("DROP TABLE message_definitions")
    write_ros1(out / "state.bag", BAGS["sensor_state"])
    write_json(out / "json.mcap")
    write_ros1_mcap(out / "state_ros1.mcap", BAGS["sensor_state"])
    write_ros1(out / "telemetry.bag", BAGS["lists"])


if __name__ == "__main__":
    main(Path(sys.argv[1]))
