"""Find what the model of a differential-drive robot leaves out.

>>> import slipstream
>>> answer = slipstream.diagnose("recording", robot="robot.toml")
>>> answer.verdict
'explained'
>>> answer.to_frame()

Names, units and meanings are those of the JSON that the command `slipstream` writes.
"""

from ._slipstream import Context, Failed, Heard, InnerInput, InputError, OuterInput, __version__
from .answers import (
    Budget,
    Channel,
    Detectable,
    Diagnosis,
    Evidence,
    Finding,
    HeldOut,
    Outliers,
    Parameter,
    Part,
    ProcessNoise,
    Trace,
    Run,
    Study,
    Unexplained,
    Warning,
    Where,
)
from .commands import diagnose, effects, run, study, trace
from .controller import Controller, run_agent
from .recording import Recording

__all__ = [
    "Budget",
    "Channel",
    "Context",
    "Controller",
    "Detectable",
    "Diagnosis",
    "Evidence",
    "Failed",
    "Finding",
    "Heard",
    "HeldOut",
    "InnerInput",
    "InputError",
    "OuterInput",
    "Outliers",
    "Parameter",
    "Part",
    "ProcessNoise",
    "Recording",
    "Run",
    "Study",
    "Trace",
    "Unexplained",
    "Warning",
    "Where",
    "__version__",
    "diagnose",
    "effects",
    "run",
    "run_agent",
    "study",
    "trace",
]
