"""The module slipstream: the same answers as the command, arrays in and out, errors, Ctrl-C."""

import json
import os
import signal
import subprocess
import sys
import threading
import time
from pathlib import Path

import numpy
import pandas
import pytest

import slipstream

ROOT = Path(__file__).resolve().parents[3]
EXAMPLE = ROOT / "tests" / "example"
PRACTICE = ROOT.parent / "shared" / "practice"
COMMAND = os.environ.get("SLIPSTREAM_COMMAND", str(ROOT / "target" / "debug" / "slipstream"))


def by_command(recording, robot, folder):
    """The answer of the command."""
    file = folder / "answer.json"
    arguments = [COMMAND, "diagnose", str(recording), "--robot", str(robot), "--json", str(file)]
    subprocess.run(arguments, check=True, capture_output=True, cwd=folder)
    return json.loads(file.read_text())


@pytest.fixture(scope="module")
def example():
    return slipstream.diagnose(EXAMPLE / "recording", robot=EXAMPLE / "robot.toml", report=True)


def test_any_description_of_a_robot(tmp_path):
    wheels = {"robot": {"wheel_radius_m": 0.125, "half_track_m": 0.25}}
    yaml = tmp_path / "controller.yaml"
    yaml.write_text("c:\n  ros__parameters:\n    wheel_separation: 0.5\n    wheel_radius: 0.125\n")
    of = [slipstream.Recording.from_arrays({"r1": driven()}, robot=own).model for own in (wheels, yaml, str(yaml))]
    assert of[0] == of[1] == of[2]
    multipliers = tmp_path / "multipliers.yaml"
    multipliers.write_text("c:\n  left_wheel: l\n  right_wheel: r\n  wheel_separation_multiplier: 2.0\n")
    urdf = tmp_path / "two.urdf"
    round = "<collision><geometry><sphere radius='0.125'/></geometry></collision>"
    links = "".join(f"<link name='{side}'>{round}</link>" for side in "lr")
    joints = "".join(
        f"<joint name='{side}' type='continuous'><parent link='base_link'/><child link='{side}'/>"
        f"<origin xyz='0 {y} 0'/><axis xyz='0 1 0'/></joint>"
        for side, y in (("l", 0.125), ("r", -0.125))
    )
    urdf.write_text(f"<robot><link name='base_link'/>{links}{joints}</robot>")
    together = slipstream.Recording.from_arrays({"r1": driven()}, robot=[urdf, str(multipliers)]).model
    assert together == of[0]
    # Reading a bag, the joints that a robot's files name tell its wheels.
    folder = tmp_path / "recording"
    slipstream.Recording.from_arrays({"r1": driven()}).write(folder)
    read = [slipstream.Recording.read(folder, robot=own) for own in (None, [urdf, str(multipliers)], {"r1": urdf}, wheels)]
    assert len({own.name for own in read}) == 1
    with pytest.raises(slipstream.InputError, match="nowhere.urdf"):
        slipstream.Recording.read(folder, robot="nowhere.urdf")
    urdf = tmp_path / "robot.urdf"
    urdf.write_text("<robot>\n<link/></robot>")
    with pytest.raises(slipstream.InputError, match="robot.urdf:2: <link> has no name; add"):
        slipstream.Recording.from_arrays({"r1": driven()}, robot=urdf)


def driven(right=1.0, left=1.0, seconds=60.0):
    """Wheels and poses of a robot on a curvy way whose wheels are these multiples of 0.1 m; its half track is 0.2 m."""
    t = numpy.arange(0.0, seconds, 0.02)
    speed = 0.4 + 0.2 * numpy.sin(0.5 * t)
    turn = 0.6 * numpy.sin(0.23 * t) + 0.3 * numpy.sin(0.71 * t)
    yaw = numpy.concatenate([[0.0], numpy.cumsum(turn[:-1]) * 0.02])
    x = numpy.concatenate([[0.0], numpy.cumsum(speed[:-1] * numpy.cos(yaw[:-1] + 0.01 * turn[:-1])) * 0.02])
    y = numpy.concatenate([[0.0], numpy.cumsum(speed[:-1] * numpy.sin(yaw[:-1] + 0.01 * turn[:-1])) * 0.02])
    angles = [
        numpy.concatenate([[0.0], numpy.cumsum((speed + side * 0.2 * turn)[:-1]) * 0.02]) / (0.1 * scale)
        for side, scale in [(1.0, right), (-1.0, left)]
    ]
    noise = numpy.random.default_rng(7)
    return {
        "pose": {
            "t_s": t,
            "x_m": x + noise.normal(0.0, 0.002, t.size),
            "y_m": y + noise.normal(0.0, 0.002, t.size),
            "yaw_rad": yaw + noise.normal(0.0, 0.004, t.size),
        },
        "wheels": {"t_s": t, "angle_right_rad": angles[0], "angle_left_rad": angles[1]},
        "noise": {"pose_m": 0.002, "pose_rad": 0.004},
    }


MODEL = {"robot": {"wheel_radius_m": 0.1, "half_track_m": 0.2}}


def test_bags_and_foreign_csv_are_read_by_maps(tmp_path):
    bag = ROOT / "examples" / "cart" / "bag"
    guessed = slipstream.Recording.read(bag)
    assert "right_wheel_joint" in guessed.warnings[0]
    topics = tmp_path / "topics.toml"
    topics.write_text('format = 1\n[robots.cart]\npose = "/mocap/cart/pose"\n')
    assert slipstream.Recording.read(bag, topics=topics).warnings == []
    (tmp_path / "log.csv").write_text("ms,l,r\n0,0,0\n100,0.1,0.2\n")
    columns = tmp_path / "columns.toml"
    columns.write_text(
        'format = 1\n[robots.cart.wheels]\nt_s = { column = "ms", factor = 0.001 }\n'
        'angle_right_rad = "r"\nangle_left_rad = "l"\n'
    )
    read = slipstream.Recording.read(tmp_path / "log.csv", columns=columns)
    assert read.warnings == []
    with pytest.raises(slipstream.InputError, match="--columns"):
        slipstream.Recording.read(tmp_path / "log.csv")


def test_the_answer_is_that_of_the_command(example, tmp_path):
    assert example.to_dict() == by_command(EXAMPLE / "recording", EXAMPLE / "robot.toml", tmp_path)
    assert example.verdict == "explained"
    finding = example.findings[0]
    assert finding.effect == "rolling_resistance"
    own = finding.parameter("coefficient")
    assert own.ci95[0] < own.estimate < own.ci95[1]
    assert finding.actions[0].startswith("set rolling_resistance = { coefficient = 0.009")
    assert sum(part.share for part in example.budget[0].parts) == pytest.approx(example.budget[0].before)
    assert "rolling_resistance" in example.improved["r1"]


@pytest.mark.skipif(not PRACTICE.exists(), reason="the practice recordings are not here")
@pytest.mark.parametrize("number", range(1, 11) if os.environ.get("SLIPSTREAM_LONG") else (2, 8))
def test_practice_recordings_have_the_answer_of_the_command(number, tmp_path):
    name = f"practice-{number:02}"
    robot = PRACTICE / "robots" / f"{name}.toml"
    answer = slipstream.diagnose(PRACTICE / name, robot=robot)
    assert answer.to_dict() == by_command(PRACTICE / name, robot, tmp_path)


def test_arrays_in_answer_out_without_a_file(example):
    recording = slipstream.Recording.read(EXAMPLE / "recording")
    again = slipstream.Recording.from_arrays(
        {name: {**streams, "encoder_counts_per_rev": 1856, "noise": noise_of(name)} for name, streams in recording.to_arrays().items()},
        name=recording.name,
    )
    answer = slipstream.diagnose(again, robot=EXAMPLE / "robot.toml")
    assert answer.findings[0].effect == "rolling_resistance"
    assert answer.findings[0].parameters[0].estimate == pytest.approx(0.009, rel=0.01)


def noise_of(name):
    import re

    text = (EXAMPLE / "recording" / "recording.toml").read_text()
    table = text.split(f"[robots.{name}.noise]")[1] if f"[robots.{name}.noise]" in text else ""
    return {key: float(value) for key, value in re.findall(r"^(\w+) = ([\d.e-]+)", table, re.M)}


def test_a_smaller_wheel_is_found_from_arrays():
    recording = slipstream.Recording.from_arrays({"cart": driven(right=0.97, left=1.0)}, robot=MODEL, pose_point="axle")
    answer = slipstream.diagnose(recording)
    assert [finding.effect for finding in answer.findings] == ["wheel_radius"]
    right = answer.findings[0].parameter("right_scale")
    assert right.ci95[0] <= 0.97 <= right.ci95[1], right
    matched = slipstream.diagnose(
        slipstream.Recording.from_arrays({"cart": driven()}, robot=MODEL, pose_point="axle")
    )
    assert matched.verdict == "match"


def test_frames_and_folders_lead_back_to_the_same_arrays(tmp_path):
    recording = slipstream.Recording.from_arrays({"cart": driven(seconds=5.0)}, robot=MODEL, pose_point="axle")
    frames = recording.to_frames()
    assert list(frames["cart"]["pose"].columns) == ["x_m", "y_m", "yaw_rad"]
    again = slipstream.Recording.from_frames(frames, robot=MODEL, pose_point="axle")
    recording.write(tmp_path / "folder")
    read = slipstream.Recording.read(tmp_path / "folder")
    for other in (again, read):
        for stream, columns in recording.to_arrays()["cart"].items():
            for name, values in columns.items():
                numpy.testing.assert_array_equal(other.to_arrays()["cart"][stream][name], values)
    assert "wheel_radius_m = 0.1" in read.model


def test_frames_and_notebooks_show_the_answer(example, tmp_path):
    frame = example.to_frame()
    assert isinstance(frame, pandas.DataFrame)
    assert frame.loc[0, "estimate"] == example.findings[0].parameters[0].estimate
    shown = example._repr_html_()
    assert shown.startswith("<iframe srcdoc=") and "Rolling costs" in shown
    example.save_report(tmp_path / "page.html")
    page = (tmp_path / "page.html").read_text(encoding="utf-8")
    assert "Ruled out, down to which size" in page and "slipstream.diagnose(" in page


def test_runs_traces_and_studies(tmp_path):
    file = tmp_path / "run.mcap"
    one = slipstream.run(set={"links.delay_s": 0.08}, seed=3, out=file)
    two = slipstream.run(set={"links.delay_s": 0.08}, seed=3)
    assert one.state_hash == two.state_hash
    assert two.recording is None and set(two.data.to_arrays()) == {"r1", "r2", "r3"}
    assert list(one.to_frame()["robot"]) == ["r1", "r2", "r3"]
    trace = slipstream.trace(file)
    delays = trace.to_frame().query("stage == 'injected_delay'")
    assert delays["p50_s"].to_numpy() == pytest.approx(0.08)
    grid = {"jitter": [0.0], "loss": [0.0], "k_x": [1.0], "torque_limit": ["none"], "protocol": ["periodic"]}
    study = slipstream.study(delay=[0.0, 0.2], runs=1, **grid)
    assert list(study.to_frame()["delay_s"]) == [0.0, 0.2]


def test_effects_are_the_catalogue():
    effects = slipstream.effects()
    assert {"wheel_slip", "pose_latency"} <= set(effects["effect"])


@pytest.mark.parametrize(
    ("change", "place", "problem"),
    [
        (lambda own: own["pose"].pop("y_m"), "cart: pose", "has no column y_m"),
        (lambda own: own["pose"].update(y_m=[1.0]), "cart: pose", "column y_m has 1 rows"),
        (lambda own: own["pose"].update(t_s=own["pose"]["t_s"][::-1]), "cart: pose", "time runs backwards"),
        (lambda own: own["pose"].update(z_m=own["pose"]["x_m"]), "cart: pose", "has no use for column z_m"),
        (lambda own: own.update(lidar={"t_s": [0.0]}), "cart: lidar", "is not a stream"),
        (lambda own: own["wheels"].pop("t_s"), "cart: wheels", "has no column t_s"),
        (lambda own: own.update(encoder_counts_per_rev=0.5), "cart: encoder_counts_per_rev", "is 0.5"),
    ],
)
def test_wrong_arrays_are_said_with_their_place(change, place, problem):
    own = driven(seconds=5.0)
    change(own)
    with pytest.raises(slipstream.InputError) as raised:
        slipstream.Recording.from_arrays({"cart": own}, robot=MODEL)
    assert raised.value.place == place
    assert problem in raised.value.problem
    assert raised.value.remedy


def test_wrong_arguments_are_exceptions(tmp_path):
    recording = slipstream.Recording.from_arrays({"cart": driven(seconds=5.0)})
    for call in (
        lambda: slipstream.diagnose(tmp_path / "nowhere"),
        lambda: slipstream.diagnose(recording),
        lambda: slipstream.diagnose(recording, robot=MODEL, without=["gravity"]),
        lambda: slipstream.diagnose(recording, robot={"robot": {"wheel_radius_m": -1.0, "half_track_m": 0.2}}),
        lambda: slipstream.diagnose(recording, robot=tmp_path / "robot.toml"),
        lambda: slipstream.run("no_such_experiment"),
        lambda: slipstream.run(set={"links.dely_s": 0.1}),
        lambda: slipstream.trace(tmp_path / "nowhere.mcap"),
        lambda: slipstream.study(torque_limit=["strong"]),
    ):
        with pytest.raises(slipstream.InputError):
            call()


def test_other_threads_run_meanwhile():
    counted = [0]
    done = threading.Event()

    def count():
        while not done.is_set():
            counted[0] += 1
            time.sleep(0.001)

    thread = threading.Thread(target=count)
    thread.start()
    slipstream.diagnose(EXAMPLE / "recording", robot=EXAMPLE / "robot.toml")
    done.set()
    thread.join()
    assert counted[0] > 20


@pytest.mark.parametrize("work", ["diagnose(recording, robot=robot)", "study(runs=1000)"])
def test_ctrl_c_ends_the_work(work):
    program = f"""
import slipstream
recording = [{str(EXAMPLE / "recording")!r}] * 40
robot = {str(EXAMPLE / "robot.toml")!r}
print("ready", flush=True)
slipstream.{work}
"""
    child = subprocess.Popen([sys.executable, "-c", program], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    assert child.stdout.readline() == "ready\n"
    time.sleep(0.5)
    child.send_signal(signal.SIGINT)
    _, errors = child.communicate(timeout=30)
    assert "KeyboardInterrupt" in errors, errors
    assert child.returncode != 0
