"""Tasks on all cores."""

import threading
from itertools import count

import numpy as np
import pytest
from threadpoolctl import threadpool_info

from cadbem.operators.parallel import CORES, in_shares, run_tasks


@pytest.fixture(params=[1, 2, 5])
def cores(request):
    before = CORES.set(request.param)
    yield request.param
    CORES.reset(before)


def test_results_in_the_order_of_the_items(cores):
    assert in_shares(lambda n: n * n, range(50)) == [n * n for n in range(50)]
    assert in_shares(abs, iter([])) == []
    done = np.zeros(20)
    run_tasks(lambda k, job: done.__setitem__(k, job), list(range(20)), "numbers")
    assert (done == np.arange(20)).all()


def test_tasks_within_tasks(cores):
    """Each comes to an end, with no more threads at work than cores and those that wait."""
    working, most, lock = set(), [0], threading.Lock()

    def inner(n):
        with lock:
            working.add(threading.get_ident())
            most[0] = max(most[0], len(working))
        total = sum(range(n))
        with lock:
            working.discard(threading.get_ident())
        return total

    def outer(n):
        return sum(in_shares(inner, range(n)))

    # Σ_{m < n} m (m - 1) / 2 = n (n - 1) (n - 2) / 6
    assert in_shares(outer, range(12)) == [n * (n - 1) * (n - 2) // 6 for n in range(12)]
    assert most[0] <= cores


def test_after_an_exception_nothing_is_begun(cores):
    """Of 1000 tasks the first fails; those that wait for it are all that others begin."""
    begun, numbers = threading.Event(), count()

    def task(n):
        next(numbers)
        if n == 0:
            begun.set()
            raise IndexError("the first")
        begun.wait()
        threading.Event().wait(0.02)

    with pytest.raises(IndexError, match="the first"):
        in_shares(task, range(1000))
    assert next(numbers) <= 2 * cores


@pytest.mark.parametrize("cores", [2, 5], indirect=True)
def test_linear_algebra_has_one_thread(cores):
    def threads(_):
        return max(i["num_threads"] for i in threadpool_info() if i["user_api"] == "blas")

    before = threads(0)
    assert in_shares(threads, range(4)) == [1] * 4
    assert threads(0) == before
