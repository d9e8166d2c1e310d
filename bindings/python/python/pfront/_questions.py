"""Questions about two meshes, or one."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from . import _pfront
from ._errors import PoseError
from ._mesh import Mesh
from ._settings import current

__all__ = ["collides", "pairs", "count", "contacts", "sweep", "part", "Part", "Ragged", "Contacts"]

Pose = Any
Progress = Callable[[int, int], Any]
_LAST = [0.0, 0.0, 0.0, 1.0]


class Ragged(Sequence[Any]):
    """Arrays of different lengths: `values`, of which array i is ``values[offsets[i]:offsets[i + 1]]``.

    Attributes
    ----------
    values : ndarray
        All arrays, one after the other.
    offsets : ndarray of int64
        Where each begins, and the end.
    """

    __slots__ = ("values", "offsets")

    def __init__(self, values: npt.NDArray[Any], offsets: npt.NDArray[np.int64]) -> None:
        self.values = values
        self.offsets = offsets

    def __len__(self) -> int:
        return len(self.offsets) - 1

    def __getitem__(self, index: Any) -> Any:
        i = int(index)
        if i < 0:
            i += len(self)
        if not 0 <= i < len(self):
            raise IndexError(index)
        return self.values[self.offsets[i] : self.offsets[i + 1]]

    def __repr__(self) -> str:
        return f"Ragged({len(self)} arrays, {len(self.values)} rows)"


@dataclass(frozen=True, eq=False)
class Contacts:
    """Where pairs of triangles meet, in the frame of the first mesh; a struct of arrays, in the order of `pairs`.

    Attributes
    ----------
    pairs : ndarray of uint32, shape (n, 2)
        The triangles.
    segments : ndarray, shape (n, 2, 3)
        The end points; float64 if the question was in float64.
    normals : ndarray of float32, shape (n, 2, 3)
        The unit normals of both triangles.
    flat : ndarray of bool, shape (n,)
        Whether both lie in one plane, or one has no area: then the segment is the longest chord of what they share.
    """

    pairs: npt.NDArray[np.uint32]
    segments: npt.NDArray[Any]
    normals: npt.NDArray[np.float32]
    flat: npt.NDArray[np.bool_]

    def __len__(self) -> int:
        return len(self.pairs)

    def polylines(self) -> Ragged:
        """Chain the segments at end points that are equal to the bit.

        Returns
        -------
        Ragged
            Points of each polyline; one that is closed ends with its first point. Points where more than two segments meet
            end polylines. Segments without length are left out.

        Examples
        --------
        >>> import pfront as pf
        >>> box = pf.Mesh(*pf._box())
        >>> import numpy as np
        >>> pose = np.eye(4); pose[:3, 3] = 0.5, 0.25, 0.125
        >>> curves = pf.contacts(box, box, pose).polylines()
        >>> [bool((curve[0] == curve[-1]).all()) for curve in curves]
        [True]
        """
        segments = self.segments.reshape(-1, 2, 3) + 0.0  # -0.0 is 0.0
        segments = segments[(segments[:, 0] != segments[:, 1]).any(axis=1)]
        if len(segments) == 0:
            return Ragged(np.empty((0, 3), self.segments.dtype), np.zeros(1, np.int64))
        points, ends = np.unique(segments.reshape(-1, 3), axis=0, return_inverse=True)
        edges = np.unique(np.sort(ends.reshape(-1, 2), axis=1), axis=0)
        around: list[list[tuple[int, int]]] = [[] for _ in points]
        for edge, (u, v) in enumerate(edges.tolist()):
            around[u].append((edge, v))
            around[v].append((edge, u))
        used = np.zeros(len(edges), bool)
        chains: list[list[int]] = []

        def walk(start: int, edge: int, to: int) -> None:
            chain = [start, to]
            used[edge] = True
            while len(around[to]) == 2 and to != start:
                (one, there), (other, elsewhere) = around[to]
                edge, to = (other, elsewhere) if one == edge else (one, there)
                if used[edge]:
                    break
                used[edge] = True
                chain.append(to)
            chains.append(chain)

        # From branches and ends first, so that what is left is closed.
        for is_closed in (False, True):
            for start, edges_here in enumerate(around):
                if is_closed or len(edges_here) != 2:
                    for edge, to in edges_here:
                        if not used[edge]:
                            walk(start, edge, to)
        offsets = np.concatenate([[0], np.cumsum([len(chain) for chain in chains])]).astype(np.int64)
        return Ragged(points[np.concatenate(chains)], offsets)


def _matrix(pose: Pose) -> npt.NDArray[Any]:
    """A pose, or poses, as an aligned array of float32 or float64 in C order, whose last row has been looked at."""
    array = np.asarray(pose.as_matrix() if hasattr(pose, "as_matrix") else pose)
    if array.dtype.kind not in "fiu" or array.dtype.itemsize > 8:
        raise TypeError(f"a pose of dtype {array.dtype} is no matrix of real numbers of at most 64 bits")
    if array.ndim < 2 or array.ndim > 3 or array.shape[-2:] not in ((3, 3), (3, 4), (4, 4)):
        raise PoseError(f"a pose of shape {array.shape} is not (4, 4), (3, 4) or (3, 3), nor are these (k, ...)")
    kind = np.float32 if array.dtype.kind == "f" and array.dtype.itemsize <= 4 else np.float64
    if array.shape[-2] == 4:
        wrong = (array[..., 3, :] != _LAST).any(axis=-1)
        if wrong.any():
            error = PoseError("the last row of a pose is not 0, 0, 0, 1")
            error.row = 3
            if array.ndim == 3:
                error.pose = int(np.argmax(wrong))
            raise error
        if array.ndim == 3:
            array = array[:, :3]
    elif array.shape[-1] == 3:
        array = np.concatenate([array, np.zeros((*array.shape[:-1], 1), array.dtype)], axis=-1)
    return np.require(array, kind, ("C", "A"))


def _pose(pose: Pose) -> npt.NDArray[Any] | None:
    # What most callers have, without a look at anything else.
    if pose is None or (
        type(pose) is np.ndarray
        and pose.shape == (4, 4)
        and pose.dtype.char in "fd"
        and pose.dtype.isnative
        and pose.flags.carray
        and pose[3].tolist() == _LAST
    ):
        return pose
    return _matrix(pose)


def _two(a: Any, b: Any) -> tuple[_pfront.Model, _pfront.Model | None]:
    first = a._model if type(a) is Mesh else Mesh(a)._model
    if b is None:
        return first, None
    return first, b._model if type(b) is Mesh else Mesh(b)._model


def _about(
    a: Any, b: Any, pose: Pose
) -> tuple[_pfront.Model, _pfront.Model | None, npt.NDArray[Any] | None, bool]:
    """Both models, the pose, and whether there are many."""
    first, second = _two(a, b)
    array = _pose(pose)
    if second is None and array is not None:
        raise TypeError("a mesh with itself takes no pose")
    return first, second, array, array is not None and array.ndim == 3


def collides(a: Any, b: Any = None, pose: Pose = None, *, progress: Progress | None = None) -> Any:
    """Whether the surfaces of two meshes meet, or that of one meets itself. Touching counts; there is no tolerance.

    Parameters
    ----------
    a, b : Mesh
        The meshes, or anything that `Mesh` takes, of which a BVH is then built. Without `b`: `a` with itself.
    pose : array_like, optional
        ``a_from_b``, which takes the coordinates of `b` to those of `a`: 4×4, 3×4 or 3×3, for column vectors; or (k, 4, 4).
        One of float32 is applied in float32; one of float64 makes the question float64, as NumPy would.
    progress : callable, optional
        Called as ``progress(done, total)`` while many poses are answered.

    Returns
    -------
    bool or ndarray of bool
        One answer for each pose.

    Examples
    --------
    >>> import numpy as np, pfront as pf
    >>> box = pf.Mesh(*pf._box())
    >>> pose = np.eye(4, dtype=np.float32)
    >>> pose[0, 3] = 1  # face to face
    >>> pf.collides(box, box, pose)
    True
    >>> pose[0, 3] = np.nextafter(np.float32(1), np.float32(2))
    >>> pf.collides(box, box, pose)
    False
    """
    first, second, array, many = _about(a, b, pose)
    if many:
        assert second is not None and array is not None
        return _pfront.batch_any(first, second, array, current(), progress)
    return _pfront.any(first, second, array, current())


def count(a: Any, b: Any = None, pose: Pose = None, *, progress: Progress | None = None) -> Any:
    """Count the pairs of triangles that meet.

    Parameters
    ----------
    a, b, pose, progress
        As for `collides`.

    Returns
    -------
    int or ndarray of int64
        One answer for each pose.

    Examples
    --------
    >>> import numpy as np, pfront as pf
    >>> box = pf.Mesh(*pf._box())
    >>> poses = np.tile(np.eye(4), (3, 1, 1))
    >>> poses[:, 0, 3] = 0.5, 1, 1.5
    >>> pf.count(box, box, poses) > 0
    array([ True,  True, False])
    """
    first, second, array, many = _about(a, b, pose)
    if many:
        assert second is not None and array is not None
        return _pfront.batch_count(first, second, array, current(), progress)
    return _pfront.count(first, second, array, current(), None)


def pairs(a: Any, b: Any = None, pose: Pose = None, *, progress: Progress | None = None) -> Any:
    """List the pairs of triangles that meet, sorted.

    Within one mesh each pair is listed once, the smaller face first, and what two faces share by vertex index is no contact.

    Parameters
    ----------
    a, b, pose, progress
        As for `collides`.

    Returns
    -------
    ndarray of uint32, shape (n, 2), or Ragged
        A face of `a` and one of `b`; for many poses the list of each.

    Examples
    --------
    >>> import pfront as pf
    >>> floor = pf.Mesh([[0, 0, 0], [4, 0, 0], [0, 4, 0]], [[0, 1, 2]])
    >>> blade = pf.Mesh([[0, 0, -1], [0, 1, -1], [0, 0, 1]], [[0, 1, 2]])
    >>> pf.pairs(floor, blade)
    array([[0, 0]], dtype=uint32)
    """
    first, second, array, many = _about(a, b, pose)
    if many:
        assert second is not None and array is not None
        return Ragged(*_pfront.batch_all(first, second, array, current(), progress))
    return _pfront.all(first, second, array, current(), None)


def contacts(a: Any, b: Any = None, pose: Pose = None) -> Contacts:
    """Find where two meshes meet: a segment for each pair of triangles, and their normals.

    Parameters
    ----------
    a, b, pose
        As for `collides`; one pose.

    Returns
    -------
    Contacts
        A struct of arrays.

    Examples
    --------
    >>> import pfront as pf
    >>> floor = pf.Mesh([[0, 0, 0], [4, 0, 0], [0, 4, 0]], [[0, 1, 2]])
    >>> blade = pf.Mesh([[1, 1, -1], [1, 2, -1], [1, 1, 1]], [[0, 1, 2]])
    >>> pf.contacts(floor, blade).segments.tolist()
    [[[1.0, 1.5, 0.0], [1.0, 1.0, 0.0]]]
    """
    first, second, array, many = _about(a, b, pose)
    if many:
        raise PoseError("contacts take one pose: ask for pairs first, and for contacts of the poses that matter")
    return Contacts(*_pfront.contacts(first, second, array, current()))


@dataclass(frozen=True)
class Part:
    """Part `i` of `n` of questions; see `part`."""

    i: int
    n: int

    def pairs(self, a: Any, b: Any = None, pose: Pose = None) -> npt.NDArray[np.uint32]:
        """List the pairs of this part, sorted; the parts together list each pair of `pfront.pairs` once."""
        first, second, array, _ = _about(a, b, pose)
        return _pfront.all(first, second, array, current(), (self.i, self.n))

    def count(self, a: Any, b: Any = None, pose: Pose = None) -> int:
        """Count the pairs of this part."""
        first, second, array, _ = _about(a, b, pose)
        return _pfront.count(first, second, array, current(), (self.i, self.n))


def part(i: int, n: int) -> Part:
    """Select part `i` of `n` of a question, to divide one pair of large meshes among processes.

    A part is a pure function of the question: parts may be asked anywhere, in any order, and again after a failure.

    Parameters
    ----------
    i, n : int
        0 ≤ i < n ≤ 65536.

    Examples
    --------
    >>> import numpy as np, pfront as pf
    >>> box = pf.Mesh(*pf._box())
    >>> sum(pf.part(i, 3).count(box, box) for i in range(3)) == pf.count(box, box)
    True
    """
    if not (0 <= i < n <= 65536):
        raise ValueError(f"part {i} of {n} is not 0 ≤ i < n ≤ 65536")
    return Part(int(i), int(n))


_WHAT: dict[str, Callable[..., Any]] = {"collides": collides, "count": count, "pairs": pairs}


def _task(what: str, a: Mesh, b: Mesh, poses: npt.NDArray[Any]) -> Any:
    """One chunk of a sweep, as another process answers it."""
    return _WHAT[what](a, b, poses)


def sweep(
    a: Any,
    b: Any,
    poses: Pose,
    what: str = "collides",
    *,
    progress: Progress | None = None,
    executor: Any = None,
    chunk: int = 10_000,
    window: int = 64,
) -> Iterator[tuple[int, Any]]:
    """Ask about many poses, and yield each index with its answer, in order, while later ones are on their way.

    Parameters
    ----------
    a, b : Mesh
        The meshes.
    poses : array_like, shape (k, 4, 4)
        As for `collides`.
    what : {"collides", "count", "pairs"}
        The question.
    progress : callable, optional
        Called as ``progress(done, total)`` after each chunk; ``lambda done, total: bar.update(done - bar.n)`` for tqdm.
    executor : optional
        Anything with ``submit(fn, *args)`` that returns futures: a process pool, a Dask client, an MPI pool. By default the
        threads of this process.
    chunk : int
        Poses in one task. From some 10,000 on other processes pay.
    window : int
        The most tasks in flight.

    Examples
    --------
    >>> import numpy as np, pfront as pf
    >>> box = pf.Mesh(*pf._box())
    >>> poses = np.tile(np.eye(4), (3, 1, 1))
    >>> poses[:, 0, 3] = 0.5, 1, 1.5
    >>> for i, hit in pf.sweep(box, box, poses):
    ...     print(i, hit)
    0 True
    1 True
    2 False
    """
    if what not in _WHAT:
        raise ValueError(f"what={what!r} is none of {', '.join(_WHAT)}")
    if chunk < 1 or window < 1:
        raise ValueError("chunk and window are at least 1")
    first = a if isinstance(a, Mesh) else Mesh(a)
    second = b if isinstance(b, Mesh) else Mesh(b)
    array = _matrix(poses)
    if array.ndim != 3:
        raise PoseError(f"poses of shape {array.shape} are not (k, 4, 4)")
    return _swept(first, second, array, what, progress, executor, chunk, window)


def _swept(
    a: Mesh,
    b: Mesh,
    poses: npt.NDArray[Any],
    what: str,
    progress: Progress | None,
    executor: Any,
    chunk: int,
    window: int,
) -> Iterator[tuple[int, Any]]:
    starts = range(0, len(poses), chunk)
    flying: dict[int, Any] = {}

    def launch(start: int) -> None:
        flying[start] = executor.submit(_task, what, a, b, poses[start : start + chunk])

    try:
        ahead = iter(starts)
        if executor is not None:
            for _, start in zip(range(window), ahead):
                launch(start)
        for start in starts:
            if executor is None:
                answers = _task(what, a, b, poses[start : start + chunk])
            else:
                answers = flying.pop(start).result()
                following = next(ahead, None)
                if following is not None:
                    launch(following)
            if progress is not None:
                progress(min(start + chunk, len(poses)), len(poses))
            if isinstance(answers, np.ndarray):
                answers = answers.tolist()
            for i, answer in enumerate(answers, start):
                yield i, answer
    finally:
        for future in flying.values():
            future.cancel()
