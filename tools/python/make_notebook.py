"""Writes calibrate.ipynb from the cells below: `python make_notebook.py`."""

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


def cell(kind, text):
    own = {"cell_type": kind, "metadata": {}, "source": text.splitlines(keepends=True)}
    return own if kind == "markdown" else {**own, "execution_count": None, "outputs": []}


notebook = {
    "cells": [{**cell(kind, text), "id": f"cell-{place}"} for place, (kind, text) in enumerate(CELLS)],
    "metadata": {
        "kernelspec": {"display_name": "Python 3", "language": "python", "name": "python3"},
        "language_info": {"name": "python"},
    },
    "nbformat": 4,
    "nbformat_minor": 5,
}
file = Path(__file__).parent / "calibrate.ipynb"
file.write_text(json.dumps(notebook, indent=1, ensure_ascii=False) + "\n", encoding="utf-8")
