"""Answers as typed objects. Attributes have the names of the JSON."""

from __future__ import annotations

import html
import json
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, Dict, List, Optional, Tuple

if TYPE_CHECKING:
    import os

    import pandas

    from . import _slipstream

# Height of the first screen of a page in a notebook (pixels).
_HEIGHT_PX = 700


@dataclass(frozen=True)
class Parameter:
    """A parameter of a finding: `nominal` as in the model (None without it), `estimate` with its 95 % interval. Of a change,
    `nominal` is what it was before, with its interval."""

    name: str
    unit: str
    nominal: Optional[float] = None
    nominal_ci95: Optional[Tuple[float, float]] = None
    estimate: Optional[float] = None
    ci95: Optional[Tuple[float, float]] = None
    text: Optional[str] = None


@dataclass(frozen=True)
class Where:
    """Where a finding shows: its channel, when it is at work (s), and under which condition."""

    channel: str
    intervals_s: List[Tuple[float, float]]
    condition: str


@dataclass(frozen=True)
class Evidence:
    """How sure a finding is: gain of log-likelihood (nats), and a p-value over everything that was looked at."""

    log_likelihood_gain: float
    p_value: float


@dataclass(frozen=True)
class Finding:
    """One effect that the model leaves out."""

    robot: str
    effect: str
    statement: str
    parameters: List[Parameter]
    where: Where
    confused_with: List[str]
    evidence: Evidence
    runs: Optional[List[str]] = None
    shape: Optional[str] = None
    driver: Optional[str] = None
    actions: List[str] = field(default_factory=list)
    """What to do about it: what to type or turn, the most useful first."""

    def parameter(self, name: str) -> Parameter:
        """The parameter of this name."""
        for own in self.parameters:
            if own.name == name:
                return own
        raise KeyError(name)


@dataclass(frozen=True)
class Channel:
    """Prediction error of one channel: root mean square in its unit, and in standard deviations of its sensor."""

    robot: str
    channel: str
    unit: str
    rms_before: float
    rms_after: float
    rms_expected: float
    """Below which noise stays with 95 % confidence."""
    nrmse_before: float
    nrmse_after: float


@dataclass(frozen=True)
class HeldOut:
    """Predictions over `horizon_s`, each window by a model that was fitted without it."""

    channels: List[Channel]
    nrmse_before: float
    nrmse_after: float
    horizon_s: float


@dataclass(frozen=True)
class Part:
    """A part of an error budget, in its unit."""

    name: str
    share: float


@dataclass(frozen=True)
class Budget:
    """Where the error of one robot went: `parts` add up to `before`. The unit is m or rad."""

    robot: str
    unit: str
    before: float
    after: float
    expected: float
    """Below which noise stays with 95 % confidence."""
    parts: List[Part]


@dataclass(frozen=True)
class Unexplained:
    """What remains and follows `driver`."""

    robot: str
    channel: str
    driver: str
    intervals_s: List[Tuple[float, float]]
    shape: str


@dataclass(frozen=True)
class Outliers:
    """Readings of a stream that were weighed down, by their stamps (s)."""

    robot: str
    stream: str
    count: int
    times_s: List[float]


@dataclass(frozen=True)
class Detectable:
    """From which size on an effect that was not found would have been."""

    robot: str
    effect: str
    parameter: str
    unit: str
    smallest: Optional[float]
    """None where these recordings do not show it at any size."""


@dataclass(frozen=True)
class ProcessNoise:
    """What always pushes and follows nothing that was looked at."""

    robot: str
    acts_on: str
    size: float
    unit: str
    correlation_time_s: float


@dataclass(frozen=True)
class Warning:
    """Something about a recording that makes the answer poorer."""

    recording: str
    robot: Optional[str]
    id: str
    statement: str
    remedy: str


def _pair(values: Any) -> Optional[Tuple[float, float]]:
    return None if values is None else (values[0], values[1])


def _parameter(own: Dict[str, Any]) -> Parameter:
    pairs = {name: _pair(own.get(name)) for name in ("ci95", "nominal_ci95")}
    return Parameter(**{**own, **pairs})


def _finding(own: Dict[str, Any]) -> Finding:
    place = own["where"]
    intervals = [(a, b) for a, b in place["intervals_s"]]
    return Finding(
        robot=own["robot"],
        effect=own["effect"],
        statement=own["statement"],
        parameters=[_parameter(each) for each in own["parameters"]],
        where=Where(place["channel"], intervals, place["condition"]),
        confused_with=own["confused_with"],
        evidence=Evidence(**own["evidence"]),
        runs=own.get("runs"),
        shape=own.get("shape"),
        driver=own.get("driver"),
        actions=own["actions"],
    )


@dataclass(frozen=True)
class Diagnosis:
    """What a diagnosis found."""

    verdict: str
    statement: str
    """The verdict as a sentence with its numbers."""
    findings: List[Finding]
    held_out: HeldOut
    budget: List[Budget]
    unexplained: List[Unexplained]
    outliers: List[Outliers]
    process_noise: List[ProcessNoise]
    warnings: List[Warning]
    improved: Dict[str, str]
    """The improved model of each robot, as the text of a robot.toml."""
    detectable: List[Detectable]
    """From which size on what was not found would have been."""
    against: List[str]
    """Recordings from before; with any, the findings are what changed since."""
    _inner: "_slipstream.Diagnosis" = field(repr=False, compare=False)

    @classmethod
    def _of(cls, inner: "_slipstream.Diagnosis") -> "Diagnosis":
        own = json.loads(inner.json())
        held_out = own["held_out"]
        return cls(
            verdict=own["verdict"],
            statement=own["statement"],
            findings=[_finding(each) for each in own["findings"]],
            held_out=HeldOut(**{**held_out, "channels": [Channel(**each) for each in held_out["channels"]]}),
            budget=[
                Budget(**{**each, "parts": [Part(**part) for part in each["parts"]]}) for each in own.get("budget", [])
            ],
            unexplained=[Unexplained(**each) for each in own["unexplained"]],
            outliers=[Outliers(**each) for each in own.get("outliers", [])],
            process_noise=[ProcessNoise(**each) for each in own.get("process_noise", [])],
            warnings=[Warning(**each) for each in own["warnings"]],
            improved=dict(inner.improved()),
            detectable=[Detectable(**each) for each in own.get("detectable", [])],
            against=own.get("against", []),
            _inner=inner,
        )

    def to_dict(self) -> Dict[str, Any]:
        """The answer as the command writes it with --json."""
        own: Dict[str, Any] = json.loads(self._inner.json())
        return own

    def to_frame(self) -> "pandas.DataFrame":
        """A row for each parameter of each finding."""
        import pandas

        rows = [
            {
                "robot": finding.robot,
                "effect": finding.effect,
                "parameter": own.name,
                "unit": own.unit,
                "nominal": own.nominal,
                "estimate": own.text if own.estimate is None else own.estimate,
                "low": own.ci95[0] if own.ci95 else None,
                "high": own.ci95[1] if own.ci95 else None,
                "gain_nats": finding.evidence.log_likelihood_gain,
            }
            for finding in self.findings
            for own in finding.parameters
        ]
        columns = ["robot", "effect", "parameter", "unit", "nominal", "estimate", "low", "high", "gain_nats"]
        return pandas.DataFrame(rows, columns=columns)

    def to_html(self) -> str:
        """The whole page. Its evidence needs `diagnose(..., report=True)`."""
        return self._inner.page()

    def save_report(self, path: "str | os.PathLike[str]") -> None:
        """Writes the whole page."""
        with open(path, "w", encoding="utf-8") as file:
            file.write(self.to_html())

    def _repr_html_(self) -> str:
        page = html.escape(self._inner.first_screen(), quote=True)
        return f'<iframe srcdoc="{page}" title="Diagnosis" style="width:100%;height:{_HEIGHT_PX}px;border:0"></iframe>'

    def __str__(self) -> str:
        lines = [self.verdict] + [finding.statement for finding in self.findings]
        return "\n".join(lines)


class _Answer:
    """An answer whose attributes are those of its JSON."""

    def __init__(self, own: Dict[str, Any]) -> None:
        self._own = own

    def __getattr__(self, name: str) -> Any:
        try:
            return self.__dict__["_own"][name]
        except KeyError:
            raise AttributeError(name) from None

    def __dir__(self) -> List[str]:
        return sorted(set(super().__dir__()) | set(self._own))

    def to_dict(self) -> Dict[str, Any]:
        """The answer as the command writes it with --json."""
        return self._own

    def _rows(self) -> List[Dict[str, Any]]:
        raise NotImplementedError

    def to_frame(self) -> "pandas.DataFrame":
        """The rows of the answer."""
        import pandas

        return pandas.DataFrame(self._rows())

    def _repr_html_(self) -> str:
        table: str = self.to_frame().to_html(index=False)
        return table


class Run(_Answer):
    """The summary of a run. `data` has what was recorded."""

    def __init__(self, own: Dict[str, Any], data: Any) -> None:
        super().__init__(own)
        self.data = data

    def _rows(self) -> List[Dict[str, Any]]:
        return [
            {
                "robot": own["robot"],
                "final_x_m": (own["final_true"] or [None])[0],
                "slip_time_s": sum(own["slip_time_s"] or [0.0]),
                "max_spacing_error_m": own["max_spacing_error_m"],
                "max_desired_speed_m_s": own["max_desired_speed_m_s"],
            }
            for own in self._own["robots"]
        ]

    def __repr__(self) -> str:
        return f"<Run of {self._own['experiment']}: {len(self._own['robots'])} robots, {self._own['duration_s']} s>"


class Trace(_Answer):
    """Latency of the positions of a run, stage by stage."""

    def _rows(self) -> List[Dict[str, Any]]:
        return [
            {"from": hop["from"], "to": hop["to"], **stage} for hop in self._own["hops"] for stage in hop["stages"]
        ]

    def __repr__(self) -> str:
        return f"<Trace of {len(self._own['hops'])} links>"


class Study(_Answer):
    """A study of communication delay."""

    def _rows(self) -> List[Dict[str, Any]]:
        return [{key: value for key, value in own.items() if key != "fits"} for own in self._own["points"]]

    def __repr__(self) -> str:
        return f"<Study of {len(self._own['points'])} points>"
