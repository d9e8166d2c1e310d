"""The threads and the device that answer."""

from __future__ import annotations

import atexit
import os
from collections.abc import Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from typing import Literal, TypedDict

from . import _pfront

__all__ = ["using", "devices", "explain"]


def default_threads() -> int:
    """The number of threads: OMP_NUM_THREADS if it is set, as Ray and Dask do for their workers, else all processors."""
    asked = os.environ.get("OMP_NUM_THREADS", "").split(",")[0]
    if asked.isdigit() and int(asked) > 0:
        return min(int(asked), 1024)
    if hasattr(os, "sched_getaffinity"):
        return min(len(os.sched_getaffinity(0)), 1024)
    return min(os.cpu_count() or 1, 1024)


_executors: dict[tuple[int, str | None], _pfront.Executor] = {}


def _executor(threads: int | None, device: str | None) -> _pfront.Executor:
    key = (default_threads() if threads is None else threads, device)
    found = _executors.get(key)
    if found is None:
        found = _executors.setdefault(key, _pfront.Executor(*key))
    return found


# Questions of other threads end here, and threads that a signal has left behind.
atexit.register(_pfront.join)
if hasattr(os, "register_at_fork"):
    os.register_at_fork(after_in_child=_pfront.forked)
_default = _executor(None, None)
_current: ContextVar[_pfront.Executor] = ContextVar("pfront", default=_default)
current = _current.get


@contextmanager
def using(threads: int | None = None, device: Literal["cpu", "gpu", "auto"] | None = None) -> Iterator[None]:
    """Choose who answers the questions of a block; the answers stay the same to the bit.

    Parameters
    ----------
    threads : int, optional
        The number of threads, 1 to 1024; by default ``OMP_NUM_THREADS`` if that is set, else every processor. A question
        begins on the calling thread, and calls others where that pays.
    device : {None, "cpu", "gpu", "auto"}
        None and "cpu": threads. "gpu": a GPU answers, and threads what it is not asked: a float64 mesh with itself. "auto": scenes go to a GPU where that is
        predicted to pay; all else stays on threads.

    Raises
    ------
    DeviceError
        If a GPU is asked for and there is none.

    Examples
    --------
    >>> import pfront as pf
    >>> a = pf.Mesh([[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 1, 2]])
    >>> with pf.using(threads=2):
    ...     pf.collides(a, a)
    True
    """
    executor = _executor(threads, device)
    executor.open()
    token = _current.set(executor)
    try:
        yield
    finally:
        _current.reset(token)


class Device(TypedDict):
    """A GPU; one of the kind "Cpu" is a software driver."""

    name: str
    kind: str
    backend: str


def devices() -> list[Device]:
    """Return the GPU that ``device="gpu"`` would use, if there is one, as its name, kind and backend."""
    return [{"name": name, "kind": kind, "backend": backend} for name, kind, backend in _pfront.adapters()]


def explain() -> str:
    """Return who answered the last question under the current settings, and for scenes also why.

    Examples
    --------
    >>> import pfront as pf
    >>> a = pf.Mesh([[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 1, 2]])
    >>> with pf.using(threads=1):
    ...     _ = pf.collides(a, a)
    ...     print(pf.explain())
    one thread
    """
    return current().explain()
