"""A case whose truth is concealed, as the command's demo makes it, and what the command finds on it."""

from __future__ import annotations

import os
import subprocess
from pathlib import Path

import pytest

#: The command: a path in LACUNA, or built by cargo.
ROOT = Path(__file__).parents[2]


def pytest_addoption(parser: pytest.Parser) -> None:
    parser.addoption("--renew", action="store_true", help="write the notebooks anew, with their outputs")


class Command:
    """The command of the same sources."""

    def __init__(self) -> None:
        built = os.environ.get("LACUNA")
        self.words = [built] if built else ["cargo", "run", "-q", "-p", "lacuna", "--"]

    def __call__(self, *arguments: object) -> subprocess.CompletedProcess[str]:
        words = [*self.words, *map(str, arguments)]
        return subprocess.run(words, cwd=ROOT, capture_output=True, text=True, check=False)


class Case:
    """A model, recordings, and what the command says of them."""

    def __init__(self, folder: Path, command: Command) -> None:
        self.model = folder / "model.toml"
        self.runs = sorted((folder / "recordings").glob("*.csv"))
        self.found = folder / "found"
        self.said = command("diagnose", self.model, *self.runs, "--out", self.found)

    def json(self) -> str:
        """The text of diagnosis.json."""
        return (self.found / "diagnosis.json").read_text(encoding="utf-8")


@pytest.fixture(scope="session")
def command() -> Command:
    return Command()


@pytest.fixture(scope="session")
def case(tmp_path_factory: pytest.TempPathFactory, command: Command) -> Case:
    folder = tmp_path_factory.mktemp("demo")
    demo = command("demo", "--out", folder)
    assert demo.returncode == 0, demo.stderr
    case = Case(folder, command)
    assert case.said.returncode == 0, case.said.stderr
    return case
