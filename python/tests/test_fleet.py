"""Fleets: what the command finds, on this process or on Dask, nothing lost and nothing done twice."""

from __future__ import annotations

import json
import os
import pickle
import signal
import subprocess
import sys
from pathlib import Path
from typing import Any

import lacuna
import numpy as np
import pytest

MODEL = """name = "drive"
[parameters]
m = { value = 2.0, unit = "kg", tolerance = 0.1 }
d = { value = 1.0, unit = "N s/m", tolerance = 0.1 }
[[input]]
name = "u"
unit = "N"
[[coordinate]]
name = "x"
velocity = "v"
unit = "m"
[mechanics]
mass = [["m"]]
force = ["u - d*v"]
"""
FLEET = 'model = "drive.toml"\nmachines = "data/*/"\n[options]\nonly = ["coulomb_friction"]\n'
#: The machine without friction.
ODD = "m5"


def _run(seed: int, friction: float) -> dict[str, Any]:
    """A drive that is pushed to and fro, in small steps."""
    rng = np.random.default_rng(seed)
    t = np.arange(400) * 0.01
    u = sum(rng.uniform(1, 3) * np.sin(rng.uniform(1, 8) * t + rng.uniform(0, 6)) for _ in range(4))
    x, v, measured, substeps = 0.0, 0.0, [], 20
    for force in u:
        measured.append(x)
        for _ in range(substeps):
            v += 0.01 / substeps * (force - v - friction * np.tanh(v / 0.02)) / 2.0
            x += 0.01 / substeps * v
    return {"t": t, "u": u, "x": np.array(measured) + 1e-4 * rng.standard_normal(len(t))}


@pytest.fixture(scope="module")
def machines() -> dict[str, list[dict[str, Any]]]:
    frictions = {f"m{k}": 0.0 if f"m{k}" == ODD else 1.0 + 0.02 * k for k in range(7)}
    return {name: [_run(10 * k + r, f) for r in range(2)] for k, (name, f) in enumerate(frictions.items())}


@pytest.fixture
def folder(tmp_path: Path, machines: dict[str, list[dict[str, Any]]]) -> Path:
    """A fleet in files."""
    (tmp_path / "drive.toml").write_text(MODEL, encoding="utf-8")
    (tmp_path / "fleet.toml").write_text(FLEET, encoding="utf-8")
    for name, runs in machines.items():
        place = tmp_path / "data" / name
        place.mkdir(parents=True)
        for k, run in enumerate(runs):
            columns = np.column_stack(list(run.values()))
            np.savetxt(place / f"{k}.csv", columns, "%.17g", ",", header="t,u,x", comments="")
    return tmp_path


def _written(out: Path) -> dict[str, int]:
    """When the diagnosis of each machine was written."""
    return {p.parent.name: p.stat().st_mtime_ns for p in sorted(out.glob("*/diagnosis.json"))}


def test_a_fleet_is_that_of_the_command(folder: Path, command: Any) -> None:
    fleet = lacuna.fleet.diagnose(folder / "fleet.toml", out=folder / "python")
    said = command("fleet", folder / "fleet.toml", "--out", folder / "command")
    assert said.returncode == 0, said.stderr
    assert list(fleet.unlike) == [ODD]
    assert "no dry friction on x" in fleet.unlike[ODD][0]
    assert fleet.failed == {}
    assert len(fleet.verdicts) == 7
    # In a notebook it is its page, which leads nowhere there.
    assert "no dry friction on x" in fleet._repr_html_() and "report.html" not in fleet._repr_html_()
    assert "m5/report.html" in (folder / "python" / "fleet.html").read_text(encoding="utf-8")
    for name in ("fleet.json", *(f"m{k}/diagnosis.json" for k in range(7))):
        assert (folder / "python" / name).read_bytes() == (folder / "command" / name).read_bytes()
    # What Python did, the command does not do again.
    again = command("fleet", folder / "fleet.toml", "--out", folder / "python").stdout
    assert again.count("was diagnosed before") == 7


def test_arrays_are_machines_too_and_a_bad_one_is_told(folder: Path, machines: dict[str, Any]) -> None:
    some = {name: machines[name] for name in ("m0", "m1")}
    some["broken"] = [{"t": np.arange(5.0), "x": np.arange(5.0)}]
    asked = {"only": ["coulomb_friction"], "out": folder / "out"}
    told: list[str] = []
    fleet = lacuna.fleet.diagnose(some, folder / "drive.toml", **asked, progress=told.append)
    assert told == [f"machines that are done: {k} of 3" for k in (1, 2, 3)]
    assert set(fleet.verdicts.values()) == {"missing_physics"}
    assert list(fleet.failed) == ["broken"]
    before = _written(folder / "out")
    lacuna.fleet.diagnose(some, folder / "drive.toml", **asked)
    assert _written(folder / "out") == before
    with pytest.raises(lacuna.LacunaError, match="fleet needs a model of a file"):
        lacuna.fleet.diagnose(some, **asked)
    with pytest.raises(lacuna.LacunaError, match="no machine is called 'm9'"):
        lacuna.fleet.diagnose(some, folder / "drive.toml", {"m9": some["m0"]}, **asked)


def test_recordings_cross_processes(machines: dict[str, Any]) -> None:
    sent = lacuna.Recording(machines["m0"][0], time="t", units={"x": "mm"}, name="a")
    got = pickle.loads(pickle.dumps(sent))
    assert (got.name, got._own.columns) == ("a", ["t", "u", "x"])
    columns, time_column, units, _ = got._own.parts()
    assert (time_column, units) == ("t", {"x": "mm"})
    assert np.array_equal(dict(columns)["x"], machines["m0"][0]["x"])
    assert pickle.loads(pickle.dumps(lacuna.Recording("a/run.csv")))._path == os.path.abspath("a/run.csv")


def test_records_may_be_packed(machines: dict[str, Any]) -> None:
    run = machines["m0"][0]
    packed = np.zeros(len(run["t"]), [("flag", "i1"), *((name, float) for name in run)])
    for name in run:
        packed[name] = run[name]
    fields = {name: packed[name] for name in run}
    assert not any(field.flags.aligned for field in fields.values())
    columns = dict(lacuna.Recording(fields)._own.parts()[0])
    assert all(np.array_equal(columns[name], run[name]) for name in run)
    fits = [lacuna.Identifier(2).fit(of["x"], of["u"], of["t"]) for of in (_as_columns(fields), _as_columns(run))]
    assert fits[0].to_json() == fits[1].to_json()


def _as_columns(run: dict[str, Any]) -> dict[str, Any]:
    """With x as a matrix of one column."""
    return {**run, "x": run["x"][:, None]}


def test_a_worker_that_is_killed_costs_nothing(folder: Path) -> None:
    distributed = pytest.importorskip("dask.distributed", reason="Dask is not installed")
    alone = lacuna.fleet.diagnose(folder / "fleet.toml", out=folder / "alone")
    out = folder / "cluster"
    with distributed.LocalCluster(n_workers=2, threads_per_worker=1, dashboard_address=None) as cluster:
        with distributed.Client(cluster) as client:
            victim = next(iter(client.run(os.getpid).values()))
            # The first machine that is done sees to it, in the middle of the work.
            killer = subprocess.Popen([sys.executable, "-c", KILLER, str(out), str(victim), str(int(signal.SIGKILL))])
            told: list[str] = []
            fleet = lacuna.fleet.diagnose(folder / "fleet.toml", client=client, out=out, progress=told.append)
            assert killer.wait() == 0
            assert told[-1] == "machines that are done: 7 of 7"
            before = _written(out)
            with pytest.raises(ZeroDivisionError):
                lacuna.fleet.diagnose(folder / "fleet.toml", client=client, out=out, progress=lambda _: 1 / 0)
            lacuna.fleet.diagnose(folder / "fleet.toml", client=client, out=out)
    assert _written(out) == before
    assert fleet.to_dict() == alone.to_dict()
    for name in before:
        inputs = [json.loads((where / name / "inputs.json").read_text()) for where in (out, folder / "alone")]
        assert inputs[0] == inputs[1]


#: Wait for the first machine that is done, then end a process.
KILLER = """
import os, pathlib, sys, time
while not list(pathlib.Path(sys.argv[1]).glob("*/inputs.json")):
    time.sleep(0.01)
os.kill(int(sys.argv[2]), int(sys.argv[3]))
"""


def test_the_module_runs_from_a_shell(folder: Path) -> None:
    pytest.importorskip("dask.distributed", reason="Dask is not installed")
    words = [sys.executable, "-m", "lacuna.fleet", "fleet.toml", "--workers", "1"]
    said = subprocess.run(words, cwd=folder, capture_output=True, text=True, check=False)
    assert said.returncode == 0, said.stderr
    assert f"1 of 7 machines is unlike the others: {ODD}" in said.stdout
    (folder / "fleet.toml").write_text(FLEET.replace("data", "dota"), encoding="utf-8")
    said = subprocess.run(words, cwd=folder, capture_output=True, text=True, check=False)
    assert (said.returncode, "fleet.toml:2:12" in said.stderr) == (2, True), said.stderr
