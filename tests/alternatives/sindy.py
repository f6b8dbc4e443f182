#!/usr/bin/env python3
"""Sparse regression of the model discrepancy (PySINDy) with the command line of `slipstream diagnose`.

Regresses accelerations from smoothed encoder counts, minus those of the nominal rolling robot, on a library of
candidate terms. STLSQ on bootstrap samples of blocks (bags); a term selected in most bags names its effect.
"""

import warnings

import numpy as np
import pysindy
from scipy.signal import savgol_filter

from recording import G, Model, answer, arguments, finding, robots

# a bag without any term is a valid result
warnings.filterwarnings("ignore", message="Sparsity parameter")
WINDOW = 15
THRESHOLD = 0.3
BAGS = 20
# standard deviation of the residual accelerations of a robot without any effect (m/s², rad/s²)
NOISE = {"along": 0.013, "yaw": 0.125}


def smooth(values, order=0):
    return savgol_filter(values, WINDOW, 3, deriv=order, delta=0.02, axis=0)


def accelerations(robot, model):
    """Residual accelerations, and the candidate terms that might explain them."""
    t = np.arange(robot.t_w[0], robot.t_w[-1], 0.02)
    angle = np.array([np.interp(t, robot.t_w, robot.angle[:, i]) for i in range(2)]).T
    speed = smooth((angle[2:] - angle[:-2]) / 0.04)
    change = smooth((angle[2:] - 2 * angle[1:-1] + angle[:-2]) / 0.02**2)
    t = t[1:-1]
    # a second difference is a mean acceleration with triangular weights over two rows: weight torque alike
    command = lambda at: robot.u[np.clip(np.searchsorted(robot.t_u, at, side="right") - 1, 0, None)]
    torque = sum((20 - abs(k)) / 400 * command(t + k * 1e-3) for k in range(-19, 20))
    torque = smooth(torque)
    if robot.kind == "voltage":
        torque = torque * model.per_volt - model.back_emf * speed
    r, b, d = model.r, model.b, model.d
    v, w = r * speed.mean(1), r * (speed[:, 0] - speed[:, 1]) / (2 * b)
    dv, dw = r * change.mean(1), r * (change[:, 0] - change[:, 1]) / (2 * b)
    mass = model.m + 2 * model.iw / r**2
    inertia = model.it + model.body * d**2 - 2 * model.wheel * d**2 + 2 * model.iw * b**2 / r**2
    even, odd = torque.sum(1), torque[:, 0] - torque[:, 1]
    residual = {
        "along": dv - (even / r + model.body * d * w**2) / mass,
        "yaw": dw - (odd * b / r - model.body * d * v * w) / inertia,
    }
    yaw = np.zeros_like(t)
    if robot.pose is not None:
        yaw = np.interp(t, robot.t_p, robot.pose[:, 2])
    sign = lambda x, scale: np.tanh(x / scale)
    terms = {
        "along": {
            "rolling_resistance": sign(v, 0.02),
            "viscous_drag": v,
            "quadratic_drag": v * abs(v),
            "motor_gain": even,
            "supply_sag": even * t,
            "actuator_delay": np.gradient(even, 0.02),
            "floor_slope": np.cos(yaw),
            "floor_slope#": np.sin(yaw),
        },
        "yaw": {
            "yaw_scrub": sign(w, 0.05),
            "motor_gain": odd,
            "supply_sag": odd * t,
            "actuator_delay": np.gradient(odd, 0.02),
            "floor_slope": np.sin(yaw),
            "floor_slope#": np.cos(yaw),
        },
    }
    # the rolling model does not hold where the nominal robot itself would slip
    inner = np.arange(20, len(t) - 20)
    if model.friction:
        limit = 0.9 * model.friction * model.m * G * model.e / (model.d + model.e) / 2 * mass * r / model.m
        slips = np.convolve(abs(command(t)).max(1) > limit, np.ones(25), "same") > 0
        inner = inner[~slips[inner]]
    cut = lambda series: {name: values[inner] for name, values in series.items()}
    return cut(residual), {row: cut(terms[row]) for row in terms}, mass, inertia


def selected(residual, terms, rng):
    """Terms in most bags: name -> (median, standard deviation) in their own units."""
    names = list(terms)
    library = np.array([terms[name] for name in names]).T
    scale = library.std(0) + 1e-12
    bags = []
    blocks = max(len(residual) // 50, 1)
    for _ in range(BAGS):
        drawn = rng.integers(0, blocks, blocks)
        rows = np.concatenate([np.arange(k * 50, (k + 1) * 50) for k in drawn])
        rows = rows[rows < len(residual)]
        fit = pysindy.STLSQ(threshold=THRESHOLD, alpha=1e-3)
        fit.fit(library[rows] / scale, residual[rows][:, None])
        bags.append(fit.coef_[0])
    bags = np.array(bags)
    often = (bags != 0).mean(0) > 0.6
    return {
        name: (np.median(bags[:, i]) / scale[i], bags[:, i].std() / scale[i])
        for i, name in enumerate(names)
        if often[i]
    }


def named(along, yaw, model, mass, inertia):
    """Effects with parameters from the terms' coefficients."""
    found = {}
    for name, (value, sd) in along.items():
        match name.rstrip("#"):
            case "rolling_resistance":
                found[name] = {"coefficient": (-value * mass / (model.m * G), sd * mass / (model.m * G))}
            case "viscous_drag" | "quadratic_drag":
                found[name] = {"coefficient": (-value * mass, sd * mass)}
            case "motor_gain":
                gain = (1 + value * mass * model.r, sd * mass * model.r)
                found[name] = {"right": gain, "left": gain}
            case "supply_sag":
                found[name] = {"rate_per_s": (-value * mass * model.r, sd * mass * model.r)}
            case "actuator_delay":
                found[name] = {"delay_s": (-value * mass * model.r, sd * mass * model.r)}
            case "floor_slope":
                x = along.get("floor_slope", (0.0, sd))
                y = along.get("floor_slope#", (0.0, sd))
                factor = mass / (model.m * G)
                found["floor_slope"] = {
                    "grade": (np.hypot(x[0], y[0]) * factor, sd * factor),
                    "downhill_rad": (np.arctan2(y[0], x[0]), sd / (np.hypot(x[0], y[0]) + 1e-12)),
                }
    for name, (value, sd) in yaw.items():
        if name == "yaw_scrub":
            found[name] = {"moment_nm": (-value * inertia, sd * inertia)}
        else:
            found.setdefault(name.rstrip("#"), {})
    return found


def main():
    given = arguments()
    model = Model(given.robot)
    findings, explained = [], True
    for name, robot in robots(given.recording, model.counts).items():
        if robot.kind not in ("torque", "voltage"):
            continue
        residual, terms, mass, inertia = accelerations(robot, model)
        rng = np.random.default_rng(0)
        along = selected(residual["along"] / NOISE["along"], terms["along"], rng)
        yaw = selected(residual["yaw"] / NOISE["yaw"], terms["yaw"], rng)
        along = {n: (v * NOISE["along"], s * NOISE["along"]) for n, (v, s) in along.items()}
        yaw = {n: (v * NOISE["yaw"], s * NOISE["yaw"]) for n, (v, s) in yaw.items()}
        for effect, parameters in named(along, yaw, model, mass, inertia).items():
            if effect not in given.without:
                findings.append(finding(name, effect, parameters, float(robot.t_w[-1])))
    answer(given.json, findings, explained)


if __name__ == "__main__":
    main()
