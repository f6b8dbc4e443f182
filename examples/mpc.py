"""Model predictive control of the distance to the robot ahead (Rawlings, Mayne, Diehl, "Model Predictive Control", 2nd edition, 2017),
with scipy: accelerations over a second that keep the distance with little effort and within their limits.

    pip install ./tools/python scipy
    slipstream run platoon --agent 'python3 examples/mpc.py' --set links.delay_s=0.1
"""

import math

import numpy as np
from scipy.optimize import lsq_linear

import slipstream


class Mpc(slipstream.Controller):
    horizon = 20  # ticks of the outer loop
    effort = 0.02  # weight of an acceleration beside that of a distance (s²)
    acceleration_m_s2 = 1.0  # largest acceleration: the wheels do not slip

    def start(self, context):
        period = context.settings["control"]["outer_period_s"]
        n = self.horizon
        steps = np.arange(n)
        # How much acceleration j has moved the robot after tick i: the robot is a double integrator.
        ahead = np.clip(steps[:, None] - steps[None, :], 0, None) + 0.5
        self.moved = np.where(steps[:, None] >= steps[None, :], ahead * period**2, 0.0)
        self.matrix = np.vstack([self.moved, self.effort * np.eye(n)])
        self.times = (steps + 1) * period
        self.leads = context.robot == context.robots[0]
        self.v = 0.0

    def outer(self, now):
        v_r, w_r = now.reference_velocity
        e_x, e_y, e_theta = now.error
        if now.coordinates and not self.leads:
            # Without acceleration the distance changes with the difference of the speeds.
            errors = e_x + (v_r - self.v) * self.times
            wanted = np.concatenate([errors, np.zeros(self.horizon)])
            limit = self.acceleration_m_s2
            plan = lsq_linear(self.matrix, wanted, bounds=(-limit, limit), method="bvls")
            self.v += float(plan.x[0]) * now.period_s
        else:
            self.v = v_r
        return self.v, w_r + v_r * (15.0 * e_y + 6.0 * math.sin(e_theta))


if __name__ == "__main__":
    slipstream.run_agent(Mpc)
