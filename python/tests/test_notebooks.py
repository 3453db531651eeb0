"""The notebooks run, find what they conceal, and say what they say in the repository.

``pytest python/tests/test_notebooks.py --renew`` writes them anew, with their outputs.
"""

from __future__ import annotations

import os
from collections.abc import Iterator
from pathlib import Path

import pytest

for needed in ("nbclient", "ipykernel", "matplotlib"):
    pytest.importorskip(needed, reason=f"{needed} is not installed (pip install './python[notebooks]')")

import notebooks  # noqa: E402
from nbformat.v4 import new_code_cell, new_notebook  # noqa: E402

#: What some of them import beside.
NEEDS = {"arm_from_mjcf": "mujoco", "fleet": "dask.distributed"}
#: What is being done, told to a notebook, and to one that does not want to know.
TELLING = """from lacuna._progress import Teller
with Teller({progress}) as tell:
    for doing in ("screening", "fitting") if tell else ():
        tell(doing)
"""
#: The largest that a notebook may be, in bytes: they are read on the web.
LARGEST = 150_000
#: Where settings and kernels of whoever runs this are looked for.
SETTINGS = ("IPYTHON", "JUPYTER_", "MPL", "XDG_")


@pytest.fixture(scope="module", autouse=True)
def home(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Path]:
    """A home of their own: nobody's settings are read, and none written."""
    place = tmp_path_factory.mktemp("home")
    with pytest.MonkeyPatch.context() as patch:
        for name in [name for name in os.environ if name.startswith(SETTINGS)]:
            patch.delenv(name)
        patch.setenv("HOME", str(place))
        patch.setenv("USERPROFILE", str(place))
        # The kernel of the Python that runs this, before those of the machine.
        patch.setenv("JUPYTER_PREFER_ENV_PATH", "1")
        yield place


@pytest.mark.parametrize("name", notebooks.NAMES)
def test_a_notebook_runs_and_says_what_it_said(
    name: str, tmp_path: Path, home: Path, request: pytest.FixtureRequest
) -> None:
    if name in NEEDS:
        pytest.importorskip(NEEDS[name], reason=f"{NEEDS[name]} is not installed")
    committed = notebooks.read(name)
    run = notebooks.kept(notebooks.execute(notebooks.read(name), tmp_path))
    text = notebooks.text(run)
    for private in (tmp_path, home, Path(__file__).parents[2]):
        assert str(private) not in text
    assert len(text) < LARGEST
    if request.config.getoption("--renew"):
        notebooks.write(name, run)
    else:
        assert notebooks.words(run) == notebooks.words(committed)


def test_progress_is_one_line_that_is_cleared(tmp_path: Path) -> None:
    cells = [new_code_cell(TELLING.format(progress=progress)) for progress in (None, False)]
    told, silent = notebooks.execute(new_notebook(cells=cells), tmp_path).cells
    (line,) = told.outputs
    assert (line.output_type, line.data) == ("display_data", {"text/plain": ""})
    assert silent.outputs == []


def test_what_is_committed_is_what_is_kept() -> None:
    for name in notebooks.NAMES:
        committed = notebooks.read(name)
        assert notebooks.text(notebooks.kept(notebooks.read(name))) == notebooks.text(committed)
        assert all(cell.execution_count for cell in committed.cells if cell.cell_type == "code")
