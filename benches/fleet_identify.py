"""`lacuna.fleet.identify` on many trajectories: made with ``make``, measured with ``run``.

    python benches/fleet_identify.py make DIR --trajectories 1000000
    python benches/fleet_identify.py run DIR --workers 1 2
    python benches/fleet_identify.py sums DIR --workers 1 2 --most-landmarks 150

The machine is the two-link arm of the studies (`lacuna_plants::TwoLinkArm`), with torques that are held from sample to
sample and noise on what is measured; ``run`` tells how far the drift is from the arm's own. ``sums`` measures
the sums alone, of kernels whose widths are given.
"""

from __future__ import annotations

import argparse
import hashlib
import os
import time
from pathlib import Path
from typing import Any

import numpy as np

#: 1 s every 0.02 s, and steps of integration in between.
SAMPLES, STEP, SUBSTEPS = 51, 0.02, 2
#: Trajectories of a row group and of a file.
GROUP, FILE = 500, 50_000
#: Noise on coordinates (rad) and rates (rad/s).
NOISE, RATE_NOISE = 1e-3, 5e-3
#: Range of the initial states, rad and rad/s.
RANGE = 3.0
P1, P2, P3 = 3.473, 0.196, 0.242
VISCOUS, STATIC = (5.3, 1.1), (8.45, 2.35)


def acceleration(x: Any, tau: Any) -> Any:
    """Joint accelerations of states ``(4, N)`` under torques ``(2, N)``."""
    _, q2, d1, d2 = x
    cos, s = np.cos(q2), P3 * np.sin(q2)
    r1 = tau[0] + s * d2 * d1 + s * (d1 + d2) * d2 - VISCOUS[0] * d1 - STATIC[0] * np.tanh(d1)
    r2 = tau[1] - s * d1 * d1 - VISCOUS[1] * d2 - STATIC[1] * np.tanh(d2)
    a, b, c = P1 + 2 * P3 * cos, P2 + P3 * cos, P2
    determinant = a * c - b * b
    return np.stack([(c * r1 - b * r2) / determinant, (a * r2 - b * r1) / determinant])


def rates(x: Any, tau: Any) -> Any:
    return np.concatenate([x[2:], acceleration(x, tau)])


def trajectories(count: int, seed: tuple[int, int]) -> dict[str, Any]:
    """Columns of so many trajectories, one after the other."""
    rng = np.random.default_rng(seed)
    x = rng.uniform(-RANGE, RANGE, (4, count))
    amplitude, frequency = rng.uniform(-10, 10, (2, 3, count)), rng.uniform(1, 10, (2, 3, count))
    phase = rng.uniform(0, 2 * np.pi, (2, 3, count))
    states, torques, h = np.empty((SAMPLES, 4, count)), np.empty((SAMPLES, 2, count)), STEP / SUBSTEPS
    for k in range(SAMPLES):
        tau = (amplitude * np.sin(frequency * (k * STEP) + phase)).sum(axis=1)
        states[k], torques[k] = x, tau
        for _ in range(SUBSTEPS):
            a = rates(x, tau)
            b = rates(x + 0.5 * h * a, tau)
            c = rates(x + 0.5 * h * b, tau)
            d = rates(x + h * c, tau)
            x = x + h / 6 * (a + 2 * (b + c) + d)
    noise = np.array([NOISE, NOISE, RATE_NOISE, RATE_NOISE])[:, None]
    states += noise * rng.standard_normal(states.shape)
    flat = [np.ascontiguousarray(c.T).ravel() for c in (*np.moveaxis(states, 1, 0), *np.moveaxis(torques, 1, 0))]
    return dict(zip(("q1", "q2", "dq1", "dq2", "tau1", "tau2"), flat))


def make(folder: Path, count: int) -> None:
    import pyarrow as pa
    import pyarrow.parquet as pq

    folder.mkdir(parents=True, exist_ok=True)
    for file, first in enumerate(range(0, count, FILE)):
        writer = None
        own = min(FILE, count - first)
        for at in range(0, own, 5 * GROUP):
            some = min(5 * GROUP, own - at)
            numbers = np.repeat(np.arange(first + at, first + at + some), SAMPLES)
            columns = {"id": numbers, "t": np.tile(np.arange(SAMPLES) * STEP, some)}
            table = pa.table({**columns, **trajectories(some, (file, at))})
            writer = writer or pq.ParquetWriter(folder / f"arm{file:03}.parquet", table.schema)
            writer.write_table(table, row_group_size=GROUP * SAMPLES)
        if writer is not None:
            writer.close()


def run(folder: Path, workers: list[int], most_landmarks: int) -> None:
    import lacuna
    from dask.distributed import Client, LocalCluster

    for count in workers:
        with LocalCluster(n_workers=count, threads_per_worker=1, dashboard_address=None) as cluster:
            with Client(cluster) as client:
                load = os.getloadavg()[0]
                begin = time.perf_counter()
                model = lacuna.fleet.identify(
                    folder / "*.parquet",
                    client=client,
                    order=2,
                    coordinates=["q1", "q2"],
                    rates=["dq1", "dq2"],
                    inputs=["tau1", "tau2"],
                    trajectory="id",
                    most_landmarks=most_landmarks,
                )
                seconds = time.perf_counter() - begin
                peaks = client.run(peak)
        used = [round(own) for own, _ in peaks.values()]
        busy = [round(cpu) for _, cpu in peaks.values()]
        digest = hashlib.sha256(model.to_json().encode()).hexdigest()
        print(f"{count} workers: {seconds:.1f} s, CPU of workers {busy} s, their peak memory {used} MB, load before {load:.1f}")
        print(f"  sha256 of the model {digest[:16]}, drift off by {error(model):.4f} (median, relative)", flush=True)


def sums(folder: Path, workers: list[int], most_landmarks: int) -> None:
    import pickle

    import lacuna
    from dask import delayed
    from dask.distributed import Client, LocalCluster
    from lacuna import _lacuna
    from lacuna.fleet import _identify as parts

    coordinates, speeds, torques = ["q1", "q2"], ["dq1", "dq2"], ["tau1", "tau2"]
    data = _lacuna.Trajectories.find(f"{folder}/*.parquet", ("t", "id", coordinates, speeds, torques))
    chosen = {"kernel": "gaussian", "widths": [6.0, 1.7, 2.0, 2.0], "most_landmarks": most_landmarks}
    stream = data.choose(lacuna.Identifier(2, rates=True, **chosen)._settings(coordinates + speeds, torques))
    for count in workers:
        with LocalCluster(n_workers=count, threads_per_worker=1, dashboard_address=None) as cluster:
            with Client(cluster) as client:
                given = [delayed(one, name=name, traverse=False) for one, name in ((stream, "stream"), (data, "data"))]
                one, plus = delayed(parts._sums, pure=False), delayed(parts._plus, pure=False)
                tree = parts._fold(0, data.chunks, lambda chunk: one(*given, chunk), plus)
                load = os.getloadavg()[0]
                begin = time.perf_counter()
                total = client.compute(tree).result()
                seconds = time.perf_counter() - begin
                peaks = client.run(peak)
        digest = hashlib.sha256(pickle.dumps(total)).hexdigest()
        used, busy = ([round(own[i]) for own in peaks.values()] for i in (0, 1))
        print(f"{count} workers: {seconds:.1f} s for {data.chunks} chunks, CPU {busy} s, peak memory {used} MB")
        print(f"  sha256 of the sums {digest[:16]}, load before {load:.1f}", flush=True)


def peak() -> tuple[float, float]:
    """The most memory of this process, MB, and its CPU time, s."""
    import resource

    used = resource.getrusage(resource.RUSAGE_SELF)
    # Not ru_maxrss: that begins with what the process had that it was forked from.
    (peak,) = (line for line in Path("/proc/self/status").read_text().splitlines() if line.startswith("VmHWM:"))
    return int(peak.split()[1]) / 1024, used.ru_utime + used.ru_stime


def error(model: Any) -> float:
    x = np.random.default_rng(1).uniform(-2, 2, (300, 4))
    truth = acceleration(x.T, np.zeros((2, 300))).T
    off = np.linalg.norm(model.drift(x) - truth, axis=1) / np.linalg.norm(truth, axis=1)
    return float(np.median(off))


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    commands = parser.add_subparsers(dest="command", required=True)
    making, running, summing = (commands.add_parser(name) for name in ("make", "run", "sums"))
    making.add_argument("--trajectories", type=int, default=1_000_000)
    for command in (running, summing):
        command.add_argument("--workers", type=int, nargs="+", default=[1, 2])
        command.add_argument("--most-landmarks", type=int, default=400)
    for command in (making, running, summing):
        command.add_argument("folder", type=Path)
    said = parser.parse_args()
    if said.command == "make":
        make(said.folder, said.trajectories)
    else:
        work = run if said.command == "run" else sums
        work(said.folder, said.workers, said.most_landmarks)


if __name__ == "__main__":
    main()
