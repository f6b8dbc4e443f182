"""Makes the pictures of the README from the real programs: `just pictures`.

docs/diagnosis.png is the first screen of the page that `slipstream diagnose` writes for tests/example; docs/platoon.svg is a run of
the platoon, moving. Needs Chromium, and SLIPSTREAM or target/release/slipstream.
"""

import csv
import os
import subprocess
import tempfile
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
SLIPSTREAM = os.environ.get("SLIPSTREAM", str(ROOT / "target" / "release" / "slipstream"))
BROWSER = ["chromium", "--headless", "--no-sandbox", "--disable-gpu", "--hide-scrollbars", "--no-first-run"]
QUIET = ["--disable-background-networking", "--disable-component-update", "--disable-sync", "--disable-quic"]

# The part of the run that is shown (s), frames in a second, and pixels of a metre.
FROM_S, TO_S, RATE_HZ, METRE_PX = 4.0, 13.0, 10, 150
# Where the floor begins and ends (m), and size of the picture (pixels).
LEFT_M, RIGHT_M, HEIGHT_PX = -0.6, 5.3, 118
# Delay of the links (s).
DELAY_S = 0.3


def slipstream(folder, *arguments):
    subprocess.run([SLIPSTREAM, *arguments], cwd=folder, check=True, capture_output=True)


def diagnosis(folder):
    """The first screen of a diagnosis."""
    for name in ("recording", "robot.toml"):
        (folder / name).symlink_to(ROOT / "tests" / "example" / name)
    slipstream(folder, "diagnose", "recording", "--robot", "robot.toml", "--report", "page.html")
    file = ROOT / "docs" / "diagnosis.png"
    size = ["--window-size=1280,720", f"--screenshot={file}", f"--user-data-dir={folder / 'profile'}"]
    subprocess.run([*BROWSER, *QUIET, *size, f"file://{folder / 'page.html'}"], check=True, capture_output=True)


def column(file, name, times):
    """A column of a CSV file at these times (s)."""
    with open(file, newline="") as lines:
        rows = [(float(row["t_s"]), float(row[name])) for row in csv.DictReader(lines)]
    values, at = [], 0
    for t_s in times:
        while at + 1 < len(rows) and rows[at + 1][0] <= t_s:
            at += 1
        values.append(rows[at][1])
    return values


def moved(values, y_px):
    """An animation along x."""
    places = ";".join(f"{(value - LEFT_M) * METRE_PX:.1f},{y_px}" for value in values)
    return (
        f'<animateTransform attributeName="transform" type="translate" values="{places}" '
        f'dur="{TO_S - FROM_S:.0f}s" repeatCount="indefinite"/>'
    )


def platoon(folder):
    """Three robots with delayed links: where they are, and where their encoders believe them."""
    slipstream(folder, "run", "platoon", "--set", f"links.delay_s={DELAY_S}", "--out", "run.mcap")
    slipstream(folder, "export", "run.mcap", "--out", "csv")
    times = [FROM_S + k / RATE_HZ for k in range(int((TO_S - FROM_S) * RATE_HZ) + 1)]
    width_px = (RIGHT_M - LEFT_M) * METRE_PX
    floor_px = 84
    parts = [
        f'<svg xmlns="http://www.w3.org/2000/svg" width="{width_px:.0f}" height="{HEIGHT_PX}" '
        f'viewBox="0 0 {width_px:.0f} {HEIGHT_PX}" font-family="Inter,Segoe UI,Roboto,Arial,sans-serif" font-size="13">',
        '<rect width="100%" height="100%" fill="#fff"/>',
        f'<text x="12" y="20" fill="#14181c">Each robot follows the position that the one ahead sent {1000 * DELAY_S:.0f} ms ago.</text>',
        '<text x="12" y="38" fill="#b54708">Dashed: where its encoders believe it is. Wheels slip when the front robot speeds up.</text>',
        f'<path d="M0 {floor_px + 12}H{width_px:.0f}" stroke="#a3adb5"/>',
    ]
    for metre in range(6):
        x = (metre - LEFT_M) * METRE_PX
        parts.append(f'<path d="M{x:.0f} {floor_px + 12}v5" stroke="#a3adb5"/>')
        parts.append(f'<text x="{x:.0f}" y="{floor_px + 30}" fill="#5a656e" text-anchor="middle">{metre} m</text>')
    for robot, colour in (("r1", "#14181c"), ("r2", "#0a66a6"), ("r3", "#0a66a6")):
        seen = column(folder / "csv" / robot / "pose.csv", "x_m", times)
        start = column(folder / "csv" / robot / "pose.csv", "x_m", [0.0])[0]
        ticks = [column(folder / "csv" / robot / "wheels.csv", f"ticks_{side}", [0.0, *times]) for side in ("right", "left")]
        turn_m = 2.0 * 3.141592653589793 * 0.0365 / 1856
        believed = [start + turn_m * (a - ticks[0][0] + b - ticks[1][0]) / 2.0 for a, b in zip(ticks[0][1:], ticks[1][1:])]
        parts.append(
            f'<g><rect x="-17" y="-14" width="34" height="18" rx="4" fill="{colour}"/><circle cx="-9" cy="7" r="5" fill="{colour}" '
            f'stroke="#fff"/><circle cx="11" cy="8" r="4" fill="{colour}" stroke="#fff"/>'
            f'<text y="-1" fill="#fff" font-size="11" text-anchor="middle">{robot}</text>{moved(seen, floor_px)}</g>'
        )
        parts.append(
            '<g><rect x="-19" y="-16" width="38" height="22" rx="5" fill="none" stroke="#b54708" stroke-width="1.5" '
            f'stroke-dasharray="4 3"/>{moved(believed, floor_px)}</g>'
        )
    (ROOT / "docs" / "platoon.svg").write_text("\n".join(parts) + "\n</svg>\n", encoding="utf-8")


for picture in (diagnosis, platoon):
    with tempfile.TemporaryDirectory() as own:
        picture(Path(own))
