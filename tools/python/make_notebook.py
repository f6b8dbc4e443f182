"""Writes calibrate.ipynb and controllers.ipynb from the cells below: `python make_notebook.py`."""

import json
from pathlib import Path

CELLS = [
    ("markdown", "# Calibrate a robot from arrays\n\nA cart with two driven wheels was filmed while it drove. Its model says that both wheels have a radius of "
     "100 mm and lie 400 mm apart. How far does it predict, and what is wrong with it?"),
    ("code", "import numpy as np\nimport slipstream\n\nrng = np.random.default_rng(1)\nt = np.arange(0.0, 60.0, 0.02)"),
    ("markdown", "Here the recording is made of formulas, so that the truth is known: the right wheel is 3 % smaller than the model says, and the camera "
     "stamps its poses 60 ms late. With a recording of your own, put its arrays in place of these."),
    ("code", "speed = 0.4 + 0.2 * np.sin(0.5 * t)                          # m/s\n"
     "turn = 0.6 * np.sin(0.23 * t) + 0.3 * np.sin(0.71 * t)       # rad/s\n"
     "yaw = np.cumsum(turn) * 0.02\n"
     "x, y = np.cumsum(speed * np.cos(yaw)) * 0.02, np.cumsum(speed * np.sin(yaw)) * 0.02\n"
     "right = np.cumsum(speed + 0.2 * turn) * 0.02 / (0.1 * 0.97)  # rad\n"
     "left = np.cumsum(speed - 0.2 * turn) * 0.02 / 0.1\n\n"
     "camera = slice(None, None, 2)                                # 25 poses a second\n"
     "robots = {\"cart\": {\n"
     "    \"pose\": {\n"
     "        \"t_s\": t[camera] + 0.06,\n"
     "        \"x_m\": x[camera] + rng.normal(0, 0.002, x[camera].size),\n"
     "        \"y_m\": y[camera] + rng.normal(0, 0.002, x[camera].size),\n"
     "        \"yaw_rad\": yaw[camera] + rng.normal(0, 0.004, x[camera].size),\n"
     "    },\n"
     "    \"wheels\": {\"t_s\": t, \"angle_right_rad\": right, \"angle_left_rad\": left},\n"
     "}}\n"
     "model = {\"robot\": {\"wheel_radius_m\": 0.1, \"half_track_m\": 0.2}}\n"
     "recording = slipstream.Recording.from_arrays(robots, robot=model, pose_point=\"axle\")\nrecording"),
    ("markdown", "One call finds what the model leaves out, how much, and how sure that is. In a notebook the answer is the first screen of its page."),
    ("code", "answer = slipstream.diagnose(recording)\nanswer"),
    ("code", "answer.to_frame()"),
    ("markdown", "Both are found, with intervals that hold the truth:"),
    ("code", "found = {finding.effect: finding for finding in answer.findings}\n"
     "right_scale = found[\"wheel_radius\"].parameter(\"right_scale\")\n"
     "latency = found[\"pose_latency\"].parameter(\"latency_s\")\n"
     "assert right_scale.ci95[0] <= 0.97 <= right_scale.ci95[1]\n"
     "assert latency.ci95[0] <= 0.06 <= latency.ci95[1]\n"
     "right_scale, latency"),
    ("markdown", "The improved model predicts the same recording to within the noise of the camera: diagnosed with it, nothing is left."),
    ("code", "again = slipstream.diagnose(recording, robot=answer.improved[\"cart\"])\nassert again.verdict == \"match\"\nprint(answer.improved[\"cart\"])"),
]

CONTROLLERS = [
    ("markdown", "# Compare two control laws\n\nThree robots drive in formation. Their wheels slip, and every position arrives 100 ms late. Does a law of "
     "one's own do better than the paper's?"),
    ("code", "import math\nimport slipstream\n\ndelayed = {\"links.delay_s\": 0.1, \"links.protocol\": \"periodic\"}\n"
     "paper = slipstream.run(set=delayed)\npaper.robots[2][\"max_spacing_error_m\"]"),
    ("markdown", "A law is a class. The reference of a robot is the spacing behind the robot ahead, where that was 100 ms ago. This law moves it forward "
     "by the way that the robot ahead has made since, which it knows from the time stamps of its messages. Numbers among the attributes of the class are parameters."),
    ("code", "class Predictive(slipstream.Controller):\n"
     "    gain = 1.0  # 1/s\n"
     "    share = 1.0  # of the way since the message\n\n"
     "    def outer(self, now):\n"
     "        v_r, w_r = now.reference_velocity\n"
     "        e_x, e_y, e_theta = now.error\n"
     "        newest = max(now.heard.values(), key=lambda heard: heard.sampled_s, default=None)\n"
     "        if now.coordinates and newest is not None:\n"
     "            e_x += self.share * v_r * (now.t_s - newest.sampled_s)\n"
     "        v = v_r * math.cos(e_theta) + self.gain * e_x\n"
     "        w = w_r + v_r * (15.0 * e_y + 6.0 * math.sin(e_theta))\n"
     "        return v, w\n\n\n"
     "own = slipstream.run(set=delayed, controllers={\"*\": Predictive})\nown.robots[2][\"max_spacing_error_m\"]"),
    ("markdown", "The true spacing error is smaller. With less of the prediction it grows again:"),
    ("code", "def largest_error(share):\n"
     "    keys = {**delayed, \"controller.*.share\": share}\n"
     "    run = slipstream.run(set=keys, controllers={\"*\": Predictive})\n"
     "    return max(robot[\"max_spacing_error_m\"] for robot in run.robots[1:])\n\n\n"
     "errors = {share: largest_error(share) for share in (0.0, 0.5, 1.0)}\n"
     "assert errors[1.0] < errors[0.5] < errors[0.0]\nerrors"),
    ("markdown", "The same class drives the robots as programs of their own, one process for each, with the same states: put "
     "`slipstream.run_agent(Predictive)` at the end of a file and give it to `slipstream run --agent 'python3 FILE.py'`."),
]


def cell(kind, text):
    own = {"cell_type": kind, "metadata": {}, "source": text.splitlines(keepends=True)}
    return own if kind == "markdown" else {**own, "execution_count": None, "outputs": []}


def write(name, cells):
    notebook = {
        "cells": [{**cell(kind, text), "id": f"cell-{place}"} for place, (kind, text) in enumerate(cells)],
        "metadata": {
            "kernelspec": {"display_name": "Python 3", "language": "python", "name": "python3"},
            "language_info": {"name": "python"},
        },
        "nbformat": 4,
        "nbformat_minor": 5,
    }
    file = Path(__file__).parent / name
    file.write_text(json.dumps(notebook, indent=1, ensure_ascii=False) + "\n", encoding="utf-8")


write("calibrate.ipynb", CELLS)
write("controllers.ipynb", CONTROLLERS)
