"""The commands of slipstream as functions."""

from __future__ import annotations

import json
import tempfile
from os import PathLike, fspath
from pathlib import Path
from typing import TYPE_CHECKING, Any, Dict, List, Mapping, Optional, Sequence, Tuple, Union

from . import _slipstream
from .answers import Diagnosis, Run, Study, Trace
from .controller import Made
from .recording import Recording, Robot, model_text, paths

if TYPE_CHECKING:
    import pandas

Source = Union[str, "PathLike[str]", Recording]
"""A recording, or where it is."""

_Paths = Union[str, "PathLike[str]", Sequence[Union[str, "PathLike[str]"]]]


def diagnose(
    recording: Union[Source, Sequence[Source]],
    robot: Optional[Union[Robot, Mapping[str, Robot]]] = None,
    *,
    against: Union[Source, Sequence[Source]] = (),
    without: Sequence[str] = (),
    exclude_time: Sequence[Tuple[float, float]] = (),
    topics: Optional[Union[str, "PathLike[str]"]] = None,
    columns: Optional[Union[str, "PathLike[str]"]] = None,
    report: bool = False,
) -> Diagnosis:
    """Finds what a robot model lacks, from a recording.

    `recording` is a path, a `Recording`, or several of them: runs of the same robots. `robot` is the nominal model: the path
    of a robot.toml, a URDF or the YAML of a controller, a list of such paths, of which each fills what the others lack, a mapping
    with the tables of a robot.toml, or a mapping of such by the names of the robots; without it, the model of the recording is taken. `against` is one recording of the same robots from before, or several: what changed since is found,
    and not what the model lacks. `without` takes effects out of the catalogue; `exclude_time` ignores what was measured between two
    times (s). `topics` is the path of a map of a bag's topics, `columns` of a map of the columns of CSV files. With `report`, the evidence of the page is computed as well.

    Raises `InputError` with `place`, `problem` and `remedy` when something cannot be used.
    """
    sources, before = _sources(recording), _sources(against)
    inner = _slipstream.diagnose(
        [_read(own, topics, columns, robot)._inner for own in sources],
        [_read(own, topics, columns, robot)._inner for own in before],
        _models(robot),
        list(without),
        [(float(a), float(b)) for a, b in exclude_time],
        report,
        _call(sources, before, robot),
    )
    return Diagnosis._of(inner)


def _sources(given: Union[Source, Sequence[Source]]) -> List[Source]:
    return [given] if isinstance(given, (str, PathLike, Recording)) else list(given)


def _read(source: Source, topics: Any, columns: Any, robot: Any) -> Recording:
    if isinstance(source, Recording):
        return source
    return Recording.read(source, topics=topics, columns=columns, robot=robot)


def _models(robot: Optional[Union[Robot, Mapping[str, Robot]]]) -> List[Tuple[Optional[str], str]]:
    if robot is None:
        return []
    if isinstance(robot, Mapping) and "robot" not in robot:
        return [(name, model_text(own)) for name, own in robot.items()]
    return [(None, model_text(robot))]


def _call(sources: Sequence[Source], before: Sequence[Source], robot: Any) -> str:
    """The call as the foot of the page quotes it."""
    given = "" if robot is None else ", robot=" + (repr(fspath(robot)) if isinstance(robot, (str, PathLike)) else "…")
    compared = f", against={_quoted(before)}" if before else ""
    return f"slipstream.diagnose({_quoted(sources)}{given}{compared})"


def _quoted(sources: Sequence[Source]) -> str:
    names = [repr(own.name) if isinstance(own, Recording) else repr(fspath(own)) for own in sources]
    return names[0] if len(names) == 1 else "[" + ", ".join(names) + "]"


def run(
    experiment: Optional[str] = None,
    *,
    robots: Optional[int] = None,
    robot: Optional[Union[_Paths, Mapping[str, _Paths]]] = None,
    set: Optional[Mapping[str, Any]] = None,
    seed: Optional[int] = None,
    out: Optional[Union[str, "PathLike[str]"]] = None,
    controllers: Optional[Mapping[str, Made]] = None,
) -> Run:
    """Runs an experiment on the virtual clock, in this process: a built-in one ("platoon" without a name) or a TOML file.

    `set` gives keys of the experiment, such as `{"links.delay_s": 0.1}`. `robot` is the path of a robot.toml, a URDF or
    the YAML of a controller, a list of such paths, or such by the names of the robots. The recording is written to `out`;
    without it, it is only in memory, as `data`.

    `controllers` has controllers of your own by the names of the robots, and under "*" a class or function that makes one for every
    other robot. An exception in one of them ends the run: `Failed` tells the robot and the time of the run, and has the exception as its cause.
    """
    models: List[Tuple[Optional[str], str]] = []
    if isinstance(robot, Mapping):
        models = [(name, file) for name, own in robot.items() for file in paths(own)]
    elif robot is not None:
        models = [(None, file) for file in paths(robot)]
    keys = [(key, _key(value)) for key, value in (set or {}).items()]
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "run.mcap" if out is None else Path(fspath(out))
        summary = json.loads(_slipstream.run(experiment, robots, models, keys, seed, str(file), list((controllers or {}).items())))
        data = Recording.read(file)
    if out is None:
        summary["recording"] = None
    return Run(summary, data)


def _key(value: Any) -> str:
    """A value as --set takes it."""
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, (list, tuple)):
        return "[" + ", ".join(_key(own) for own in value) + "]"
    return str(value)


def trace(recording: Union[str, "PathLike[str]"]) -> Trace:
    """Latency of the positions of a run, stage by stage, from an MCAP file that a run wrote."""
    return Trace(json.loads(_slipstream.trace(fspath(recording))))


def study(
    *,
    delay: Optional[Sequence[float]] = None,
    jitter: Optional[Sequence[float]] = None,
    loss: Optional[Sequence[float]] = None,
    k_x: Optional[Sequence[float]] = None,
    torque_limit: Optional[Sequence[str]] = None,
    protocol: Optional[Sequence[str]] = None,
    robots: Optional[int] = None,
    runs: Optional[int] = None,
    threads: Optional[int] = None,
) -> Study:
    """What communication delay does to a platoon: every combination of the lists is a point (delay and jitter in s, loss as a
    share, k_x in 1/s). What is not given is as in the command `slipstream study delay`."""
    numbers = {"delay": delay, "jitter": jitter, "loss": loss, "k_x": k_x}
    words = {"torque_limit": torque_limit, "protocol": protocol}
    text = _slipstream.study(
        robots,
        runs,
        [(name, [float(own) for own in values]) for name, values in numbers.items() if values is not None],
        [(name, list(values)) for name, values in words.items() if values is not None],
        threads,
    )
    return Study(json.loads(text))


def effects() -> "pandas.DataFrame":
    """The catalogue of effects: id, summary, equation, source and parameters with their units."""
    import pandas

    rows: List[Dict[str, Any]] = [
        {"effect": id, "summary": summary, "equation": equation, "source": source, "parameters": dict(parameters)}
        for id, summary, equation, source, parameters in _slipstream.effects()
    ]
    return pandas.DataFrame(rows)
