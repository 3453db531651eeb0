"""The notebooks of examples/notebooks: executed, and what of their outputs is kept in the repository."""

from __future__ import annotations

import re
from pathlib import Path

import nbclient
import nbformat

FOLDER = Path(__file__).parents[2] / "examples" / "notebooks"
NAMES = ["concealed_effect", "arm_from_mjcf", "function_as_simulator", "fleet"]
#: The longest that a cell may take, in seconds: far more than any does.
TIMEOUT = 300

#: Numbers with what is before and after them, and space, which follows from how long these are.
_NUMBER = re.compile(r"(?:[<>] ?)?[-+]?\d+(?:\.\d+)?(?:e[-+]?\d+)?")
_SPACE = re.compile(r"\s+")


def read(name: str) -> nbformat.NotebookNode:
    """A notebook as it is in the repository."""
    return nbformat.read(FOLDER / f"{name}.ipynb", as_version=4)


def text(notebook: nbformat.NotebookNode) -> str:
    """A notebook as its file has it."""
    return nbformat.writes(notebook) + "\n"


def write(name: str, notebook: nbformat.NotebookNode) -> None:
    """Put a notebook into the repository."""
    (FOLDER / f"{name}.ipynb").write_text(text(notebook), encoding="utf-8")


def execute(notebook: nbformat.NotebookNode, folder: Path) -> nbformat.NotebookNode:
    """Run all cells in a folder, by the Python that runs this; raises what a cell raises."""
    nbclient.NotebookClient(
        notebook,
        timeout=TIMEOUT,
        kernel_name="python3",
        resources={"metadata": {"path": str(folder)}},
        record_timing=False,
    ).execute()
    return notebook


def kept(notebook: nbformat.NotebookNode) -> nbformat.NotebookNode:
    """What is committed: text, tables and pictures, and nothing of the machine that made them.

    Pages are left out: they are large, and GitHub shows none; their text stands in their place.
    """
    for cell in notebook.cells:
        cell.metadata = {}
        if cell.cell_type == "code":
            cell.outputs = [output for output in map(_kept_output, cell.outputs) if output is not None]
    notebook.metadata.language_info = {"name": "python"}
    return notebook


def _kept_output(output: nbformat.NotebookNode) -> nbformat.NotebookNode | None:
    data = output.get("data", {})
    if data.get("text/html", "").startswith("<iframe"):
        del data["text/html"]
    # A line of progress that was cleared.
    return None if data == {"text/plain": ""} else output


def words(notebook: nbformat.NotebookNode) -> list[str]:
    """What each cell says first, without its numbers: of a diagnosis what is missing, and where.

    Numbers, and by these what else is said, may differ in their last digits from processor to processor.
    """
    said = []
    for cell in notebook.cells:
        outputs = cell.get("outputs", [])
        text = "".join(o.get("text", "") or o.get("data", {}).get("text/plain", "") for o in outputs)
        said.append(_SPACE.sub(" ", _NUMBER.sub("#", text)).strip().split(". ")[0])
    return said
