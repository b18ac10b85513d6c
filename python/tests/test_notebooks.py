"""The notebooks run, and show a plot each."""

from __future__ import annotations

import base64
import os
from pathlib import Path

import nbformat
import pytest
from nbclient import NotebookClient

NOTEBOOKS = sorted((Path(__file__).parent.parent / "notebooks").glob("*.ipynb"))


@pytest.mark.parametrize("file", NOTEBOOKS, ids=lambda file: file.stem)
def test_a_notebook_runs_and_shows_a_plot(file: Path, tmp_path: Path) -> None:
    """With PICTURES set to a folder, the plots are written there: those of docs/notebooks.md."""
    notebook = nbformat.reads(file.read_text(encoding="utf-8"), as_version=4)  # type: ignore[no-untyped-call]
    stored = [cell.outputs for cell in notebook.cells if cell.cell_type == "code"]
    assert not any(stored), "a notebook is stored without outputs"
    NotebookClient(notebook, timeout=600, resources={"metadata": {"path": str(tmp_path)}}).execute()
    outputs = [output for cell in notebook.cells if cell.cell_type == "code" for output in cell.outputs]
    pictures = [output.data["image/png"] for output in outputs if "image/png" in output.get("data", {})]
    assert len(pictures) == 1, outputs
    if folder := os.environ.get("PICTURES"):
        Path(folder, f"notebook-{file.stem.replace('_', '-')}.png").write_bytes(base64.b64decode(pictures[0]))


def test_there_are_three_notebooks() -> None:
    assert [file.stem for file in NOTEBOOKS] == ["clones", "first_steps", "pump_down"]
