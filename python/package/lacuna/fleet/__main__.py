"""Fleets from a shell: ``python -m lacuna.fleet fleet.toml --scheduler ADDRESS``."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

from .. import LacunaError
from . import diagnose


def _arguments(words: list[str]) -> argparse.Namespace:
    about = "Many machines with one model, on Dask."
    parser = argparse.ArgumentParser(prog="python -m lacuna.fleet", description=about)
    parser.add_argument("fleet", help="the fleet's file: one model, and the machines with their recordings")
    parser.add_argument("--scheduler", metavar="ADDRESS", help="a Dask scheduler; without, workers on this machine")
    parser.add_argument("--workers", type=int, metavar="N", help="workers on this machine, where no scheduler is named")
    parser.add_argument("--out", default="fleet", metavar="DIR", help="folder of the results (default: fleet)")
    return parser.parse_args(words)


@contextmanager
def _client(said: argparse.Namespace) -> Iterator[Any]:
    from dask.distributed import Client, LocalCluster

    if said.scheduler is not None:
        with Client(said.scheduler) as client:
            yield client
    else:
        with LocalCluster(n_workers=said.workers, threads_per_worker=1, dashboard_address=None) as cluster:
            with Client(cluster) as client:
                yield client


def _main(words: list[str]) -> int:
    said = _arguments(words)
    try:
        with _client(said) as client:
            fleet = diagnose(said.fleet, client=client, out=said.out)
    except (LacunaError, ImportError, OSError) as error:
        print(f"lacuna.fleet: {error}", file=sys.stderr)
        return 2
    print(f"{fleet!r}Written: {fleet.folder / 'fleet.html'}")
    return 2 if fleet.failed else 0


if __name__ == "__main__":
    raise SystemExit(_main(sys.argv[1:]))
