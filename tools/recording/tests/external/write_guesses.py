"""Writes bags with the topics of typical robots, to see what a guess makes of them.

usage: write_guesses.py OUT
"""

import sys
from pathlib import Path

import numpy as np
from rosbags.rosbag2 import StoragePlugin, Writer
from rosbags.typesys import Stores, get_typestore

STORE = get_typestore(Stores.ROS2_HUMBLE)
TYPES = STORE.types
START_NS = 1_700_000_000_000_000_000


def header(t_ns, frame="odom"):
    stamp = TYPES["builtin_interfaces/msg/Time"](sec=t_ns // 10**9, nanosec=t_ns % 10**9)
    return TYPES["std_msgs/msg/Header"](stamp=stamp, frame_id=frame)


def vector(x=0.0, y=0.0, z=0.0):
    return TYPES["geometry_msgs/msg/Vector3"](x, y, z)


def pose(k):
    return TYPES["geometry_msgs/msg/Pose"](
        position=TYPES["geometry_msgs/msg/Point"](0.01 * k, 0.0, 0.0),
        orientation=TYPES["geometry_msgs/msg/Quaternion"](0.0, 0.0, 0.0, 1.0),
    )


def twist(k):
    return TYPES["geometry_msgs/msg/Twist"](vector(0.2), vector(z=0.01 * k))


def joint_state(*names):
    def make(t_ns, k):
        return TYPES["sensor_msgs/msg/JointState"](
            header=header(t_ns),
            name=list(names),
            position=np.array([0.1 * k + i for i in range(len(names))]),
            velocity=np.zeros(len(names)),
            effort=np.array([]),
        )

    return "sensor_msgs/msg/JointState", make


def odometry(frame="odom"):
    def make(t_ns, k):
        return TYPES["nav_msgs/msg/Odometry"](
            header=header(t_ns, frame),
            child_frame_id="base_link",
            pose=TYPES["geometry_msgs/msg/PoseWithCovariance"](pose(k), np.zeros(36)),
            twist=TYPES["geometry_msgs/msg/TwistWithCovariance"](twist(k), np.zeros(36)),
        )

    return "nav_msgs/msg/Odometry", make


def pose_stamped():
    return "geometry_msgs/msg/PoseStamped", lambda t_ns, k: TYPES["geometry_msgs/msg/PoseStamped"](
        header(t_ns, "world"), pose(k)
    )


def pose_with_covariance():
    return "geometry_msgs/msg/PoseWithCovarianceStamped", lambda t_ns, k: TYPES[
        "geometry_msgs/msg/PoseWithCovarianceStamped"
    ](header(t_ns, "map"), TYPES["geometry_msgs/msg/PoseWithCovariance"](pose(k), np.zeros(36)))


def transform(t_ns, k, parent, child):
    return TYPES["geometry_msgs/msg/TransformStamped"](
        header(t_ns, parent),
        child,
        TYPES["geometry_msgs/msg/Transform"](vector(0.01 * k), TYPES["geometry_msgs/msg/Quaternion"](0.0, 0.0, 0.0, 1.0)),
    )


def tf(*pairs):
    return "tf2_msgs/msg/TFMessage", lambda t_ns, k: TYPES["tf2_msgs/msg/TFMessage"](
        [transform(t_ns, k, *pair) for pair in pairs]
    )


def transform_stamped(parent, child):
    return "geometry_msgs/msg/TransformStamped", lambda t_ns, k: transform(t_ns, k, parent, child)


def command():
    return "geometry_msgs/msg/Twist", lambda t_ns, k: twist(k)


def description(text):
    """A description of the robot, sent once."""
    return "std_msgs/msg/String", lambda t_ns, k: TYPES["std_msgs/msg/String"](text) if k == 0 else None


def urdf(radius):
    """Four wheels whose names tell no side: 1 and 3 are left; 3 and 4 at the rear."""
    parts = ['<link name="base_link"/>']
    for k, (x, y) in enumerate([(0.3, 0.25), (0.3, -0.25), (-0.3, 0.25), (-0.3, -0.25)], 1):
        geometry = f'<collision><geometry><cylinder radius="{radius}" length="0.1"/></geometry></collision>' if radius else ""
        parts.append(f'<link name="wheel_{k}">{geometry}</link>')
        parts.append(
            f'<joint name="motor_{k}" type="continuous"><parent link="base_link"/><child link="wheel_{k}"/>'
            f'<origin xyz="{x} {y} 0"/><axis xyz="0 1 0"/></joint>'
        )
    return f'<robot name="four">{"".join(parts)}</robot>'


WHEELS = joint_state("wheel_left_joint", "wheel_right_joint")
# Topics of each bag, and the offset of its stamps (ns).
BAGS = {
    "localised": (
        {
            "/cmd_vel": command(),
            "/joint_states": WHEELS,
            "/odom": odometry(),
            "/odometry/filtered": odometry(),
            "/tf": tf(("odom", "base_footprint"), ("map", "odom")),
            "/amcl_pose": pose_with_covariance(),
            "/goal_pose": pose_stamped(),
        },
        0,
    ),
    "captured": (
        {
            "/cmd_vel": command(),
            "/joint_states": WHEELS,
            "/amcl_pose": pose_with_covariance(),
            "/vicon/turtle/turtle": transform_stamped("vicon/world", "turtle"),
        },
        0,
    ),
    "simulated": (
        {
            "/base/joint_states": WHEELS,
            "/base/odom": odometry(),
            "/ground_truth/state": odometry("world"),
            "/base/cmd_vel": command(),
        },
        -START_NS + 1_000_000_000,
    ),
    "transforms": ({"/joint_states": WHEELS, "/tf": tf(("odom", "base_link"), ("optitrack", "cart"))}, 0),
    "two": (
        {
            "/r1/joint_states": WHEELS,
            "/r2/joint_states": WHEELS,
            "/vicon/r1/pose": pose_stamped(),
            "/vicon/r2/pose": pose_stamped(),
            "/vicon/ball/pose": pose_stamped(),
        },
        0,
    ),
    "described": (
        {
            "/joint_states": joint_state("motor_1", "motor_2", "motor_3", "motor_4"),
            "/mocap/pose": pose_stamped(),
            "/robot_description": description(urdf(0.1)),
        },
        0,
    ),
    "without_radius": ({"/mocap/pose": pose_stamped(), "/robot_description": description(urdf(None))}, 0),
    "two_robots": (
        {
            "/mocap/pose": pose_stamped(),
            "/a/robot_description": description(urdf(0.1)),
            "/b/robot_description": description(urdf(0.2)),
        },
        0,
    ),
    "skid": (
        {
            "/husky/joint_states": joint_state(
                "front_left_wheel", "front_right_wheel", "rear_left_wheel", "rear_right_wheel", "arm_1"
            ),
            "/husky/odom": odometry(),
            "/mocap/pose": pose_stamped(),
        },
        0,
    ),
}


def main(out):
    out.mkdir(parents=True, exist_ok=True)
    for name, (topics, offset_ns) in BAGS.items():
        with Writer(out / name, version=9, storage_plugin=StoragePlugin.MCAP) as writer:
            connections = {
                topic: writer.add_connection(topic, kind, typestore=STORE) for topic, (kind, _) in topics.items()
            }
            for k in range(40):
                t_ns = START_NS + k * 50_000_000
                for topic, (kind, make) in topics.items():
                    message = make(t_ns + offset_ns, k)
                    if message is not None:
                        writer.write(connections[topic], t_ns + 2_000_000, STORE.serialize_cdr(message, kind))


if __name__ == "__main__":
    main(Path(sys.argv[1]))
