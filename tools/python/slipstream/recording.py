"""Recordings: from files, from arrays or data frames, and back."""

from __future__ import annotations

from os import PathLike, fspath
from typing import TYPE_CHECKING, Any, Dict, List, Mapping, Optional, Sequence, Tuple, Union

import numpy

from . import _slipstream

if TYPE_CHECKING:
    import pandas

Robot = Union[str, "PathLike[str]", Sequence[Union[str, "PathLike[str]"]], Mapping[str, Any]]
"""A robot model: the path of a robot.toml, a URDF or the YAML of a controller, a list of such paths, of which each fills what the
others lack, or a mapping with the tables and keys of a robot.toml."""

_STREAMS = ("command", "wheels", "odometry", "pose", "imu", "motor")


class Recording:
    """A recording: robots with their streams, each with its own times.

    Columns and units are those of the CSV form: `pose` has `t_s, x_m, y_m, yaw_rad`, `wheels` has `t_s` and
    `angle_right_rad, angle_left_rad` (or `ticks_…`, or `speed_…_rad_s`), `command` has `v_m_s, w_rad_s` (or torques,
    voltages, wheel speeds), `imu` has any of `ax_m_s2, ay_m_s2, gz_rad_s`. NaN: not seen.
    """

    def __init__(self, inner: "_slipstream.Recording") -> None:
        self._inner = inner

    @classmethod
    def read(
        cls,
        path: "Union[str, PathLike[str]]",
        *,
        topics: "Optional[Union[str, PathLike[str]]]" = None,
        columns: "Optional[Union[str, PathLike[str]]]" = None,
        robot: Optional[Union[Robot, Mapping[str, Robot]]] = None,
    ) -> "Recording":
        """Reads a folder of CSV files or a bag (MCAP, SQLite, ROS 1); with a map of its topics or columns, if it needs one.

        The files of a `robot` (a URDF, the YAML of a controller) tell which joints of a bag are its wheels.
        """
        maps = [None if file is None else fspath(file) for file in (topics, columns)]
        return cls(_slipstream.Recording.read(fspath(path), *maps, _files(robot)))

    @classmethod
    def from_arrays(
        cls,
        robots: Mapping[str, Mapping[str, Any]],
        *,
        name: str = "arrays",
        robot: Optional[Robot] = None,
        pose_point: str = "centre_of_mass",
        same_robot: bool = False,
    ) -> "Recording":
        """Makes a recording of arrays: robot → stream → column → values. A stream may be a data frame.

        Beside its streams a robot may have `encoder_counts_per_rev` and `noise` (standard deviations by their keys).
        `robot` is the nominal model; `pose_point` is "centre_of_mass" or "axle"; `same_robot` says that all are runs of
        one machine.
        """
        if pose_point not in ("centre_of_mass", "axle"):
            raise _slipstream.InputError(f'pose_point {pose_point!r}: is unknown; give "centre_of_mass" or "axle"')
        own = [_arriving(key, streams) for key, streams in robots.items()]
        model = None if robot is None else model_text(robot)
        return cls(_slipstream.Recording.from_columns(name, own, pose_point == "axle", same_robot, model))

    from_frames = from_arrays

    def to_arrays(self) -> Dict[str, Dict[str, Dict[str, "numpy.ndarray[Any, Any]"]]]:
        """Robot → stream → column → values."""
        return {
            robot: {
                stream: {name: numpy.frombuffer(values, dtype="<f8") for name, values in columns}
                for stream, columns in streams
            }
            for robot, streams in self._inner.columns()
        }

    def to_frames(self) -> "Dict[str, Dict[str, pandas.DataFrame]]":
        """Robot → stream → data frame, with the times as its index."""
        import pandas

        return {
            robot: {
                stream: pandas.DataFrame({key: values.copy() for key, values in columns.items()}).set_index("t_s")
                for stream, columns in streams.items()
            }
            for robot, streams in self.to_arrays().items()
        }

    def write(self, folder: "Union[str, PathLike[str]]") -> None:
        """Writes a folder of CSV files, from which it can be read again."""
        self._inner.write(fspath(folder))

    @property
    def name(self) -> str:
        """Its name."""
        return self._inner.name

    @property
    def model(self) -> Optional[str]:
        """Its nominal model, as the text of a robot.toml."""
        return self._inner.model

    @property
    def warnings(self) -> List[str]:
        """What reading it warned of."""
        return self._inner.warnings

    def __repr__(self) -> str:
        robots = ", ".join(
            f"{robot}: {', '.join(stream for stream, _ in streams)}" for robot, streams in self._inner.columns()
        )
        return f"<Recording {self.name!r} of {robots or 'no robots'}>"


def _arriving(robot: str, streams: Mapping[str, Any]) -> Tuple[str, List[Any], List[Tuple[str, float]]]:
    """A robot as the native part takes it: bytes of columns, numbers that describe its sensors."""
    own: List[Any] = []
    numbers: List[Tuple[str, float]] = []
    for key, value in streams.items():
        if key == "noise":
            numbers.extend((name, float(each)) for name, each in value.items())
        elif key in _STREAMS or hasattr(value, "keys"):
            own.append((key, _columns(value)))
        else:
            numbers.append((key, float(value)))
    return robot, own, numbers


def _columns(stream: Any) -> List[Tuple[str, bytes]]:
    columns = [(str(key), stream[key]) for key in stream.keys()]
    index = getattr(stream, "index", None)
    if getattr(index, "name", None) == "t_s" and all(key != "t_s" for key, _ in columns):
        columns.insert(0, ("t_s", index))
    return [(key, numpy.ascontiguousarray(values, dtype="<f8").ravel().tobytes()) for key, values in columns]


def model_text(robot: Robot) -> str:
    """The text of a robot.toml."""
    if isinstance(robot, Mapping):
        return _toml({"format": 1, **robot})
    if isinstance(robot, str) and "\n" in robot:
        return robot
    return _slipstream.model_text(paths(robot))


def _files(robot: Optional[Union[Robot, Mapping[str, Robot]]]) -> List[List[str]]:
    """The files of each robot; none of a robot that is given as tables or as the text of a robot.toml."""
    each = robot.values() if isinstance(robot, Mapping) and "robot" not in robot else [robot]
    is_text = [isinstance(own, str) and "\n" in own for own in each]
    return [paths(own) for own, text in zip(each, is_text) if own is not None and not text and not isinstance(own, Mapping)]


def paths(robot: Union[str, "PathLike[str]", Sequence[Union[str, "PathLike[str]"]]]) -> List[str]:
    """One path or several, as a list."""
    several = [robot] if isinstance(robot, (str, PathLike)) else robot
    return [fspath(own) for own in several]


def _toml(table: Mapping[str, Any]) -> str:
    """A mapping of tables as TOML."""
    plain = [f"{key} = {_value(own)}" for key, own in table.items() if not isinstance(own, Mapping)]
    tables = [
        f"[{key}]\n" + "\n".join(f"{name} = {_value(value)}" for name, value in own.items())
        for key, own in table.items()
        if isinstance(own, Mapping)
    ]
    return "\n".join(plain + tables) + "\n"


def _value(value: Any) -> str:
    if isinstance(value, Mapping):
        return "{ " + ", ".join(f"{key} = {_value(own)}" for key, own in value.items()) + " }"
    if isinstance(value, str):
        return '"' + value.replace("\\", "\\\\").replace('"', '\\"') + '"'
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, (list, tuple, numpy.ndarray)):
        return "[" + ", ".join(_value(own) for own in value) + "]"
    if isinstance(value, (int, numpy.integer)):
        return str(int(value))
    return repr(float(value))
