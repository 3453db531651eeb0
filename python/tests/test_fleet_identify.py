"""One model of many files: the same to the last bit whoever makes it, nothing lost, and what is wrong is named."""

from __future__ import annotations

import os
import pickle
import signal
import threading
import time
from pathlib import Path
from typing import Any

import lacuna
import numpy as np
import pytest

pa = pytest.importorskip("pyarrow", reason="pyarrow is not installed")
pq = pytest.importorskip("pyarrow.parquet", reason="pyarrow is not installed")

SAMPLES, STEP, COUNT, FILES = 41, 0.04, 6000, 4
NAMES = {"coordinates": ["q"], "rates": ["v"], "inputs": ["u"], "trajectory": "id", "order": 2}
#: Small and quick.
CHOSEN = {"kernel": "gaussian", "widths": [1.5, 4.0], "most_landmarks": 40}


def _drift(q: Any, v: Any) -> Any:
    return -2.0 * np.sin(q) - 0.3 * v


def _columns(count: int, seed: int, samples: int = SAMPLES) -> dict[str, Any]:
    """q'' = -2 sin q - 0.3 q' + u, with u held from sample to sample."""
    rng = np.random.default_rng(seed)
    q, v = rng.uniform(-2, 2, (2, count))
    w, p = rng.uniform(1, 4, count), rng.uniform(0, 6, count)
    rows, h = np.empty((samples, 3, count)), STEP / 10
    for k in range(samples):
        u = 1.5 * np.sin(w * k * STEP + p)
        rows[k] = q, v, u
        for _ in range(10):
            middle = q + 0.5 * h * v, v + 0.5 * h * (_drift(q, v) + u)
            q, v = q + h * middle[1], v + h * (_drift(*middle) + u)
    rows[:, :2] += 1e-3 * rng.standard_normal((samples, 2, count))
    q, v, u = (np.ascontiguousarray(rows[:, i].T).ravel() for i in range(3))
    return {
        "id": np.repeat(np.arange(count), samples),
        "t": np.tile(np.arange(samples) * STEP, count),
        "q": q,
        "v": v,
        "u": u,
        "not asked for": np.full(count * samples, np.nan),
    }


def _write(path: Path, columns: dict[str, Any], rows: int) -> None:
    pq.write_table(pa.table(columns), path, row_group_size=rows)


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Files whose row groups end within trajectories."""
    folder = tmp_path_factory.mktemp("many")
    for k in range(FILES):
        _write(folder / f"{k}.parquet", _columns(COUNT // FILES, k), 10_007)
    return folder


@pytest.fixture(scope="module")
def alone(folder: Path) -> lacuna.Identifier:
    return lacuna.fleet.identify(folder / "*.parquet", **NAMES, **CHOSEN)


def test_nothing_is_lost_and_the_model_is_right(alone: lacuna.Identifier, tmp_path: Path) -> None:
    assert alone.report_["windows"] == COUNT
    assert alone.report_["samples"] == COUNT * SAMPLES
    x = np.random.default_rng(0).uniform(-1.5, 1.5, (200, 2))
    f, std = alone.drift(x, return_std=True)
    truth = _drift(*x.T)[:, None]
    assert np.abs(f - truth).max() < 0.03
    assert (std > 0).all() and std.max() < 0.05
    assert np.abs(alone.effectiveness(x) - 1.0).max() < 0.03
    assert np.allclose(alone.predict(x, np.ones(200)), f + alone.effectiveness(x)[:, :, 0])
    one = {name: column[:SAMPLES] for name, column in _columns(1, 99).items()}
    run = alone.simulate([one["q"][0], one["v"][0]], one["u"], one["t"])
    assert np.abs(run[:, 0] - one["q"]).max() < 0.02
    alone.save(tmp_path / "model.json")
    assert (tmp_path / "model.json").read_text() == alone.to_json()
    assert pickle.loads(pickle.dumps(alone)).to_json() == alone.to_json()


def test_workers_do_not_matter(folder: Path, alone: lacuna.Identifier) -> None:
    distributed = pytest.importorskip("dask.distributed", reason="Dask is not installed")
    for workers in (1, 2):
        options = {"n_workers": workers, "threads_per_worker": 1, "dashboard_address": None}
        with distributed.LocalCluster(**options) as cluster, distributed.Client(cluster) as client:
            found = lacuna.fleet.identify(folder / "*.parquet", client=client, **NAMES, **CHOSEN)
            assert found.to_json() == alone.to_json()
            if workers == 1:
                with pytest.raises(lacuna.LacunaError, match="widths"):
                    lacuna.fleet.identify(folder / "*.parquet", client=client, widths=[1.0], **NAMES)


def test_a_worker_that_is_killed_costs_nothing(folder: Path, alone: lacuna.Identifier) -> None:
    distributed = pytest.importorskip("dask.distributed", reason="Dask is not installed")
    with distributed.LocalCluster(n_workers=2, threads_per_worker=1, dashboard_address=None) as cluster:
        with distributed.Client(cluster) as client:
            victim = next(iter(client.run(os.getpid).values()))

            done, killed = threading.Event(), []

            def kill() -> None:
                # As soon as one holds something that others need.
                while not done.wait(0.01):
                    if any(client.has_what().values()):
                        os.kill(victim, signal.SIGKILL)
                        killed.append(victim)
                        return

            killer = threading.Thread(target=kill)
            killer.start()
            try:
                found = lacuna.fleet.identify(folder / "*.parquet", client=client, **NAMES, **CHOSEN)
            finally:
                done.set()
                killer.join()
    assert killed == [victim]
    assert found.to_json() == alone.to_json()


def test_a_file_is_a_trajectory_where_no_column_tells(tmp_path: Path) -> None:
    for k in range(6):
        columns = _columns(1, k, samples=300)
        del columns["id"]
        _write(tmp_path / f"{k}.parquet", columns, 70)
    found = lacuna.fleet.identify(tmp_path / "*.parquet", **{**NAMES, "trajectory": None}, **CHOSEN)
    assert (found.report_["windows"], found.report_["samples"]) == (6, 1800)


@pytest.mark.parametrize(
    ("spoil", "said"),
    [
        ({"q": (517, np.nan)}, r"1\.parquet, row group 1, row 17 \(from 0\): q is NaN, expected a finite number"),
        ({"t": (5, 0.0)}, r"1\.parquet, row group 0, 41 rows from row 0 \(from 0\) on \(id = 0\): times must increase"),
        ({"id": (500, 77)}, r"1\.parquet, row group 1, 1 rows from row 0 \(from 0\) on \(id = 77\): .*samples, found 1"),
        ({"id": (0, 2**60)}, r"1\.parquet, row group 0, row 0 \(from 0\): id is .*whole numbers below 2\^53"),
    ],
)
def test_what_is_wrong_is_named(tmp_path: Path, spoil: dict[str, Any], said: str) -> None:
    for k in range(2):
        columns = _columns(40, k)
        for name, (row, value) in spoil.items() if k == 1 else ():
            columns[name][row] = value
        _write(tmp_path / f"{k}.parquet", columns, 500)
    with pytest.raises(lacuna.LacunaError, match=said):
        lacuna.fleet.identify(tmp_path / "*.parquet", **NAMES, **CHOSEN)


def test_files_are_looked_at_before_anything_is_read(tmp_path: Path) -> None:
    files = tmp_path / "*.parquet"
    with pytest.raises(lacuna.LacunaError, match="matches 0 files"):
        lacuna.fleet.identify(files, **NAMES)
    for k in range(2):
        _write(tmp_path / f"{k}.parquet", _columns(40, k), 500)
    for change, said in (
        ({"inputs": ["tau"]}, "0.parquet has no column 'tau'"),
        ({"inputs": ["q"]}, "column 'q' is named twice"),
        ({"rates": ["v", "u"]}, "a rate for each of the 1 coordinates, found 2"),
        ({"coordinates": []}, "at least one coordinate"),
        ({"order": 1}, "order 2"),
    ):
        with pytest.raises(lacuna.LacunaError, match=said):
            lacuna.fleet.identify(files, **{**NAMES, **change})
    torn = tmp_path / "1.parquet"
    whole = torn.read_bytes()
    torn.write_bytes(whole[: len(whole) // 2])
    with pytest.raises(lacuna.LacunaError, match="1.parquet cannot be read as Parquet"):
        lacuna.fleet.identify(files, **NAMES)
    # Its end is there, and a page of the second row group is not.
    group = pq.ParquetFile(tmp_path / "0.parquet").metadata.row_group(1).column(2)
    start = group.dictionary_page_offset or group.data_page_offset
    torn.write_bytes(whole[:start] + bytes(group.total_compressed_size) + whole[start + group.total_compressed_size :])
    with pytest.raises(lacuna.LacunaError, match=r"row group 1: .*1.parquet cannot be read as Parquet"):
        lacuna.fleet.identify(files, **NAMES, **CHOSEN)


def _trial(rng: np.random.Generator) -> float:
    return float(rng.standard_normal())


def _fails(rng: np.random.Generator) -> float:
    if rng.bit_generator.seed_seq.spawn_key == (0,):
        time.sleep(1.0)  # the first trial is the last to fail
    raise ValueError("no such machine")


def test_a_study_depends_on_its_seed_alone() -> None:
    distributed = pytest.importorskip("dask.distributed", reason="Dask is not installed")
    drawn = lacuna.fleet.study(_trial, 2500, seed=4)
    assert len(set(drawn)) == 2500
    assert lacuna.fleet.study(_trial, 3, seed=4) == drawn[:3]
    assert lacuna.fleet.study(_trial, 3, seed=5) != drawn[:3]
    assert lacuna.fleet.study(_trial, 0) == []
    with distributed.LocalCluster(n_workers=2, threads_per_worker=1, dashboard_address=None) as cluster:
        with distributed.Client(cluster) as client:
            assert lacuna.fleet.study(_trial, 2500, seed=4, client=client) == drawn
            with pytest.raises(lacuna.LacunaError, match="trial 0 of seed 0: ValueError: no such machine"):
                lacuna.fleet.study(_fails, 3, client=client)
    with pytest.raises(lacuna.LacunaError, match="0 or more"):
        lacuna.fleet.study(_trial, -1)
