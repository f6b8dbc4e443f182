"""The notebooks run from the first cell to the last."""

from pathlib import Path

import nbclient
import nbformat

FOLDER = Path(__file__).resolve().parents[1]


def run(name):
    notebook = nbformat.read(FOLDER / name, as_version=4)
    done = nbclient.NotebookClient(notebook, timeout=300, kernel_name="python3").execute()
    return [output for cell in done.cells for output in cell.get("outputs", []) if "data" in output]


def test_the_notebook_on_calibration_runs():
    assert any("<iframe srcdoc=" in output["data"].get("text/html", "") for output in run("calibrate.ipynb"))


def test_the_notebook_on_controllers_runs():
    assert len(run("controllers.ipynb")) == 3
