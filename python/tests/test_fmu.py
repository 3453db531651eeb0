"""An FMU as the simulator: compiled here, where there is a C compiler."""

from __future__ import annotations

import shutil
import subprocess
import sys
import zipfile
from pathlib import Path

import numpy as np
import pytest

import lacuna

SOURCES = Path(__file__).parents[2] / "tests" / "cli_fmu"

TEXT = """name = "arm"
[parameters]
J = { value = 0.05, unit = "kg m^2" }
[[input]]
name = "tau"
unit = "N m"
[[coordinate]]
name = "q"
velocity = "dq"
unit = "rad"
[mechanics]
mass = [["1"]]
force = ["(tau - 0.03*dq - 0.4*sin(q))/J"]
"""


@pytest.fixture
def plant(tmp_path: Path) -> Path:
    compiler = shutil.which("cc")
    if compiler is None or sys.platform != "linux":
        pytest.skip("no C compiler (cc) on Linux")
    library = tmp_path / "arm.so"
    words = [compiler, "-w", "-shared", "-fPIC", "-DVERSION=3", "-o", str(library), str(SOURCES / "arm.c"), "-lm"]
    subprocess.run(words, check=True)
    description = (SOURCES / "arm3.xml").read_text(encoding="utf-8").replace("DIRECTIONAL", "true")
    machine = subprocess.run(["uname", "-m"], check=True, capture_output=True, text=True).stdout.strip()
    path = tmp_path / "plant.fmu"
    with zipfile.ZipFile(path, "w") as archive:
        archive.writestr("modelDescription.xml", description)
        archive.write(library, f"binaries/{machine}-linux/arm.so")
    return path


def test_an_fmu_runs_as_its_text_does(plant: Path, tmp_path: Path) -> None:
    model = lacuna.Model.from_fmu(plant)
    assert model.name == "plant"
    assert model.states == {"q": "rad", "dq": "rad/s"}
    assert model.inputs == {"tau": "N m"}
    assert model.parameters["J"].value == 0.05
    text = tmp_path / "arm.toml"
    text.write_text(TEXT, encoding="utf-8")
    t = np.arange(400) * 0.01
    recording = lacuna.Recording({"t": t, "q": 0.2 * np.cos(2.8 * t), "tau": 0.1 * np.sin(3.0 * t)}, time="t")
    own, expected = model.simulate(recording), lacuna.Model.from_toml(text).simulate(recording)
    assert own.channels["q"]["rmse"] == pytest.approx(expected.channels["q"]["rmse"], rel=1e-8)


def test_what_is_no_fmu_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "plant.fmu"
    path.write_bytes(b"no archive")
    with pytest.raises(lacuna.LacunaError, match="ZIP"):
        lacuna.Model.from_fmu(path)
