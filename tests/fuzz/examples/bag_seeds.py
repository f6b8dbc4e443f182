"""Writes the seeds of the targets ros1_bag and sqlite_bag, and one of bag, into tests/fuzz/seeds: small bags by another program.

usage: python tests/fuzz/examples/bag_seeds.py     (with the packages of tools/recording/tests/external/requirements.txt)
"""

import sqlite3
import sys
import tempfile
from pathlib import Path

ROOT = Path(__file__).resolve().parents[3]
sys.path.insert(0, str(ROOT / "tools/recording/tests/external"))

from rosbags.rosbag1 import Writer  # noqa: E402
from rosbags.rosbag2 import CompressionMode, StoragePlugin  # noqa: E402
from write_formats import write_ros1, write_ros2  # noqa: E402
from write_sources import APART, WHEEL_FRAMES, sensor_state, tf, write  # noqa: E402


def events():
    """Three rows of each stream."""
    for k in range(3):
        t = 50_000_000 * k
        yield t, "command", {"v_m_s": 0.5, "w_rad_s": 0.1 * k}
        yield t, "wheels", {"angle_right_rad": 0.2 * k, "angle_left_rad": 0.1 * k}
        yield t, "pose", {"x_m": 0.02 * k, "y_m": 1.0, "yaw_rad": 0.01 * k}


def seed(target, name, content):
    folder = ROOT / "tests/fuzz/seeds" / target
    folder.mkdir(parents=True, exist_ok=True)
    (folder / name).write_bytes(content)


def small(path):
    """A database of small pages, so that mutations meet its structure."""
    database = sqlite3.connect(path)
    for line in ["PRAGMA journal_mode = DELETE", "PRAGMA page_size = 512", "VACUUM"]:
        database.execute(line)
    database.close()
    return path.read_bytes()


def main(scratch):
    rows = list(events())
    kinds = {"plain": None, "lz4": Writer.CompressionFormat.LZ4, "bz2": Writer.CompressionFormat.BZ2}
    for name, compression in kinds.items():
        write_ros1(rows, scratch / name, compression)
        seed("ros1_bag", name, (scratch / name).read_bytes())
    for name, mode in {"plain": None, "zstd": CompressionMode.MESSAGE}.items():
        folder = write_ros2(rows, scratch / f"db_{name}", StoragePlugin.SQLITE3, mode)
        [file] = folder.glob("*.db3")
        seed("sqlite_bag", name, small(file))


def sources(scratch):
    """A bag with a few messages of each kind of wheels."""
    topics = {**APART, "/tf": tf(*WHEEL_FRAMES), "/sensor_state": sensor_state()}
    write(scratch / "sources", topics, rows=8)
    seed("bag", "sources", (scratch / "sources" / "sources.mcap").read_bytes())


if __name__ == "__main__":
    with tempfile.TemporaryDirectory() as scratch:
        main(Path(scratch))
        sources(Path(scratch))
