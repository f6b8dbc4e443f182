"""Shared by both alternatives: command line, recording folder, robot model, JSON answer."""

import argparse
import csv
import json
import pathlib
import tomllib

import numpy as np

G = 9.81
CHANNEL = {
    "yaw_scrub": "yaw",
    "pose_latency": "sensor_pose",
    "wheel_radius": "wheel_right",
    "track_width": "yaw",
}


def arguments():
    parser = argparse.ArgumentParser()
    parser.add_argument("command", choices=["diagnose"])
    parser.add_argument("recording", type=pathlib.Path)
    parser.add_argument("--robot", type=pathlib.Path, required=True)
    parser.add_argument("--json", type=pathlib.Path, required=True)
    parser.add_argument("--without", action="append", default=[])
    return parser.parse_args()


def columns(path):
    with open(path) as file:
        rows = list(csv.DictReader(file))
    return {
        name: np.array([float(row[name]) if row[name] else np.nan for row in rows])
        for name in rows[0]
    }


class Model:
    """Parameters of the nominal robot, named by the symbols of the paper."""

    def __init__(self, path):
        text = tomllib.loads(path.read_text())
        robot = text["robot"]
        self.body = robot["body_mass_kg"]
        self.wheel = robot["wheel_mass_kg"]
        self.m = self.body + 2 * self.wheel
        self.b = robot["half_track_m"]
        self.d = robot["com_to_axle_m"]
        self.e = robot["com_to_caster_m"]
        self.h = robot["com_height_m"]
        self.r = robot["wheel_radius_m"]
        self.iw = robot["wheel_spin_inertia_kg_m2"]
        self.it = (
            robot["body_yaw_inertia_kg_m2"]
            + 2 * robot["wheel_yaw_inertia_kg_m2"]
            + 2 * self.wheel * (self.b**2 + self.d**2)
        )
        motor = text.get("motor", {})
        self.per_volt = motor.get("stall_torque_nm", 0) / motor.get("nominal_voltage_v", 1)
        self.back_emf = motor.get("stall_torque_nm", 0) / motor.get("no_load_speed_rad_s", 1)
        self.counts = text.get("encoder", {}).get("counts_per_rev", 1856)
        slip = text.get("effects", {}).get("wheel_slip")
        self.friction = slip["friction_kinetic"] if slip else None


class Robot:
    """Streams of one robot; `pose` is None if no camera measured its heading."""

    def __init__(self, folder, notes, counts):
        command = columns(folder / "command.csv")
        self.t_u = command.pop("t_s")
        self.kind = next(iter(command)).split("_")[0]
        self.u = np.array(list(command.values())[:2]).T
        wheels = columns(folder / "wheels.csv")
        self.counts = notes.get("encoder_counts_per_rev", counts)
        self.t_w = wheels["t_s"]
        ticks = np.array([wheels["ticks_right"], wheels["ticks_left"]]).T
        self.angle = ticks * 2 * np.pi / self.counts
        self.pose = None
        if (folder / "pose.csv").exists():
            pose = columns(folder / "pose.csv")
            if "yaw_rad" in pose:
                self.t_p = pose["t_s"]
                yaw = np.unwrap(pose["yaw_rad"])
                self.pose = np.array([pose["x_m"], pose["y_m"], yaw]).T
        noise = notes.get("noise", {})
        self.sigma = np.array(
            [noise.get("pose_m", 0.002)] * 2 + [noise.get("pose_rad", 0.0087)]
        )


def robots(folder, counts):
    notes = tomllib.loads((folder / "recording.toml").read_text())["robots"]
    return {name: Robot(folder / name, note, counts) for name, note in notes.items()}


def finding(robot, effect, parameters, end_s):
    """A finding for the answer. `parameters`: name -> (estimate, standard deviation)."""
    return {
        "robot": robot,
        "effect": effect,
        "statement": "",
        "parameters": [
            {"name": name, "estimate": value, "ci95": [value - 1.96 * sd, value + 1.96 * sd]}
            for name, (value, sd) in parameters.items()
        ],
        "where": {
            "channel": CHANNEL.get(effect, "longitudinal"),
            "intervals_s": [[0.0, end_s]],
        },
        "confused_with": [],
    }


def answer(path, findings, explained):
    verdict = "match" if not findings else "explained" if explained else "unexplained"
    if not findings and not explained:
        verdict = "unexplained"
    path.write_text(json.dumps({"format": 1, "verdict": verdict, "findings": findings}))
