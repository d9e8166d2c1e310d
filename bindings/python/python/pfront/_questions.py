"""Questions about two meshes, or one."""

from __future__ import annotations

import warnings
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, fields
from typing import Any, Literal, Protocol, TypeVar, Union, overload

import numpy as np
import numpy.typing as npt

from . import _pfront
from ._arrays import Rows, integer, point, rows
from ._arrays import points as _points
from ._errors import PoseError
from ._mesh import Mesh, MeshLike
from ._poses import HasMatrix, OnePose, Pose, Poses, SomePoses, matrix
from ._settings import current

__all__ = [
    "first", "collides", "pairs", "count", "contacts", "distance", "relation", "overlap_volume", "patches", "inside", "segment",
    "segment_first", "impacts", "first_impact", "any_impact", "count_impacts", "Impact", "Impacts", "ContactPatch", "sweep", "part", "Part", "Ragged", "Contacts", "Gap", "Gaps",
]  # fmt: skip

Progress = Callable[[int, int], Any]
# Of two, since stubtest takes an alias of one for another thing than it is.
Relation = Union[Literal["apart", "near", "touching", "crossing"], Literal["a_in_b", "b_in_a", "equal"]]
_Relations = npt.NDArray[np.object_]
_Floats = npt.NDArray[np.float64]
_Bools = npt.NDArray[np.bool_]
_Counts = npt.NDArray[np.int64]
_Pairs = npt.NDArray[np.uint32]
_Faces = npt.NDArray[np.uint32]
_Values = TypeVar("_Values", bound="npt.NDArray[Any] | Contacts")
_Found = TypeVar("_Found", bound="Contacts")
# By their codes; what is undetermined has the last.
_RELATIONS = np.array([*_pfront.relations(), None], object)


class Submits(Protocol):
    """Whatever runs a function elsewhere and returns its future: a process pool, a Dask client, an MPI pool."""

    def submit(self, fn: Callable[..., Any], /, *args: Any) -> Any: ...


class Ragged(Sequence[_Values]):
    """Lists of different lengths: `values`, of which list i is ``values[offsets[i]:offsets[i + 1]]``.

    Attributes
    ----------
    values : ndarray or Contacts
        All lists, one after the other.
    offsets : ndarray of int64
        Where each begins, and the end.

    Examples
    --------
    >>> import numpy as np, pfront as pf
    >>> floor = pf.Mesh([[0, 0, 0], [4, 0, 0], [0, 4, 0]], [[0, 1, 2]])
    >>> blade = pf.Mesh([[1, 1, -1], [1, 2, -1], [1, 1, 1]], [[0, 1, 2]])
    >>> poses = np.tile(np.eye(4), (3, 1, 1))
    >>> poses[1, 2, 3] = 5  # the second is above the floor
    >>> found = pf.pairs(floor, blade, poses)
    >>> [len(pairs) for pairs in found]
    [1, 0, 1]
    >>> np.repeat(np.arange(3), np.diff(found.offsets))  # the pose of each row of found.values
    array([0, 2])
    """

    __slots__ = ("values", "offsets")

    def __init__(self, values: _Values, offsets: _Counts) -> None:
        self.values = values
        self.offsets = offsets

    def __len__(self) -> int:
        return len(self.offsets) - 1

    @overload
    def __getitem__(self, index: int) -> _Values: ...
    @overload
    def __getitem__(self, index: slice) -> Ragged[_Values]: ...
    def __getitem__(self, index: Any) -> Any:
        if isinstance(index, slice):
            first, end, step = index.indices(len(self))
            if step != 1:
                raise IndexError("a slice of lists has a step of 1")
            offsets = self.offsets[first : max(first, end) + 1]
            return Ragged(self.values[offsets[0] : offsets[-1]], offsets - offsets[0])
        i = integer(index, "the index of a list")
        if i < 0:
            i += len(self)
        if not 0 <= i < len(self):
            raise IndexError(f"there is no list {index} of {len(self)}")
        return self.values[self.offsets[i] : self.offsets[i + 1]]

    def __repr__(self) -> str:
        return f"Ragged({len(self)} lists, {len(self.values)} rows)"


@dataclass(frozen=True, eq=False, repr=False)
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

    pairs: _Pairs
    segments: npt.NDArray[Any]
    normals: npt.NDArray[np.float32]
    flat: _Bools

    def __len__(self) -> int:
        return len(self.pairs)

    def __repr__(self) -> str:
        return f"{type(self).__name__}({len(self)} pairs, {self.segments.dtype})"

    def __getitem__(self: _Found, index: Rows) -> _Found:
        """The contacts that a slice, a mask or an array of indices selects, as ``found[~found.flat]``."""
        index = rows(index, "contacts")
        return type(self)(*(getattr(self, field.name)[index] for field in fields(self)))

    def to_dict(self) -> dict[str, npt.NDArray[Any]]:
        """Columns by their names, as ``pandas.DataFrame(found.to_dict())`` takes them: faces, both end points, and `flat`.

        Examples
        --------
        >>> import pfront as pf
        >>> box = pf.Mesh(*pf._box())
        >>> list(pf.contacts(box, box).to_dict())
        ['face_a', 'face_b', 'x0', 'y0', 'z0', 'x1', 'y1', 'z1', 'flat']
        """
        points = {f"{axis}{end}": self.segments[:, end, k] for end in (0, 1) for k, axis in enumerate("xyz")}
        return {"face_a": self.pairs[:, 0], "face_b": self.pairs[:, 1], **points, "flat": self.flat}

    def polylines(self) -> Ragged[npt.NDArray[Any]]:
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
        # Numbers are compared by their bits, since some environments take subnormal ones for zeros; -0.0 is 0.0.
        kind = np.uint32 if self.segments.dtype == np.float32 else np.uint64
        bits = np.array(self.segments).reshape(-1, 2, 3).view(kind)
        bits[bits == kind(1) << kind(np.dtype(kind).itemsize * 8 - 1)] = 0
        bits = bits[(bits[:, 0] != bits[:, 1]).any(axis=1)]
        if len(bits) == 0:
            return Ragged(np.empty((0, 3), self.segments.dtype), np.zeros(1, np.int64))
        found, ends = np.unique(bits.reshape(-1, 3), axis=0, return_inverse=True)
        points = found.view(self.segments.dtype)
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


@dataclass(frozen=True, eq=False)
class Gap:
    """The smallest distance of two meshes, and where it is.

    Attributes
    ----------
    interval : (float, float)
        The least and the greatest that the distance can be: both 0 if triangles intersect. If they do not, the greatest is more than 0, and
        the least may be 0 where they are nearer than float32 can tell: test ``interval[1] == 0`` for contact. They differ by some 2^-23 of the distance, and by 2^-44 of the extent of both meshes.
    pair : (int, int)
        The nearest faces, the first of those that are equally near; if faces intersect, two that do.
    points : ndarray of float64, shape (2, 3)
        The nearest points of both, rounded; if faces intersect, a point of both.
    distance : float
        The upper end of the interval.
    """

    interval: tuple[float, float]
    pair: tuple[int, int]
    points: npt.NDArray[np.float64]

    @property
    def distance(self) -> float:
        return self.interval[1]


@dataclass(frozen=True, eq=False, repr=False)
class ContactPatch:
    """A connected part of what two surfaces have in common: a point, curves, areas, or what is joined of these.

    Attributes
    ----------
    dimension : int
        0 for a point, 1 for curves, 2 if there are areas.
    closed : bool
        Whether it surely has no end: a curve that comes back to where it began, or areas without an outline.
    length, area : (float, float)
        Intervals that hold the length of its curves and of the outlines of its areas, and its area.
    pairs : ndarray of uint32, shape (n, 2)
        The faces that meet there, sorted.
    points : ndarray of float64, shape (m, 3)
        The corners of what faces have in common there, each once, rounded.
    segments : ndarray of uint32, shape (k, 2)
        Curves and outlines, as segments between two of the points.
    """

    dimension: int
    closed: bool
    length: tuple[float, float]
    area: tuple[float, float]
    pairs: npt.NDArray[np.uint32]
    points: npt.NDArray[np.float64]
    segments: npt.NDArray[np.uint32]

    def __repr__(self) -> str:
        return f"ContactPatch(dimension={self.dimension}, {len(self.pairs)} pairs)"


@dataclass(frozen=True, eq=False, repr=False)
class Gaps(Sequence["Gap | None"]):
    """The smallest distance in each of many poses: a struct of arrays, and a sequence of `Gap`, or None where there is none.

    Attributes
    ----------
    intervals : ndarray of float64, shape (n, 2)
        As ``Gap.interval``; inf where there is no distance.
    pairs : ndarray of int64, shape (n, 2)
        The nearest faces; -1 where there is no distance.
    points : ndarray of float64, shape (n, 2, 3)
        The nearest points of both; NaN where there is no distance.
    distances : ndarray of float64, shape (n,)
        The upper ends of the intervals.
    """

    intervals: npt.NDArray[np.float64]
    pairs: npt.NDArray[np.int64]
    points: npt.NDArray[np.float64]

    @property
    def distances(self) -> npt.NDArray[np.float64]:
        return self.intervals[:, 1]

    def __len__(self) -> int:
        return len(self.intervals)

    def __repr__(self) -> str:
        return f"Gaps({len(self)} poses)"

    @overload
    def __getitem__(self, index: int) -> Gap | None: ...
    @overload
    def __getitem__(self, index: Rows) -> Gaps: ...
    def __getitem__(self, index: Any) -> Any:
        """The gap of one pose, or those that a slice, a mask or an array of indices selects, as ``gaps[gaps.distances < 1]``."""
        interval, pair, points = self.intervals[index], self.pairs[index], self.points[index]
        if not isinstance(index, (int, np.integer)):
            return Gaps(interval, pair, points)
        return Gap(tuple(interval.tolist()), tuple(pair.tolist()), points) if pair[0] >= 0 else None


def _one(mesh: MeshLike) -> _pfront.Model:
    return mesh._model if type(mesh) is Mesh else Mesh(mesh)._model


def _both(a: MeshLike, b: MeshLike) -> tuple[_pfront.Model, _pfront.Model]:
    return a._model if type(a) is Mesh else Mesh(a)._model, b._model if type(b) is Mesh else Mesh(b)._model


def _two(a: MeshLike, b: MeshLike | None) -> tuple[_pfront.Model, _pfront.Model | None]:
    first = a._model if type(a) is Mesh else Mesh(a)._model
    if b is None:
        return first, None
    return first, b._model if type(b) is Mesh else Mesh(b)._model


@overload
def collides(a: MeshLike, b: MeshLike, pose: SomePoses, *, progress: Progress | None = None, within: float = 0.0) -> Any: ...
@overload
def collides(
    a: MeshLike, b: MeshLike | None = None, pose: OnePose = None, *, progress: Progress | None = None, within: float = 0.0
) -> bool: ...
@overload
def collides(a: MeshLike, b: MeshLike, pose: Poses, *, progress: Progress | None = None, within: float = 0.0) -> _Bools: ...
def collides(a: MeshLike, b: MeshLike | None = None, pose: Pose = None, *, progress: Progress | None = None, within: float = 0.0) -> Any:
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
    within : float
        Ask for pairs of triangles at most so far apart in place of those that intersect, exactly; rounded up to float32, so that no
        pair is missed. What two faces of one mesh share by index is decided as without. A GPU answers about two meshes only.

    Raises
    ------
    ValueError
        If `within` is NaN, infinite or negative.

    Returns
    -------
    bool or ndarray of bool
        One answer for each pose.

    Notes
    -----
    If both meshes have a pose in the world, ask about ``np.linalg.inv(world_from_a) @ world_from_b``; or put them into a
    `Scene`, which poses both into the world.

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
    >>> pf.collides(box, box, pose, within=1e-6)
    True
    """
    return _pfront.any(*_two(a, b), pose, current(), progress, within)


def first(a: MeshLike, b: MeshLike | None = None, pose: OnePose | HasMatrix = None, *, within: float = 0.0) -> tuple[int, int] | None:
    """Find one pair of triangles that meet, or None: the pair that is found first, which may differ between executors.

    Parameters
    ----------
    a, b, pose, within
        As for `collides`; one pose.

    Returns
    -------
    (int, int) or None
        A face of `a` and one of `b`.

    Examples
    --------
    >>> import pfront as pf
    >>> floor = pf.Mesh([[0, 0, 0], [4, 0, 0], [0, 4, 0]], [[0, 1, 2]])
    >>> blade = pf.Mesh([[1, 1, -1], [1, 2, -1], [1, 1, 1]], [[0, 1, 2]])
    >>> pf.first(floor, blade), pf.first(floor)
    ((0, 0), None)
    """
    return _pfront.first(*_two(a, b), pose, current(), within)


@overload
def count(a: MeshLike, b: MeshLike, pose: SomePoses, *, progress: Progress | None = None, within: float = 0.0) -> Any: ...
@overload
def count(
    a: MeshLike, b: MeshLike | None = None, pose: OnePose = None, *, progress: Progress | None = None, within: float = 0.0
) -> int: ...
@overload
def count(a: MeshLike, b: MeshLike, pose: Poses, *, progress: Progress | None = None, within: float = 0.0) -> _Counts: ...
def count(a: MeshLike, b: MeshLike | None = None, pose: Pose = None, *, progress: Progress | None = None, within: float = 0.0) -> Any:
    """Count the pairs of triangles that meet.

    Parameters
    ----------
    a, b, pose, progress, within
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
    >>> pf.count(box, box, poses, within=0.5) > 0
    array([ True,  True,  True])
    """
    return _pfront.count(*_two(a, b), pose, current(), progress, None, within)


@overload
def pairs(a: MeshLike, b: MeshLike, pose: SomePoses, *, progress: Progress | None = None, within: float = 0.0) -> Any: ...
@overload
def pairs(
    a: MeshLike, b: MeshLike | None = None, pose: OnePose = None, *, progress: Progress | None = None, within: float = 0.0
) -> _Pairs: ...
@overload
def pairs(a: MeshLike, b: MeshLike, pose: Poses, *, progress: Progress | None = None, within: float = 0.0) -> Ragged[_Pairs]: ...
def pairs(a: MeshLike, b: MeshLike | None = None, pose: Pose = None, *, progress: Progress | None = None, within: float = 0.0) -> Any:
    """List the pairs of triangles that meet, sorted.

    Within one mesh each pair is listed once, the smaller face first, and what two faces share by vertex index is no contact.

    Parameters
    ----------
    a, b, pose, progress, within
        As for `collides`.

    Warns
    -----
    UserWarning
        If most pairs within one mesh are of faces that share a position, but no vertex.

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
    >>> import numpy as np
    >>> pose = np.eye(4)
    >>> pose[2, 3] = 1.25  # a quarter above the floor
    >>> len(pf.pairs(floor, blade, pose)), len(pf.pairs(floor, blade, pose, within=0.25))
    (0, 1)
    """
    two = _two(a, b)
    found, offsets = _pfront.all(*two, pose, current(), progress, None, within)
    if b is None and len(found):
        _warn_if_split(a if isinstance(a, Mesh) else Mesh(two[0]), found)
    return found if offsets is None else Ragged(found, offsets)


def _warn_if_split(mesh: Mesh, found: _Pairs) -> None:
    """Say so if most pairs, of which some thousands are looked at, are of faces that share a position, but no vertex."""
    corners = mesh.faces[found[:: len(found) // 10_000 + 1]]
    places = mesh.vertices[corners]
    shares_vertex = (corners[:, 0, :, None] == corners[:, 1, None, :]).any((1, 2))
    shares_place = (places[:, 0, :, None] == places[:, 1, None, :]).all(-1).any((1, 2))
    alone = int((shares_place & ~shares_vertex).sum())
    if 2 * alone > len(corners):
        warnings.warn(
            f"in {alone} of {len(corners)} pairs the faces share a position, but no vertex: vertices at the same place are not "
            "joined, as many formats split them",
            stacklevel=3,
        )


@overload
def contacts(a: MeshLike, b: MeshLike, pose: SomePoses, *, progress: Progress | None = None) -> Any: ...
@overload
def contacts(a: MeshLike, b: MeshLike | None = None, pose: OnePose = None, *, progress: Progress | None = None) -> Contacts: ...
@overload
def contacts(a: MeshLike, b: MeshLike, pose: Poses, *, progress: Progress | None = None) -> Ragged[Contacts]: ...
def contacts(a: MeshLike, b: MeshLike | None = None, pose: Pose = None, *, progress: Progress | None = None) -> Any:
    """Find where two meshes meet: a segment for each pair of triangles, and their normals.

    Parameters
    ----------
    a, b, pose, progress
        As for `collides`.

    Returns
    -------
    Contacts or Ragged
        A struct of arrays; for many poses the contacts of each.

    Examples
    --------
    >>> import pfront as pf
    >>> floor = pf.Mesh([[0, 0, 0], [4, 0, 0], [0, 4, 0]], [[0, 1, 2]])
    >>> blade = pf.Mesh([[1, 1, -1], [1, 2, -1], [1, 1, 1]], [[0, 1, 2]])
    >>> pf.contacts(floor, blade).segments.tolist()
    [[[1.0, 1.5, 0.0], [1.0, 1.0, 0.0]]]
    """
    arrays, offsets = _pfront.contacts(*_two(a, b), pose, current(), progress)
    found = Contacts(*arrays)
    return found if offsets is None else Ragged(found, offsets)


@overload
def distance(
    a: MeshLike, b: MeshLike, pose: SomePoses, *, limit: float | None = None, progress: Progress | None = None
) -> Any: ...
@overload
def distance(
    a: MeshLike, b: MeshLike, pose: OnePose = None, *, limit: float | None = None, progress: Progress | None = None
) -> Gap | None: ...
@overload
def distance(a: MeshLike, b: MeshLike, pose: Poses, *, limit: float | None = None, progress: Progress | None = None) -> Gaps: ...
def distance(a: MeshLike, b: MeshLike, pose: Pose = None, *, limit: float | None = None, progress: Progress | None = None) -> Any:
    """Find the smallest distance of two meshes, in the frame of the first: an interval that holds it, the pair and the points.

    It is that of surfaces: 0 where they intersect, and more where one mesh is inside another.

    Parameters
    ----------
    a, b, pose, progress
        As for `collides`.
    limit : float, optional
        Ask only whether it is at most so much, which takes less time; rounded up to float32, as `within` of `collides`. CPUs answer.

    Returns
    -------
    Gap, None or Gaps
        None if a mesh has no faces, or if all are farther apart than `limit`. For many poses a struct of arrays.

    Raises
    ------
    ValueError
        If `limit` is NaN, infinite or negative.

    Examples
    --------
    >>> import numpy as np, pfront as pf
    >>> box = pf.Mesh(*pf._box())
    >>> pose = np.eye(4)
    >>> pose[0, 3] = 1.25
    >>> gap = pf.distance(box, box, pose)
    >>> low, high = gap.interval
    >>> low <= 0.25 <= high, round(gap.distance, 6), (gap.points[1] - gap.points[0]).tolist()
    (True, 0.25, [0.25, 0.0, 0.0])
    >>> print(pf.distance(box, box, pose, limit=0.2))
    None
    >>> poses = np.tile(np.eye(4), (3, 1, 1))
    >>> poses[:, 0, 3] = 0.5, 1.5, 3
    >>> pf.distance(box, box, poses, limit=1).distances.round(6)
    array([0. , 0.5, inf])
    """
    arrays, is_one = _pfront.distance(*_both(a, b), pose, current(), progress, limit)
    gaps = Gaps(*arrays)
    return gaps[0] if is_one else gaps


@overload
def relation(a: MeshLike, b: MeshLike, pose: SomePoses, *, within: float = 0.0, progress: Progress | None = None) -> Any: ...
@overload
def relation(
    a: MeshLike, b: MeshLike, pose: OnePose = None, *, within: float = 0.0, progress: Progress | None = None
) -> Relation | None: ...
@overload
def relation(a: MeshLike, b: MeshLike, pose: Poses, *, within: float = 0.0, progress: Progress | None = None) -> _Relations: ...
def relation(a: MeshLike, b: MeshLike, pose: Pose = None, *, within: float = 0.0, progress: Progress | None = None) -> Any:
    """Tell what one solid is to another, exactly, in one word.

    ========== =====================================================================
    apart      no point in common
    near       apart, and at most `within` away
    touching   their surfaces meet, their interiors do not
    crossing   their interiors meet, and each is partly outside of the other
    a_in_b     all of `a` is inside `b`, and not all of `b` in `a`; surfaces may meet
    b_in_a     the other way round
    equal      the same solid, whatever its faces
    ========== =====================================================================

    Parameters
    ----------
    a, b : Mesh
        Closed meshes, or anything that `Mesh` takes. Vertices that are equal are one; several bodies in one mesh are one solid. The
        inside is where a mesh winds around, or, if its faces are not oriented alike, where rays cross it an odd number of times.
    pose, progress
        As for `collides`.
    within : float
        Solids that are apart, and at most so far, are near, exactly; rounded up to float32, as for `collides`.

    Returns
    -------
    str, None or ndarray of str and None
        None if it is undetermined, since it hangs on faces that meet their own mesh. For many poses an array of objects.

    Raises
    ------
    NotSolid
        If a mesh is none: an edge is open, there is no volume, or all of it meets itself. It names the edge or the faces.
    ValueError
        If `within` is NaN, infinite or negative.

    Notes
    -----
    Rounding makes what should be flush cross by a trifle: the word is true of the rounded coordinates. Ask by how much, by
    `overlap_volume`, before calling that a clash. What has to be known of a mesh once is kept with it, 36 bytes a face.

    Examples
    --------
    >>> import numpy as np, pfront as pf
    >>> box = pf.Mesh(*pf._box())
    >>> pf.relation(box, box), pf.relation(box, box.with_vertices(box.vertices / 2))
    ('equal', 'b_in_a')
    >>> poses = np.tile(np.eye(4), (4, 1, 1))
    >>> poses[:, 0, 3] = 0.5, 1, 1.25, 2
    >>> pf.relation(box, box, poses, within=0.25).tolist()
    ['crossing', 'touching', 'near', 'apart']
    >>> try:
    ...     pf.relation(box, (box.vertices, box.faces[1:]))
    ... except pf.NotSolid as error:
    ...     print(error.mesh, error.face, error.edge)
    b 0 0
    """
    codes, is_one = _pfront.relation(*_both(a, b), pose, current(), progress, within)
    words = _RELATIONS[codes]
    return words[0] if is_one else words


def patches(a: MeshLike, b: MeshLike, pose: OnePose = None) -> list[ContactPatch]:
    """Find all that two surfaces have in common, as connected curves and areas, with their length and area.

    Which faces belong together is exact, whether they cross, touch, or lie flush. Equal vertices are one. Where a mesh meets itself, what
    it covers twice counts twice, and what is joined only there counts as two.

    Parameters
    ----------
    a, b : Mesh or what `Mesh` takes
        The meshes. They need not be solids.
    pose : array_like, optional
        The pose of b in the frame of a.

    Returns
    -------
    list of ContactPatch
        In the order of their lowest pairs, in the frame of a.

    Examples
    --------
    >>> import numpy as np, pfront as pf
    >>> box, pose = pf.Mesh(*pf._box()), np.eye(4)
    >>> pose[:3, 3] = 1, 0.5, 0
    >>> [patch] = pf.patches(box, box, pose)
    >>> (low, high), (least, most) = patch.area, patch.length
    >>> patch.dimension, low <= 0.5 <= high, least <= 3 <= most, patch.closed
    (2, True, True, False)
    >>> pose[:3, 3] = 0.5, 0.25, 0.125
    >>> [curve] = pf.patches(box, box, pose)
    >>> curve.dimension, curve.closed, curve.points[curve.segments].shape[1:]
    (1, True, (2, 3))
    """
    return [ContactPatch(*found) for found in _pfront.patches(*_both(a, b), pose, current())]


@overload
def overlap_volume(a: MeshLike, b: MeshLike, pose: SomePoses, *, progress: Progress | None = None) -> Any: ...
@overload
def overlap_volume(a: MeshLike, b: MeshLike, pose: OnePose = None, *, progress: Progress | None = None) -> tuple[float, float]: ...
@overload
def overlap_volume(a: MeshLike, b: MeshLike, pose: Poses, *, progress: Progress | None = None) -> _Floats: ...
def overlap_volume(a: MeshLike, b: MeshLike, pose: Pose = None, *, progress: Progress | None = None) -> Any:
    """Measure the volume that two solids have in common: an interval that holds it, in the units of the first.

    It is found from the pairs of faces that meet, without any new mesh.

    Parameters
    ----------
    a, b, pose, progress
        As for `relation`.

    Returns
    -------
    (float, float) or ndarray of float64, shape (k, 2)
        The least and the greatest that it can be, of the coordinates as the pose has rounded them.

    Raises
    ------
    NotSolid
        If a mesh is none, or if faces of it meet beyond the corners that they share, inside the other or on its surface.

    Examples
    --------
    >>> import numpy as np, pfront as pf
    >>> box = pf.Mesh(*pf._box())
    >>> pose = np.eye(4)
    >>> pose[0, 3] = 0.75
    >>> low, high = pf.overlap_volume(box, box, pose)
    >>> low <= 0.25 <= high, high - low < 1e-12
    (True, True)
    """
    volumes, is_one = _pfront.overlap_volume(*_both(a, b), pose, current(), progress)
    return tuple(volumes[0].tolist()) if is_one else volumes


def inside(mesh: MeshLike, points: Any, *, surface: bool = True) -> Any:
    """Tell whether points are inside a solid, exactly, by winding numbers.

    Parameters
    ----------
    mesh : Mesh
        A closed mesh, as for `relation`; where its faces meet each other, the answer is exact too.
    points : array_like, shape (n, 3) or (3,)
        Points, in the frame of the mesh; taken as float64.
    surface : bool
        Whether points on the surface count as inside, as they do by default.

    Returns
    -------
    ndarray of bool, shape (n,), or bool
        One thread answers.

    Raises
    ------
    NotSolid
        If the mesh is none, as for `relation`.
    ValueError
        If a coordinate is NaN or beyond 2^125.

    Examples
    --------
    >>> import pfront as pf
    >>> box = pf.Mesh(*pf._box())
    >>> points = [[0, 0, 0], [0.5, 0, 0], [0.5000000001, 0, 0]]
    >>> pf.inside(box, points).tolist()
    [True, True, False]
    >>> pf.inside(box, points, surface=False).tolist()
    [True, False, False]
    >>> pf.inside(box, [0.1, 0.2, 0.3])
    True
    """
    given = _points(points, "points")
    found = _pfront.inside(_one(mesh), given.reshape(-1, 3), current())
    told = found != 0 if surface else found == 1
    return bool(told[0]) if given.ndim == 1 else told


def segment(mesh: MeshLike, start: Any, end: Any) -> tuple[_Faces, _Floats]:
    """Find all faces that the segment between two points meets, exactly. Touching counts.

    Parameters
    ----------
    mesh : Mesh
        Any mesh; it need not be closed.
    start, end : array_like, shape (3,)
        The points, in the frame of the mesh; taken as float64.

    Returns
    -------
    faces : ndarray of uint32, shape (h,)
        The faces, sorted.
    at : ndarray of float64, shape (h,)
        Where the first point in common is, from 0 at the start to 1 at the end, rounded.

    Raises
    ------
    ValueError
        If a coordinate is NaN or beyond 2^125.

    Examples
    --------
    >>> import pfront as pf
    >>> box = pf.Mesh(*pf._box())
    >>> faces, at = pf.segment(box, [-1, 0.1, 0.2], [1, 0.1, 0.2])
    >>> faces.tolist(), at.tolist()
    ([0, 3], [0.25, 0.75])
    """
    return _pfront.segment(_one(mesh), (point(start, "start"), point(end, "end")), current())


def segment_first(mesh: MeshLike, starts: Any, ends: Any) -> tuple[_Counts, _Floats]:
    """Find the first face along the segment from one point to another, or along each of many, exactly.

    Parameters
    ----------
    mesh : Mesh
        Any mesh; it need not be closed.
    starts, ends : array_like, shape (n, 3) or (3,)
        The points, in the frame of the mesh; taken as float64. One point may belong to many segments.

    Returns
    -------
    faces : ndarray of int64, shape (n,)
        The first face of each segment, or -1: of faces that it meets in one point, that with the lowest number.
    at : ndarray of float64, shape (n,)
        Where that is, from 0 at the start to 1 at the end, rounded; NaN where there is none. One thread answers.

    Raises
    ------
    ValueError
        If a coordinate is NaN or beyond 2^125.

    Examples
    --------
    >>> import pfront as pf
    >>> box = pf.Mesh(*pf._box())
    >>> faces, at = pf.segment_first(box, [[-1, 0.1, 0.2], [3, 0.1, 0.2], [-1, 2, 2]], [1, 0.1, 0.2])
    >>> faces.tolist(), at.tolist()
    ([0, -1, -1], [0.25, nan, nan])
    """
    given = np.broadcast_arrays(*(np.atleast_2d(_points(of, what)) for of, what in ((starts, "starts"), (ends, "ends"))))
    first, last = (np.ascontiguousarray(of) for of in given)
    return _pfront.segment_first(_one(mesh), first, last, current())


@dataclass(frozen=True)
class Impact:
    """When two faces meet first, or come within a distance, as far as it is proven; 0 is the start of the motion and 1 its end.

    Attributes
    ----------
    pair : (int, int)
        The faces.
    start : float
        They do not meet before this time.
    end : float
        They certainly meet between `start` and this; inf if that is open, as where they touch and do not pass.
    """

    pair: tuple[int, int]
    start: float
    end: float

    @property
    def proven(self) -> bool:
        return self.end < np.inf


@dataclass(frozen=True, eq=False, repr=False)
class Impacts:
    """Pairs of faces that meet on the way, and when: arrays of one length.

    Attributes
    ----------
    pairs : ndarray of uint32, shape (n, 2)
        The faces, sorted.
    start, end : ndarray of float64, shape (n,)
        As those of `Impact`.
    """

    pairs: _Pairs
    start: _Floats
    end: _Floats

    @property
    def proven(self) -> _Bools:
        return self.end < np.inf

    def __len__(self) -> int:
        return len(self.pairs)

    def __repr__(self) -> str:
        return f"{type(self).__name__}({len(self)} pairs)"


def _end(mesh: MeshLike, end: Any) -> _pfront.Model | None:
    if end is None:
        return None
    mesh = mesh if isinstance(mesh, Mesh) else Mesh(mesh)
    return end._model if isinstance(end, Mesh) else mesh.with_vertices(end)._model


def _motions(
    a: MeshLike, b: MeshLike | None, pose: OnePose, pose_end: OnePose, a_end: Any, b_end: Any
) -> tuple[_pfront.Model, _pfront.Model | None, _pfront.Model | None, _pfront.Model | None, tuple[OnePose, OnePose]]:
    if b is None:
        if pose is not None or pose_end is not None or b_end is not None:
            raise ValueError("pose, pose_end and b_end are those of b, which is not given")
        if a_end is None:
            raise ValueError("one mesh alone has to move: a_end says where to")
    elif b_end is not None and (pose is not None or pose_end is not None):
        raise ValueError("a mesh that deforms has no pose: give its vertices in the frame of a")
    first, second = _two(a, b)
    second_end = None if b is None else _end(b, b_end)
    return first, _end(a, a_end), second, second_end, (pose, pose if pose_end is None else pose_end)


def impacts(
    a: MeshLike, b: MeshLike | None = None, pose: OnePose = None, *, pose_end: OnePose = None, a_end: Any = None, b_end: Any = None,
    within: float = 0.0,
) -> Impacts:  # fmt: skip
    """Find the faces of two moving meshes, or of one that deforms, that meet on the way, and when.

    Every vertex goes in a straight line, from its place at time 0 to that at time 1, also where a pose turns. No pair is missed.

    Parameters
    ----------
    a, b : Mesh or what `Mesh` takes
        The meshes at time 0; without b, a is asked about itself.
    pose, pose_end : array_like, optional
        The pose of b in the frame of a at time 0 and at time 1; without the second, b stays.
    a_end, b_end : Mesh or array_like of shape (n, 3), optional
        A mesh that deforms: its vertices at time 1, or a mesh of the same faces.
    within : float
        Ask for pairs that come at most so far apart on the way, in place of those that meet; rounded up to float32, so that no pair is
        missed. What two faces of one mesh share by index is decided as without.

    Returns
    -------
    Impacts
        Pairs, sorted, with the time before which each does not meet and that before which it certainly does. CPUs answer.

    Raises
    ------
    ValueError
        If the faces at both times are not the same, or nothing moves; if `within` is NaN, infinite or negative.

    Examples
    --------
    >>> import numpy as np, pfront as pf
    >>> wall = pf.Mesh([[-1, 0, -1], [1, 0, -1], [0, 0, 2]], [[0, 1, 2]])
    >>> bullet = pf.Mesh([[0, 0, 0], [0.01, 0, 0], [0, 0, 0.01]], [[0, 1, 2]])
    >>> before, behind = np.eye(4), np.eye(4)
    >>> before[1, 3], behind[1, 3] = 0.25, -0.75
    >>> pf.collides(wall, bullet, before) or pf.collides(wall, bullet, behind)
    False
    >>> found = pf.impacts(wall, bullet, before, pose_end=behind)
    >>> found.pairs.tolist(), bool(found.start[0] <= 0.25 <= found.end[0] < 0.250001)
    ([[0, 0]], True)
    """
    return Impacts(*_pfront.impacts(_motions(a, b, pose, pose_end, a_end, b_end), within, current()))


def first_impact(
    a: MeshLike, b: MeshLike | None = None, pose: OnePose = None, *, pose_end: OnePose = None, a_end: Any = None, b_end: Any = None,
    within: float = 0.0,
) -> Impact | None:  # fmt: skip
    """Find the faces of two moving meshes, or of one that deforms, that meet first, and when.

    Parameters
    ----------
    a, b, pose, pose_end, a_end, b_end, within
        As for `impacts`.

    Returns
    -------
    Impact or None
        That with the least `start`, and of several that with the lowest pair; None if nothing meets.

    Examples
    --------
    >>> import numpy as np, pfront as pf
    >>> box, start, end = pf.Mesh(*pf._box()), np.eye(4), np.eye(4)
    >>> start[0, 3], end[0, 3] = 3, 1.5
    >>> pf.first_impact(box, box, start, pose_end=end) is None
    True
    >>> end[0, 3] = -1
    >>> first = pf.first_impact(box, box, start, pose_end=end)
    >>> first.start <= 0.5, first.start > 0.499
    (True, True)
    """
    found = _pfront.first_impact(_motions(a, b, pose, pose_end, a_end, b_end), within, current())
    return None if found is None else Impact(*found)


def any_impact(
    a: MeshLike, b: MeshLike | None = None, pose: OnePose = None, *, pose_end: OnePose = None, a_end: Any = None, b_end: Any = None,
    within: float = 0.0,
) -> Impact | None:  # fmt: skip
    """Find some faces of two moving meshes, or of one that deforms, that meet on the way, if any do.

    Stops at the first pair that certainly meets, whenever that is, where `first_impact` has to look for what comes before. Other numbers of
    threads may find other pairs.

    Parameters
    ----------
    a, b, pose, pose_end, a_end, b_end, within
        As for `impacts`.

    Returns
    -------
    Impact or None
        One of `impacts`, proven if any of them is; None if there are none.

    Examples
    --------
    >>> import numpy as np, pfront as pf
    >>> box, start, end = pf.Mesh(*pf._box()), np.eye(4), np.eye(4)
    >>> start[0, 3], end[0, 3] = 3, 1.5
    >>> pf.any_impact(box, box, start, pose_end=end) is None
    True
    >>> pf.any_impact(box, box, start, pose_end=end, within=0.75).proven
    True
    """
    found = _pfront.any_impact(_motions(a, b, pose, pose_end, a_end, b_end), within, current())
    return None if found is None else Impact(*found)


def count_impacts(
    a: MeshLike, b: MeshLike | None = None, pose: OnePose = None, *, pose_end: OnePose = None, a_end: Any = None, b_end: Any = None,
    within: float = 0.0,
) -> tuple[int, int]:  # fmt: skip
    """Count the pairs of faces of two moving meshes, or of one that deforms, that meet on the way. No list is kept.

    Parameters
    ----------
    a, b, pose, pose_end, a_end, b_end, within
        As for `impacts`.

    Returns
    -------
    (int, int)
        The least and the greatest that the number can be: how many of `impacts` are proven, and how many there are.

    Examples
    --------
    >>> import pfront as pf
    >>> faces = [[0, 1, 2], [3, 4, 5]]
    >>> low = [[0, 0, 0], [1, 0, 0], [0, 1, 0]]
    >>> above, below = ([[x, y, z] for x, y, _ in low] for z in (0.5, -0.5))
    >>> pf.count_impacts(pf.Mesh(low + above, faces), a_end=low + below)
    (1, 1)
    """
    return _pfront.count_impacts(_motions(a, b, pose, pose_end, a_end, b_end), within, current())


@dataclass(frozen=True)
class Part:
    """Part `i` of `n` of questions, 0 ≤ i < n ≤ 65536; see `part`."""

    i: int
    n: int

    def __post_init__(self) -> None:
        object.__setattr__(self, "i", integer(self.i, "i of a part"))
        object.__setattr__(self, "n", integer(self.n, "n of a part"))
        if not (0 <= self.i < self.n <= 65536):
            raise ValueError(f"part {self.i} of {self.n} is not 0 ≤ i < n ≤ 65536")

    def pairs(self, a: MeshLike, b: MeshLike | None = None, pose: OnePose = None, *, within: float = 0.0) -> _Pairs:
        """List the pairs of this part, sorted; the parts together list each pair of `pfront.pairs` once."""
        found: _Pairs = _pfront.all(*_two(a, b), pose, current(), None, (self.i, self.n), within)[0]
        return found

    def count(self, a: MeshLike, b: MeshLike | None = None, pose: OnePose = None, *, within: float = 0.0) -> int:
        """Count the pairs of this part."""
        found: int = _pfront.count(*_two(a, b), pose, current(), None, (self.i, self.n), within)
        return found


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
    return Part(i, n)


_WHAT: dict[str, Callable[..., Any]] = {
    "collides": collides, "count": count, "pairs": pairs, "contacts": contacts, "distance": distance, "relation": relation,
    "overlap_volume": overlap_volume,
}  # fmt: skip


class _Sent:
    """A mesh on its way to other processes, where it arrives as itself. Its blob is made once, and goes with this."""

    def __init__(self, mesh: Mesh) -> None:
        self.mesh = mesh
        self._reduced: dict[bool, tuple[Any, ...]] = {}

    def __reduce_ex__(self, protocol: Any) -> tuple[Any, ...]:
        is_out_of_band = protocol >= 5
        if is_out_of_band not in self._reduced:
            self._reduced[is_out_of_band] = self.mesh.__reduce_ex__(protocol)
        return self._reduced[is_out_of_band]


def _task(what: str, a: Mesh | _Sent, b: Mesh | _Sent, poses: npt.NDArray[Any], options: dict[str, float | None]) -> Any:
    """One chunk of a sweep, as another process answers it, or a thread of this one."""
    return _WHAT[what](*(mesh.mesh if isinstance(mesh, _Sent) else mesh for mesh in (a, b)), poses, **options)


@overload
def sweep(
    a: MeshLike, b: MeshLike, poses: Poses | SomePoses, what: Literal["collides"] = "collides", *, progress: Progress | None = None,
    executor: Submits | None = None, chunk: int = 10_000, window: int = 64, within: float = 0.0,
) -> Iterator[tuple[int, bool]]: ...  # fmt: skip
@overload
def sweep(
    a: MeshLike, b: MeshLike, poses: Poses | SomePoses, what: Literal["count"], *, progress: Progress | None = None,
    executor: Submits | None = None, chunk: int = 10_000, window: int = 64, within: float = 0.0,
) -> Iterator[tuple[int, int]]: ...  # fmt: skip
@overload
def sweep(
    a: MeshLike, b: MeshLike, poses: Poses | SomePoses, what: Literal["pairs"], *, progress: Progress | None = None,
    executor: Submits | None = None, chunk: int = 10_000, window: int = 64, within: float = 0.0,
) -> Iterator[tuple[int, _Pairs]]: ...  # fmt: skip
@overload
def sweep(
    a: MeshLike, b: MeshLike, poses: Poses | SomePoses, what: Literal["contacts"], *, progress: Progress | None = None,
    executor: Submits | None = None, chunk: int = 10_000, window: int = 64,
) -> Iterator[tuple[int, Contacts]]: ...  # fmt: skip
@overload
def sweep(
    a: MeshLike, b: MeshLike, poses: Poses | SomePoses, what: Literal["distance"], *, progress: Progress | None = None,
    executor: Submits | None = None, chunk: int = 10_000, window: int = 64, limit: float | None = None,
) -> Iterator[tuple[int, Gap | None]]: ...  # fmt: skip
@overload
def sweep(
    a: MeshLike, b: MeshLike, poses: Poses | SomePoses, what: Literal["relation"], *, progress: Progress | None = None,
    executor: Submits | None = None, chunk: int = 10_000, window: int = 64, within: float = 0.0,
) -> Iterator[tuple[int, Relation | None]]: ...  # fmt: skip
@overload
def sweep(
    a: MeshLike, b: MeshLike, poses: Poses | SomePoses, what: Literal["overlap_volume"], *, progress: Progress | None = None,
    executor: Submits | None = None, chunk: int = 10_000, window: int = 64,
) -> Iterator[tuple[int, tuple[float, float]]]: ...  # fmt: skip
def sweep(
    a: MeshLike, b: MeshLike, poses: Poses | SomePoses, what: str = "collides", *, progress: Progress | None = None,
    executor: Submits | None = None, chunk: int = 10_000, window: int = 64, within: float = 0.0, limit: float | None = None,
) -> Iterator[tuple[int, Any]]:  # fmt: skip
    """Ask about many poses, and yield each index with its answer, in order, while later ones are on their way.

    Each pose is an instant: nothing is asked about the motion from one to the next.

    Parameters
    ----------
    a, b : Mesh
        The meshes.
    poses : array_like, shape (k, 4, 4)
        As for `collides`; copied by the call, so that the array is free for other use at once.
    what : {"collides", "count", "pairs", "contacts", "distance", "relation", "overlap_volume"}
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
    within : float
        As for `collides`; contacts are of pairs that intersect, and take none, nor do distances and volumes.
    limit : float, optional
        As for `distance`, which alone takes one.

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
    chunk, window = integer(chunk, "chunk"), integer(window, "window")
    if chunk < 1 or window < 1:
        raise ValueError("chunk and window are at least 1")
    if what in ("contacts", "distance", "overlap_volume") and within != 0:
        raise ValueError(f"what={what!r} is not about pairs within a distance: leave out within")
    if what != "distance" and limit is not None:
        raise ValueError(f"what={what!r} has no limit: leave it out")
    options: dict[str, float | None] = {} if what in ("contacts", "overlap_volume") else {"within": _pfront.at_least(within)}
    if what == "distance":
        options = {"limit": None if limit is None else _pfront.at_least(limit)}
    first = a if isinstance(a, Mesh) else Mesh(a)
    second = b if isinstance(b, Mesh) else Mesh(b)
    array = matrix(poses)
    if array.ndim != 3:
        raise PoseError(f"poses of shape {array.shape} are not (k, 4, 4)")
    return _swept(first, second, array.copy(), what, progress, executor, chunk, window, options)


def _swept(
    a: Mesh,
    b: Mesh,
    poses: npt.NDArray[Any],
    what: str,
    progress: Progress | None,
    executor: Submits | None,
    chunk: int,
    window: int,
    options: dict[str, float | None],
) -> Iterator[tuple[int, Any]]:
    starts = range(0, len(poses), chunk)
    flying: dict[int, Any] = {}
    sent = [_Sent(a), _Sent(b)]

    def launch(executor: Submits, start: int) -> None:
        flying[start] = executor.submit(_task, what, *sent, poses[start : start + chunk], options)

    try:
        ahead = iter(starts)
        if executor is not None:
            for _, start in zip(range(window), ahead):
                launch(executor, start)
        for start in starts:
            try:
                answers = _task(what, a, b, poses[start : start + chunk], options) if executor is None else flying.pop(start).result()
            except PoseError as error:
                # The pose is one of its chunk there.
                error.args = (str(error).replace(f"pose {error.pose}", f"pose {start + (error.pose or 0)}", 1),)
                error.pose = start + (error.pose or 0)
                raise
            if executor is not None and (following := next(ahead, None)) is not None:
                launch(executor, following)
            if progress is not None:
                progress(min(start + chunk, len(poses)), len(poses))
            if isinstance(answers, np.ndarray):
                answers = answers.tolist() if answers.ndim == 1 else map(tuple, answers.tolist())
            for i, answer in enumerate(answers, start):
                yield i, answer
    finally:
        for future in flying.values():
            future.cancel()
