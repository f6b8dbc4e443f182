from typing import Any, Dict, List, Optional, Sequence, Tuple

__version__: str

class InputError(ValueError):
    place: str
    problem: str
    remedy: str

class Failed(RuntimeError): ...

class Recording:
    warnings: List[str]
    @staticmethod
    def read(
        path: str, topics: Optional[str], columns: Optional[str], robots: Sequence[Sequence[str]]
    ) -> Recording: ...
    @staticmethod
    def from_columns(
        name: str,
        robots: Sequence[Tuple[str, Sequence[Tuple[str, Sequence[Tuple[str, bytes]]]], Sequence[Tuple[str, float]]]],
        axle: bool,
        same_robot: bool,
        model: Optional[str],
    ) -> Recording: ...
    def write(self, folder: str) -> None: ...
    @property
    def name(self) -> str: ...
    @property
    def model(self) -> Optional[str]: ...
    def columns(self) -> List[Tuple[str, List[Tuple[str, List[Tuple[str, bytes]]]]]]: ...

def model_text(paths: Sequence[str]) -> str: ...

class Diagnosis:
    def json(self) -> str: ...
    def improved(self) -> List[Tuple[str, str]]: ...
    def page(self) -> str: ...
    def first_screen(self) -> str: ...

def diagnose(
    recordings: Sequence[Recording],
    against: Sequence[Recording],
    robots: Sequence[Tuple[Optional[str], str]],
    without: Sequence[str],
    exclude_time: Sequence[Tuple[float, float]],
    figures: bool,
    command_line: str,
) -> Diagnosis: ...
class Context:
    """What is known when a controller is made."""

    @property
    def robot(self) -> str:
        """Name of the robot; `r1` is the front robot."""
    @property
    def robots(self) -> List[str]:
        """Names of all robots, from the front."""
    @property
    def hears(self) -> List[str]:
        """Names of the robots that this one hears."""
    @property
    def settings(self) -> Dict[str, Any]:
        """Every key of the experiment, as nested dictionaries."""

class Heard:
    """The newest message of another robot. Times are those of the run (s)."""

    @property
    def pose(self) -> Tuple[float, float, float]:
        """x (m), y (m), φ (rad) of c, by its odometry."""
    @property
    def velocity(self) -> Tuple[float, float]:
        """Its reference velocity v_r (m/s), w_r (rad/s)."""
    @property
    def extra(self) -> List[float]:
        """The numbers that its controller adds."""
    @property
    def sampled_s(self) -> float:
        """When the encoders behind the pose were read."""
    @property
    def sent_s(self) -> float:
        """When it was sent."""
    @property
    def taken_s(self) -> float:
        """The outer tick at which it came out of the link."""
    @property
    def fresh(self) -> bool:
        """Whether it came at this tick."""

class OuterInput:
    """What is known at an outer tick. Poses are x (m), y (m), φ (rad) of c; velocities v (m/s), w (rad/s)."""

    @property
    def t_s(self) -> float:
        """Time of the run (s)."""
    @property
    def period_s(self) -> float:
        """Time since the last outer tick (s)."""
    @property
    def pose(self) -> Tuple[float, float, float]:
        """The robot's pose by odometry."""
    @property
    def velocity(self) -> Tuple[float, float]:
        """The robot's velocity by its wheels."""
    @property
    def reference(self) -> Tuple[float, float, float]:
        """Reference pose: `formation.spacing_m` behind the robot ahead, on its path; for the front robot, for one that does not hear
        the robot ahead, and before `formation.start_s` that of the profile."""
    @property
    def reference_velocity(self) -> Tuple[float, float]:
        """Reference velocity."""
    @property
    def error(self) -> Tuple[float, float, float]:
        """e_x (m), e_y (m), e_θ (rad): reference less pose of the midpoint of the axle, in the robot's frame."""
    @property
    def profile(self) -> Tuple[float, float, float]:
        """Where the robot would be if it had followed the profile exactly from its start."""
    @property
    def profile_velocity(self) -> Tuple[float, float]:
        """Velocity of the profile."""
    @property
    def coordinates(self) -> bool:
        """Whether coordination has begun (`formation.start_s`)."""
    @property
    def heard(self) -> Dict[str, Heard]:
        """The newest message of every robot that was heard, by its name."""

class InnerInput:
    """What is known at an inner tick. Pairs are right and left."""

    @property
    def t_s(self) -> float:
        """Time of the run (s)."""
    @property
    def period_s(self) -> float:
        """Time since the last inner tick (s)."""
    @property
    def wheel_speed_rad_s(self) -> Tuple[float, float]:
        """Mean wheel speeds since the last inner tick (rad/s)."""
    @property
    def velocity(self) -> Tuple[float, float]:
        """v (m/s) and w (rad/s) by these."""
    @property
    def desired(self) -> Tuple[float, float]:
        """v (m/s) and w (rad/s) that the outer loop asks for."""
    @property
    def set_point_rad_s(self) -> Tuple[float, float]:
        """The wheel speeds for them (rad/s)."""
    @property
    def limit_nm(self) -> Tuple[float, float]:
        """Torque limits (N m)."""
    @property
    def friction(self) -> Optional[float]:
        """Friction coefficient behind the limits, if they follow from friction."""
    @property
    def brakes(self) -> bool:
        """Whether the watchdog brakes, because no fresh position comes."""
    def paper(self) -> Tuple[float, float]:
        """The torques of the paper's PI speed loops (N m). They advance once in a tick, however often this is called."""

def run_agent(arguments: Sequence[str], make: Any) -> int: ...
def run(
    experiment: Optional[str],
    robots: Optional[int],
    models: Sequence[Tuple[Optional[str], str]],
    set: Sequence[Tuple[str, str]],
    seed: Optional[int],
    out: Optional[str],
    controllers: Sequence[Tuple[str, Any]],
) -> str: ...
def trace(path: str) -> str: ...
def study(
    robots: Optional[int],
    runs: Optional[int],
    numbers: Sequence[Tuple[str, Sequence[float]]],
    words: Sequence[Tuple[str, Sequence[str]]],
    threads: Optional[int],
) -> str: ...
def effects() -> List[Tuple[str, str, str, str, List[Tuple[str, str]]]]: ...
