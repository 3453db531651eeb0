"""`lacuna.fleet.diagnose` of 200 drawn arms on a Dask cluster: one worker beside several, and one that is killed.

    python benches/fleet_diagnose.py DIR --workers 1 2
    python benches/fleet_diagnose.py DIR --workers 2 --kill

Twenty of the arms are unlike the rest: without friction, with 1.6 times the friction, with a cubic spring or 1.25 times
the inertia; typical ones differ by 8 % in friction and 3 % in the rest.
"""

from __future__ import annotations

import argparse
import os
import shutil
import signal
import threading
import time
from pathlib import Path
from typing import Any

import numpy as np

MACHINES, UNLIKE, ROWS, STEP, SUBSTEPS, NOISE = 200, 20, 500, 0.02, 20, 1e-4
INERTIA, DAMPING, GRAVITY, FRICTION, SMOOTHING = 0.12, 0.08, 0.9, 0.06, 0.02
MODEL = f"""name = "arm"
[parameters]
J = {{ value = {INERTIA}, unit = "kg m^2", tolerance = 0.05 }}
d = {{ value = {DAMPING}, unit = "N m s/rad", tolerance = 0.05 }}
mgl = {{ value = {GRAVITY}, unit = "N m", tolerance = 0.05 }}
[[input]]
name = "tau"
unit = "N m"
[[coordinate]]
name = "q"
velocity = "dq"
unit = "rad"
[mechanics]
mass = [["J"]]
force = ["tau - d*dq - mgl*sin(q)"]
"""
KINDS = ("no friction", "more friction", "spring", "inertia")


def kind(machine: int) -> str | None:
    """How a machine is unlike the others, if it is."""
    every = MACHINES // UNLIKE
    return KINDS[machine // every % len(KINDS)] if machine % every == 3 else None


def recordings(machine: int) -> list[dict[str, Any]]:
    """Three runs of a machine, the last for proof."""
    rng = np.random.default_rng((1, machine))
    inertia, damping, gravity = (v * (1 + 0.03 * rng.standard_normal()) for v in (INERTIA, DAMPING, GRAVITY))
    friction, cubic = FRICTION * (1 + 0.08 * rng.standard_normal()), 0.0
    match kind(machine):
        case "no friction":
            friction = 0.0
        case "more friction":
            friction *= 1.6
        case "spring":
            cubic = 1.5
        case "inertia":
            inertia *= 1.25
    t, h = np.arange(ROWS) * STEP, STEP / SUBSTEPS
    runs = []
    for _ in range(3):
        drawn = zip(rng.uniform(0.1, 0.3, 4), rng.uniform(0.5, 6.0, 4), rng.uniform(0, 2 * np.pi, 4))
        tau = sum(a * np.sin(w * t + p) for a, w, p in drawn)
        x, angles = np.array([0.2, 0.0]), np.empty(ROWS)

        def rates(x: Any, torque: float) -> Any:
            force = torque - damping * x[1] - friction * np.tanh(x[1] / SMOOTHING)
            return np.array([x[1], (force - gravity * np.sin(x[0]) - cubic * x[0] ** 3) / inertia])

        for k in range(ROWS):
            angles[k] = x[0]
            for _ in range(SUBSTEPS):
                a = rates(x, tau[k])
                b = rates(x + h / 2 * a, tau[k])
                c = rates(x + h / 2 * b, tau[k])
                x = x + h / 6 * (a + 2 * b + 2 * c + rates(x + h * c, tau[k]))
        runs.append({"t": t, "q": angles + NOISE * rng.standard_normal(ROWS), "tau": tau})
    return runs


def make(folder: Path) -> None:
    """The fleet in files, once."""
    if (folder / "fleet.toml").exists():
        return
    for machine in range(MACHINES):
        place = folder / "data" / f"m{machine:03}"
        place.mkdir(parents=True, exist_ok=True)
        for name, run in zip(("run1.csv", "run2.csv", "proof.csv"), recordings(machine)):
            table = np.column_stack(list(run.values()))
            np.savetxt(place / name, table, "%.9g", ",", header=",".join(run), comments="")
    (folder / "arm.toml").write_text(MODEL, encoding="utf-8")
    about = 'model = "arm.toml"\nmachines = "data/*/"\nheld_out = "proof.csv"\n'
    (folder / "fleet.toml").write_text(about, encoding="utf-8")


def run(folder: Path, workers: int, kill: bool) -> dict[str, Any]:
    """All machines on so many workers, one of which may be killed in the middle."""
    import lacuna
    from dask.distributed import Client, LocalCluster

    out = folder / f"results{workers}"
    shutil.rmtree(out, ignore_errors=True)
    with LocalCluster(n_workers=workers, threads_per_worker=1, dashboard_address=None) as cluster:
        with Client(cluster) as client:
            killed = threading.Thread(target=kill_one, args=(client, out)) if kill else None
            if killed is not None:
                killed.start()
            load, begin = os.getloadavg()[0], time.perf_counter()
            fleet = lacuna.fleet.diagnose(folder / "fleet.toml", client=client, out=out)
            seconds = time.perf_counter() - begin
            if killed is not None:
                killed.join()
    truth = {f"m{k:03}" for k in range(MACHINES) if kind(k) is not None}
    told = set(fleet.unlike)
    print(
        f"{workers} workers: {seconds:.1f} s, load before {load:.1f}; diagnosed {len(fleet.verdicts)}, failed "
        f"{len(fleet.failed)}; unlike: found {len(truth & told)} of {len(truth)}, {len(told - truth)} by mistake",
        flush=True,
    )
    return {p.parent.name: p.read_bytes() for p in sorted(out.glob("*/diagnosis.json"))}


def kill_one(client: Any, out: Path) -> None:
    """Kill a worker by its id when a third of the machines are done; tell what becomes of those that were."""
    while len(list(out.glob("*/diagnosis.json"))) < MACHINES // 3:
        time.sleep(0.1)
    before = {p: p.stat().st_mtime_ns for p in out.glob("*/diagnosis.json")}
    pid = next(iter(client.run(os.getpid).values()))
    os.kill(pid, signal.SIGKILL)
    while len(list(out.glob("*/diagnosis.json"))) < MACHINES:
        time.sleep(0.1)
    again = sum(p.stat().st_mtime_ns != at for p, at in before.items())
    print(f"  worker {pid} was killed after {len(before)} machines: {again} of these were done again")


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", type=Path)
    parser.add_argument("--workers", type=int, nargs="+", default=[1, 2])
    parser.add_argument("--kill", action="store_true")
    asked = parser.parse_args()
    make(asked.folder)
    found = [run(asked.folder, workers, asked.kill) for workers in asked.workers]
    for other in found[1:]:
        print("the same to the last bit:", other == found[0])


if __name__ == "__main__":
    main()
