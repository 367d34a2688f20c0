"""The execution of the runs of a sweep, on the cores of this machine or on a cluster."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor, as_completed
from threading import Event
from typing import Any

from cadbem.errors import CadbemError
from cadbem.progress import notice
from cadbem.sweep.point import Point, as_task, run_point

ADDRESS = re.compile(
    r"(?:(?:tcp|tls|ws|wss|ucx)://)?(?:[\w.-]+|\[[\da-fA-F:.]+\]):\d{1,5}|inproc://[\w./]+/\d+/\d+"
)
Outcome = tuple[Point, str]


def on_this_machine(points: Sequence[Point], jobs: int) -> Iterator[Outcome]:
    """Each point and what went wrong with it, or nothing, as they end, so many at a time."""
    pool, stop = ThreadPoolExecutor(jobs), Event()  # threads that wait for processes
    try:
        tasks = {pool.submit(run_point, as_task(point), stop): point for point in points}
        for task in as_completed(tasks):
            yield tasks[task], task.result()
    finally:
        stop.set()
        pool.shutdown(wait=True, cancel_futures=True)


def on_a_cluster(points: Sequence[Point], address: str) -> Iterator[Outcome]:
    """The same by the workers of a dask scheduler, one core a point.

    Raises ``CadbemError`` without dask, or when the scheduler does not answer.
    """
    client, completed = _client(address)
    with client:
        if not client.scheduler_info()["workers"]:
            notice(f"--cluster {address}: no workers yet; start some with 'dask worker {address}'")
        tasks = {client.submit(run_point, as_task(p), pure=False): p for p in points}
        for task in completed(tasks):
            yield tasks[task], _result(task)


def _result(task: Any) -> str:
    """What a point's run returned; what is wrong with the cluster, where that has lost it."""
    try:
        return task.result()
    except Exception as error:  # dask raises all sorts of them
        return f"the cluster lost it ({type(error).__name__}: {' '.join(str(error).split())[:200]})"


def _client(address: str) -> tuple[Any, Callable[..., Any]]:
    try:
        from dask.distributed import Client
        from dask.distributed import as_completed as completed
    except ImportError as error:
        raise CadbemError("--cluster needs dask; type: pip install 'dask[distributed]'") from error
    if not ADDRESS.fullmatch(address):
        raise CadbemError(
            f"--cluster {address}: that is no address of a dask scheduler; give one such as "
            "tcp://host:8786 or tls://host:8786"
        )
    try:
        return Client(address, timeout=20), completed
    except Exception as error:  # dask raises all sorts of them
        tls = "; tls:// takes certificates from dask's configuration, distributed.comm.tls"
        raise CadbemError(
            f"--cluster {address}: no dask scheduler answers there ({error}); start one with "
            f"'dask scheduler' and workers with 'dask worker'{tls if 'tls' in address else ''}"
        ) from error
