"""Controllers of one's own: the law of a robot, in Python."""

from __future__ import annotations

import sys
from typing import Callable, NoReturn, Optional, Sequence, Tuple, Union

from . import _slipstream
from ._slipstream import Context, InnerInput, OuterInput


class Controller:
    """Control law of one robot. The same inputs must give the same outputs, so that runs repeat bit for bit: no clock, no
    random numbers without a seed.

    Class attributes that are numbers, truth values, texts or lists of numbers are its parameters, unless their names begin with `_`: an experiment
    sets them as `controller.r2.NAME`, and `self.NAME` has the value.

    >>> class Mine(slipstream.Controller):
    ...     gain = 1.0  # 1/s
    ...
    ...     def outer(self, now):
    ...         v_r, w_r = now.reference_velocity
    ...         e_x, e_y, e_theta = now.error
    ...         return v_r + self.gain * e_x, w_r + 4.0 * e_y + 2.0 * e_theta
    """

    def start(self, context: Context) -> None:
        """Called once, before the first tick: the parameters have their values."""

    def outer(self, now: OuterInput) -> Tuple[float, float]:
        """Desired velocities v (m/s) and w (rad/s), at every tick of the outer loop (20 Hz unless the experiment says otherwise)."""
        raise NotImplementedError(f"{type(self).__name__} has no method outer")

    def inner(self, now: InnerInput) -> Tuple[float, float]:
        """Torques of the right and the left wheel (N m), at every tick of the inner loop (50 Hz unless the experiment says otherwise). They are
        cut to the limits of `now.limit_nm`. Without a method of its own, a controller has the paper's PI speed loops."""
        return now.paper()

    def message(self) -> Optional[Sequence[float]]:
        """Up to eight numbers that the robot sends with its position; asked for after `outer`."""
        return None


Made = Union[Controller, Callable[[], Controller]]
"""A controller, or a class or function that makes one."""


def run_agent(make: Made) -> NoReturn:
    """Runs the agent of one robot with the controller that `make` makes: the whole program for `slipstream run --agent
    'r2=python3 FILE.py'`. It does not return.

    >>> if __name__ == "__main__":
    ...     slipstream.run_agent(Mine)
    """
    sys.exit(_slipstream.run_agent(list(sys.argv), make))
