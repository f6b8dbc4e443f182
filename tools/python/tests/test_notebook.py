"""The notebook runs from the first cell to the last."""

from pathlib import Path

import nbclient
import nbformat

NOTEBOOK = Path(__file__).resolve().parents[1] / "calibrate.ipynb"


def test_the_notebook_runs():
    notebook = nbformat.read(NOTEBOOK, as_version=4)
    done = nbclient.NotebookClient(notebook, timeout=300, kernel_name="python3").execute()
    shown = [output for cell in done.cells for output in cell.get("outputs", []) if "data" in output]
    assert any("<iframe srcdoc=" in output["data"].get("text/html", "") for output in shown)
