from typing import List, Optional, Sequence, Tuple

__version__: str

class InputError(ValueError):
    place: str
    problem: str
    remedy: str

class Failed(RuntimeError): ...

class Recording:
    warnings: List[str]
    @staticmethod
    def read(path: str, topics: Optional[str], columns: Optional[str]) -> Recording: ...
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

def model_text(path: str) -> str: ...

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
def run(
    experiment: Optional[str],
    robots: Optional[int],
    models: Sequence[Tuple[Optional[str], str]],
    set: Sequence[Tuple[str, str]],
    seed: Optional[int],
    out: Optional[str],
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
