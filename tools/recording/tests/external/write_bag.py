"""Writes a ROS 2 bag as another robot would, with other programs.

usage: write_bag.py FILE.mcap [idle]

idle: the odometry's twist is zero, as of a driver that fills its pose alone.
"""

import math
import sys

from mcap_ros2.writer import Writer
from rosbags.typesys import Stores, get_typestore

STORE = get_typestore(Stores.ROS2_HUMBLE)
START_NS = 1_700_000_000_123_456_789


def vector(x=0.0, y=0.0, z=0.0):
    return {"x": x, "y": y, "z": z}


def turn(yaw):
    return {"x": 0.0, "y": 0.0, "z": math.sin(yaw / 2), "w": math.cos(yaw / 2)}


def write(path, idle):
    with open(path, "wb") as stream:
        writer = Writer(stream)
        schemas = {}

        def put(topic, name, t_ns, message):
            if name not in schemas:
                text, _ = STORE.generate_msgdef(name, ros_version=2)
                schemas[name] = writer.register_msgdef(name, text)
            writer.write_message(topic, schemas[name], message, log_time=t_ns, publish_time=t_ns)

        for k in range(100):
            t_ns = START_NS + k * 50_000_000
            stamp = {"sec": t_ns // 10**9, "nanosec": t_ns % 10**9}
            header = {"stamp": stamp, "frame_id": "odom"}
            twist = {"linear": vector(0.5), "angular": vector(z=0.1)}
            rest = {"linear": vector(), "angular": vector()}
            pose = {"position": vector(0.025 * k, 1.0), "orientation": turn(0.005 * k)}
            # A message without stamp has only its log time, 2 ms later.
            put("/cmd_vel", "geometry_msgs/msg/Twist", t_ns + 2_000_000, twist)
            put(
                "/odom",
                "nav_msgs/msg/Odometry",
                t_ns,
                {
                    "header": header,
                    "child_frame_id": "base_link",
                    "pose": {"pose": pose, "covariance": [0.0] * 36},
                    "twist": {"twist": rest if idle else twist, "covariance": [0.0] * 36},
                },
            )
            put(
                "/joint_states",
                "sensor_msgs/msg/JointState",
                t_ns,
                {
                    "header": header,
                    "name": ["arm", "left_wheel_joint", "right_wheel_joint"],
                    "position": [9.0, 0.1 * k, 0.2 * k],
                    "velocity": [0.0, 2.0, 4.0],
                    "effort": [],
                },
            )
            put("/vicon/robot/pose", "geometry_msgs/msg/PoseStamped", t_ns, {"header": header, "pose": pose})
            put("/chatter", "std_msgs/msg/String", t_ns, {"data": "hello"})
        writer.finish()


if __name__ == "__main__":
    write(sys.argv[1], "idle" in sys.argv[2:])
