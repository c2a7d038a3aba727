"""Linear algebra keeps to one thread inside, and gets back what it had, whoever else was inside."""

from concurrent.futures import ThreadPoolExecutor
from time import sleep

import pytest
import scipy.linalg  # noqa: F401, brings a library of its own
from threadpoolctl import threadpool_info

from leadthrough.blas_threads import one_blas_thread


def threads():
    """Of each library of linear algebra."""
    return [each["num_threads"] for each in threadpool_info() if each["user_api"] == "blas"]


@pytest.fixture
def before():
    found = threads()
    assert found
    yield found
    assert threads() == found


def test_there_is_one_inside_and_as_many_as_before_after(before):
    @one_blas_thread
    def outer():
        return [one_blas_thread(threads)(), threads()]

    assert outer() == 2 * [[1] * len(before)]


def test_an_error_restores_too(before):
    @one_blas_thread
    def wrong():
        raise ValueError(threads())

    with pytest.raises(ValueError, match="1"):
        wrong()
    assert threads() == before


def test_python_threads_take_turns(before):
    @one_blas_thread
    def seen(_):
        first = threads()
        sleep(0.01)
        return first + threads()

    with ThreadPoolExecutor(4) as pool:
        assert list(pool.map(seen, range(8))) == [2 * len(before) * [1]] * 8
