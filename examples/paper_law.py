"""The paper's outer loop (Eq. 12) in Python: the same states, bit for bit, as the built-in controller.

    pip install ./tools/python
    slipstream run platoon --agent 'python3 examples/paper_law.py'
"""

import math

import slipstream


class Paper(slipstream.Controller):
    k_x = 1.0  # 1/s
    k_y = 15.0  # 1/m²
    k_theta = 6.0  # 1/m

    def outer(self, now):
        v_r, w_r = now.reference_velocity
        e_x, e_y, e_theta = now.error
        v = v_r * math.cos(e_theta) + self.k_x * e_x
        w = w_r + v_r * (self.k_y * e_y + self.k_theta * math.sin(e_theta))
        return v, w


if __name__ == "__main__":
    slipstream.run_agent(Paper)
