"""Controllers in Python: as programs and in this process, and the page that shows how, word by word."""

import json
import os
import re
import runpy
import subprocess
import sys
from pathlib import Path

import pytest

import slipstream

ROOT = Path(__file__).resolve().parents[3]
COMMAND = os.environ.get("SLIPSTREAM_COMMAND", str(ROOT / "target" / "debug" / "slipstream"))
PAGE = ROOT / "docs" / "how-to" / "my-controller.md"

EXAMPLES = ROOT / "examples"
PAPER = EXAMPLES / "paper_law.py"
Paper = runpy.run_path(str(PAPER))["Paper"]


def command(folder, *arguments):
    path = os.pathsep.join([str(Path(COMMAND).parent), str(Path(sys.executable).parent), os.environ["PATH"]])
    return subprocess.run(arguments, cwd=folder, capture_output=True, text=True, env={**os.environ, "PATH": path})


RANDOM = {"links.delay_s": 0.1, "links.jitter_s": 0.03, "links.loss": 0.1}


@pytest.mark.parametrize("robots", [3, 20])
@pytest.mark.parametrize("protocol", ["ring", "periodic"])
def test_the_papers_law_has_the_same_states(robots, protocol, tmp_path):
    keys = {**RANDOM, "links.protocol": protocol}
    built_in = slipstream.run(robots=robots, set=keys).state_hash
    assert slipstream.run(robots=robots, set=keys, controllers={"*": Paper}).state_hash == built_in
    sets = [word for key, value in keys.items() for word in ("--set", f"{key}={value}")]
    run = ["slipstream", "run", "--robots", str(robots), "--no-recording", "--json", "run.json", *sets]
    done = command(tmp_path, *run, "--agent", f"{sys.executable} {PAPER}")
    assert done.returncode == 0, done.stderr
    assert f'"{built_in}"' in (tmp_path / "run.json").read_text()


def test_controllers_get_parameters_messages_and_context():
    seen = []

    class Talks(Paper):
        gains = [1.0, 2.0]
        name = "none"
        leads = False

        def start(self, context):
            assert context.robots == ["r1", "r2", "r3"]
            assert context.settings["control"]["outer_period_s"] == 0.05
            self.robot, self.hears = context.robot, context.hears

        def message(self):
            return self.gains

        def outer(self, now):
            for name, heard in now.heard.items():
                assert name in self.hears
                seen.append((self.robot, name, heard.extra, heard.fresh, self.name, self.leads))
                assert heard.sampled_s <= heard.sent_s < now.t_s
            return super().outer(now)

    keys = {
        "links.protocol": "periodic",
        "links.topology": "all",
        "controller.*.gains": [3, 4.5],
        "controller.r2.name": "two",
        "controller.r3.leads": True,
    }
    run = slipstream.run(controllers={"*": Talks, "r1": Talks()}, set=keys)
    assert len(run.links) == 6
    assert {(robot, name) for robot, name, *_ in seen} == {(a, b) for a in ("r1", "r2", "r3") for b in ("r1", "r2", "r3") if a != b}
    assert all(extra == [3.0, 4.5] and fresh for _, _, extra, fresh, *_ in seen)
    assert {own[4] for own in seen if own[0] == "r2"} == {"two"}
    assert {own[5] for own in seen if own[0] == "r3"} == {True}


def test_an_inner_loop_of_ones_own():
    class Torques(Paper):
        def inner(self, now):
            right, left = now.paper()
            assert now.paper() == (right, left) and abs(right) <= now.limit_nm[0]
            return right, left

    assert slipstream.run(controllers={"*": Torques}).state_hash == slipstream.run().state_hash

    class Still(Paper):
        def inner(self, now):
            return 0.0, 0.0

    assert abs(slipstream.run(controllers={"r1": Still()}).robots[0]["final_true"][0] - 0.6096) < 1e-9


@pytest.mark.parametrize(
    "fault, said",
    [
        ("1 / 0, 0", "r2: its outer loop failed at 3.250 s: ZeroDivisionError: division by zero"),
        ("float('nan'), 0", "r2: its outer loop failed at 3.250 s: it gave v = NaN m/s, w = 0 rad/s"),
        ("None", "r2: its outer loop failed at 3.250 s: TypeError: outer gave None: give v"),
    ],
)
def test_a_fault_ends_the_run_with_robot_time_and_cause(fault, said, tmp_path):
    source = f"""
import slipstream

class Bad(slipstream.Controller):
    def outer(self, now):
        return now.reference_velocity if now.t_s < 3.21 else ({fault})
"""
    names = {}
    exec(source, names)
    with pytest.raises(slipstream.Failed) as raised:
        slipstream.run(controllers={"r2": names["Bad"]()})
    assert str(raised.value).startswith(said)
    assert (raised.value.__cause__ is None) == ("nan" in fault)
    (tmp_path / "bad.py").write_text(source + "\nslipstream.run_agent(Bad)\n")
    done = command(tmp_path, "slipstream", "run", "--no-recording", "--agent", f"r2={sys.executable} bad.py")
    assert done.returncode == 1
    first, *more = done.stderr.splitlines()
    assert first.startswith("slipstream: r2 (pid ") and said.removeprefix("r2: ") in first
    assert any("bad.py" in line and "in outer" in line for line in more) == ("/" in fault)


def test_unusable_controllers_are_refused(tmp_path):
    with pytest.raises(slipstream.InputError, match="controller.r2.gain: is no parameter of the controller of r2; give one of k_theta, k_x, k_y"):
        slipstream.run(controllers={"*": Paper}, set={"controller.r2.gain": 1})
    with pytest.raises(slipstream.InputError, match="agents.r1: names true, and this run has no processes"):
        slipstream.run(set={"agents.r1": "true"})
    (tmp_path / "bad.py").write_text("import slipstream\nclass Bad(slipstream.Controller):\n    def start(self, context): raise KeyError('k')\nslipstream.run_agent(Bad)\n")
    done = command(tmp_path, "slipstream", "run", "--no-recording", "--agent", f"{sys.executable} bad.py")
    assert done.returncode == 2
    assert "bad.py" in done.stderr and done.stderr.splitlines()[-1].endswith("KeyError: 'k'; correct the program")


def test_the_example_of_model_predictive_control(tmp_path):
    pytest.importorskip("scipy")
    program = f"{sys.executable} {EXAMPLES / 'mpc.py'}"
    run = ["slipstream", "run", "--set", "links.delay_s=0.1", "--no-recording", "--json", "run.json", "--agent", program]
    done = command(tmp_path, *run)
    assert done.returncode == 0, done.stderr
    answer = slipstream.Run(json.loads((tmp_path / "run.json").read_text()), None)
    for robot in answer.robots[1:]:
        # The wheels hardly slip, and the robot ends where it should.
        assert sum(robot["slip_time_s"]) < 0.2 and robot["max_spacing_error_m"] < 0.35
        assert abs(robot["final_true"][0] - answer.robots[0]["final_true"][0] + 0.6096 * int(robot["robot"][1:]) - 0.6096) < 0.05


def test_the_page_on_own_controllers_is_true_word_by_word(tmp_path):
    blocks = re.findall(r"```(\w+)\n(.*?)```", PAGE.read_text(), re.S)
    ran = 0
    for language, text in blocks:
        name = re.match(r"# (\w+\.\w+)\n", text)
        if name:
            (tmp_path / name[1]).write_text(text)
        if language == "python" and name and "run_agent" not in text:
            done = command(tmp_path, sys.executable, name[1])
            assert re.fullmatch(r"[0-9a-f]{64}\n", done.stdout), done.stderr
        if language != "console":
            continue
        for line, shown in re.findall(r"^\$ (.*)\n((?:[^$].*\n|\n)*)", text, re.M):
            # What is installed and built is there; programs of a build are tested elsewhere.
            if line.startswith(("pip ", "cargo ")) or "target/release" in line:
                continue
            done = command(tmp_path, "sh", "-c", line)
            assert done.returncode == 0, (line, done.stderr)
            ran += 1
            for wanted in filter(None, shown.splitlines()):
                pattern = re.escape(wanted).replace("…", r"[\d.]+")
                assert re.search(f"^{pattern}$", done.stdout, re.M), (wanted, done.stdout)
    assert ran == 6
    assert (tmp_path / "mine-2.mcap").exists() or (tmp_path / "mine.mcap").exists()
