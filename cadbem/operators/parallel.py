"""Tasks on all cores."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterable, Sequence
from concurrent.futures import ThreadPoolExecutor
from contextvars import ContextVar
from functools import lru_cache
from typing import Any, TypeVar

from threadpoolctl import ThreadpoolController, threadpool_limits

from cadbem.progress import progress

Item = TypeVar("Item")
Result = TypeVar("Result")


# cores that this process may use, where the system tells
ALLOWED = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1
# how many of them the tasks of the running thread may use
CORES = ContextVar("CORES", default=ALLOWED)


def in_shares(task: Callable[[Item], Result], items: Iterable[Item]) -> list[Result]:
    """Results of a task for each item, on all cores, with linear algebra on one thread each.

    A task may come here itself: then it has its share of the cores, and if that is one, no other
    threads.  After an exception no item is begun any more.
    """
    todo = list(items)
    workers = min(CORES.get(), len(todo))
    if workers < 2:
        return [task(item) for item in todo]
    results: list[Any] = [None] * len(todo)
    numbers = iter(range(len(todo)))  # all workers take from it

    def work() -> None:
        try:
            for number in numbers:
                results[number] = task(todo[number])
        finally:
            _exhaust(numbers)

    share = -(-CORES.get() // workers)
    with (
        _libraries().limit(limits=1),
        ThreadPoolExecutor(workers, initializer=CORES.set, initargs=(share,)) as pool,
    ):
        futures = [pool.submit(work) for _ in range(workers)]
        try:
            for future in futures:
                future.result()
        finally:
            _exhaust(numbers)
    return results


def run_tasks(work: Callable[[int, Item], object], jobs: Sequence[Item], label: str) -> None:
    """Do ``work(number, job)`` on all cores, with a bar; what jobs write does not overlap."""
    with progress(total=len(jobs), label=label) as bar:

        def task(pair: tuple[int, Item]) -> None:
            work(*pair)
            with bar.get_lock():
                bar.update()

        in_shares(task, enumerate(jobs))


def _exhaust(numbers: Iterable[int]) -> None:
    for _ in numbers:
        pass


def linear_algebra_threads() -> int:
    """How many threads linear algebra takes outside of tasks."""
    return max((library["num_threads"] for library in _libraries().info()), default=1)


def use_cores(cores: int, threads: int) -> None:
    """Give tasks so many ``cores``, and linear algebra so many ``threads`` outside of them, that of
    libraries which are loaded later, too."""
    for library in ("OPENBLAS", "OMP", "MKL"):
        os.environ[f"{library}_NUM_THREADS"] = str(threads)
    threadpool_limits(threads)
    CORES.set(cores)


@lru_cache(maxsize=1)
def _libraries() -> ThreadpoolController:
    """The controller of the threads of linear algebra; the search for the libraries is slow."""
    return ThreadpoolController()
