#!/usr/bin/env python3
"""Plain output-error fitting (scipy's least squares) with the command line of `slipstream diagnose`.

Simulates the whole recording from its start and fits parameters by least squares. Effects are added greedily,
each tried with four iterations, while the Bayesian information criterion falls by at least 10. Dry friction is
regularised by tanh.
"""

import numpy as np
from numba import njit
from scipy.optimize import least_squares

from recording import G, Model, answer, arguments, finding, robots

STEP_S = 2e-3
# effect -> parameter -> (index in the vector, value without the effect, initial value)
EFFECTS = {
    "rolling_resistance": {"coefficient": (0, 0.0, 0.005)},
    "viscous_drag": {"coefficient": (1, 0.0, 0.2)},
    "quadratic_drag": {"coefficient": (2, 0.0, 0.2)},
    "yaw_scrub": {"moment_nm": (3, 0.0, 0.005)},
    "axle_friction": {"torque_nm": (4, 0.0, 0.002)},
    "torque_speed_droop": {"coefficient": (5, 0.0, 5e-4)},
    "motor_gain": {"right": (6, 1.0, 0.97), "left": (7, 1.0, 0.98)},
    "actuator_delay": {"delay_s": (8, 0.0, 0.02)},
    "actuator_lag": {"time_constant_s": (9, 0.0, 0.02)},
    "floor_slope": {"x": (10, 0.0, 0.002), "y": (11, 0.0, 0.002)},
    "payload": {"mass_kg": (12, 0.0, 0.1), "x_m": (13, 0.0, 0.01), "y_m": (14, 0.0, 0.01)},
    "supply_sag": {"rate_per_s": (15, 0.0, 0.002)},
    "pose_latency": {"latency_s": (16, 0.0, 0.02)},
    "wheel_radius": {"right_scale": (17, 1.0, 1.005), "left_scale": (18, 1.0, 0.995)},
    "track_width": {"scale": (19, 1.0, 1.01)},
    "wheel_slip": {"inverse": (20, 0.0, 4.5)},
    "command_dead_band": {"torque_nm": (21, 0.0, 0.01)},
}
SIZE = 22
SPEED_EFFECTS = ["motor_gain", "actuator_delay", "actuator_lag", "supply_sag", "pose_latency", "wheel_radius", "track_width"]


@njit(cache=True)
def simulate(p, start, u, kind, n, c):
    """Pose and wheel angles at every step. Command `kind`: 0 torque, 1 voltage, 2 wheel speeds."""
    m, wheel, b0, d, e, h, r0, iw, it, per_volt, back = c
    b = b0 * p[19]
    r = np.array([r0 * p[17], r0 * p[18]])
    mass = m + p[12]
    sx, sy = -2 * wheel * d + p[12] * p[13], p[12] * p[14]
    inertia = it + p[12] * (p[13] ** 2 + p[14] ** 2)
    out = np.zeros((n, 5))
    x, y, yaw = start
    ar = al = 0.0
    vel = np.zeros(5)
    lag = np.zeros(2)
    big = np.zeros((5, 5))
    big[0, 0] = big[1, 1] = mass
    big[0, 2] = big[2, 0] = -sy
    big[1, 2] = big[2, 1] = sx
    big[2, 2] = inertia
    big[3, 3] = big[4, 4] = iw
    roll = np.array([[1.0, 0.0], [0.0, d], [0.0, 1.0], [1 / r[0], b / r[0]], [1 / r[1], -b / r[1]]])
    small = np.linalg.inv(roll.T @ big @ roll)
    full = np.linalg.inv(big)
    for k in range(n):
        out[k, 0], out[k, 1], out[k, 2], out[k, 3], out[k, 4] = x, y, yaw, ar, al
        t = k * STEP_S
        at = int((t - p[8]) / 0.02 + 1e-9) if t >= p[8] else -1
        fraction = 1.0 if p[9] < STEP_S / 2 else 1 - np.exp(-STEP_S / p[9])
        drive = np.zeros(2)
        for i in range(2):
            command = 0.0 if at < 0 else u[min(at, len(u) - 1), i]
            if abs(command) < p[21]:
                command = 0.0
            lag[i] += (command - lag[i]) * fraction
            drive[i] = lag[i] * p[6 + i] * (1 - p[15] * t)
        cos, sin = np.cos(yaw), np.sin(yaw)
        before = vel.copy()
        if kind == 2:
            v = (drive[0] * r[0] + drive[1] * r[1]) / 2
            w = (drive[0] * r[0] - drive[1] * r[1]) / (2 * b)
            vel = np.array([v, d * w, w, drive[0], drive[1]])
            before = vel
        else:
            uu, vv, w = vel[0], vel[1], vel[2]
            force = np.zeros(5)
            drag = p[1] + p[2] * np.sqrt(uu * uu + vv * vv)
            px, py = G * (p[10] * cos + p[11] * sin), G * (p[11] * cos - p[10] * sin)
            force[0] = (mass * vv + sx * w) * w - drag * uu + mass * px - p[0] * mass * G * np.tanh(uu / 2e-3)
            force[1] = (sy * w - mass * uu) * w - drag * vv + mass * py
            force[2] = -(sx * uu + sy * vv) * w + sx * py - sy * px - p[3] * np.tanh(w / 1e-2)
            for i in range(2):
                torque = drive[i] * per_volt - back * vel[3 + i] if kind == 1 else drive[i]
                force[3 + i] = torque - p[5] * vel[3 + i] - p[4] * np.tanh(vel[3 + i] / 5e-2)
            if p[20] > 0:
                caster = (m * d + p[12] * (d + p[13])) * G / (d + e)
                load = (mass * G - caster) / 2
                for i in range(2):
                    side = b if i == 0 else -b
                    sl, st = uu + side * w - r[i] * vel[3 + i], vv - d * w
                    size = np.sqrt(sl * sl + st * st) + 1e-12
                    friction = -load / p[20] * np.tanh(size / 5e-3) / size
                    fl, ft = friction * sl, friction * st
                    force[0] += fl
                    force[1] += ft
                    force[2] += side * fl - d * ft
                    force[3 + i] -= r[i] * fl
                vel = vel + STEP_S * (full @ force)
            else:
                rate = small @ (roll.T @ force)
                vel = vel + STEP_S * (roll @ rate)
        mid = (before + vel) / 2
        cos, sin = np.cos(yaw + mid[2] * STEP_S / 2), np.sin(yaw + mid[2] * STEP_S / 2)
        x += STEP_S * (mid[0] * cos - mid[1] * sin)
        y += STEP_S * (mid[0] * sin + mid[1] * cos)
        yaw += STEP_S * mid[2]
        ar += STEP_S * mid[3]
        al += STEP_S * mid[4]
    return out


class Fit:
    def __init__(self, robot, model, without):
        self.robot, self.model = robot, model
        self.kind = {"torque": 0, "voltage": 1}.get(robot.kind, 2)
        self.u = robot.u
        if robot.kind == "v":
            turn = model.b * robot.u[:, 1]
            self.u = np.array([robot.u[:, 0] + turn, robot.u[:, 0] - turn]).T / model.r
        self.c = np.array([getattr(model, name) for name in
                           ("m", "wheel", "b", "d", "e", "h", "r", "iw", "it", "per_volt", "back_emf")])
        self.n = int(robot.t_u[-1] / STEP_S) + 20
        self.base = np.zeros(SIZE)
        for parameters in EFFECTS.values():
            for index, none, _ in parameters.values():
                self.base[index] = none
        if model.friction:
            self.base[20] = 1 / model.friction
        self.known = [e for e in (SPEED_EFFECTS if self.kind == 2 else EFFECTS) if e not in without]
        if robot.pose is None:
            self.known = [e for e in self.known if e not in ("pose_latency", "floor_slope")]
        self.start = robot.pose[:8].mean(0) if robot.pose is not None else np.zeros(3)

    def residuals(self, values, indices):
        p = self.base.copy()
        p[indices] = values[3:]
        path = simulate(p, values[:3], self.u, self.kind, self.n, self.c)
        t = np.arange(self.n) * STEP_S
        tick = 2 * np.pi / self.robot.counts
        parts = []
        for i in range(2):
            error = np.interp(self.robot.t_w, t, path[:, 3 + i]) - self.robot.angle[:, i] - tick / 2
            parts.append(error / tick)
        if self.robot.pose is not None:
            for i in range(3):
                seen = np.interp(self.robot.t_p - p[16], t, path[:, i])
                parts.append((seen - self.robot.pose[:, i]) / self.robot.sigma[i])
        error = np.concatenate(parts)
        return np.where(np.isfinite(error), np.clip(error, -1e6, 1e6), 1e6)

    def fit(self, effects, values, iterations):
        indices = [index for effect in effects for index, _, _ in EFFECTS[effect].values()]
        scale = np.concatenate([[1e-2] * 3, [max(abs(EFFECTS[e][n][2] - EFFECTS[e][n][1]), 1e-3)
                                            for e in effects for n in EFFECTS[e]]])
        return least_squares(self.residuals, values, args=(indices,), x_scale=scale, max_nfev=iterations)

    def greedy(self):
        best, chosen = self.fit([], self.start, 20), []
        rows = len(best.fun)
        while len(chosen) < 3:
            tried = []
            for effect in self.known:
                if effect not in chosen:
                    begin = [value for _, _, value in EFFECTS[effect].values()]
                    fitted = self.fit(chosen + [effect], np.concatenate([best.x, begin]), 4)
                    tried.append((self.criterion(fitted, rows), effect, fitted))
            tried.sort(key=lambda one: one[0])
            if not tried or tried[0][0] > self.criterion(best, rows) - 10:
                break
            chosen = chosen + [tried[0][1]]
            best = self.fit(chosen, tried[0][2].x, 30)
        return best, chosen

    def criterion(self, fitted, rows):
        return rows * np.log(max(2 * fitted.cost / rows, 0.2)) + len(fitted.x) * np.log(rows)


def main():
    given = arguments()
    model = Model(given.robot)
    findings, explained = [], True
    for name, robot in robots(given.recording, model.counts).items():
        fit = Fit(robot, model, given.without)
        best, chosen = fit.greedy()
        level = np.sqrt(2 * best.cost / len(best.fun))
        explained &= bool(level < 1.5)
        spread = np.linalg.pinv(best.jac.T @ best.jac) * max(level, 0.3) ** 2
        sd = np.sqrt(np.maximum(np.diag(spread), 0))
        at = 3
        for effect in chosen:
            parameters = {}
            for parameter in EFFECTS[effect]:
                parameters[parameter] = (float(best.x[at]), float(sd[at]))
                at += 1
            if effect == "wheel_slip":
                value, s = parameters["inverse"]
                parameters = {f"friction_{k}": (1 / value, s / value**2) for k in ("static", "kinetic")}
            if effect == "floor_slope":
                (x, s), (y, _) = parameters["x"], parameters["y"]
                size = float(np.hypot(x, y)) + 1e-12
                parameters = {"grade": (size, s), "downhill_rad": (float(np.arctan2(y, x)), s / size)}
            findings.append(finding(name, effect, parameters, float(robot.t_w[-1])))
    answer(given.json, findings, explained)


if __name__ == "__main__":
    main()
