"""The collision manager of trimesh, answered by pfront: change one import.

Meshes are surfaces here, where trimesh takes convex ones for solids: a box inside another does not collide, and has a distance to it.
Where objects intersect, their distance is 0, where trimesh's is 0 or the negative of a depth; without a second object it is inf.
"""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

import numpy as np
import numpy.typing as npt

from ._mesh import Mesh, MeshLike
from ._poses import OnePose
from ._questions import Gap
from ._scene import Scene, SceneContacts

__all__ = ["CollisionManager", "ContactData", "DistanceData"]


class ContactData:
    """One pair of triangles that meet, with the properties that trimesh's has.

    Attributes
    ----------
    names : set of str
        Both objects.
    point, normal : ndarray
        The middle of the segment in which they meet, and the normal of the first triangle.
    """

    __slots__ = ("_found", "_row", "_names")

    def __init__(self, found: SceneContacts, row: int, names: tuple[str, str]) -> None:
        self._found = found
        self._row = row
        self._names = names

    @property
    def names(self) -> set[str]:
        return set(self._names)

    @property
    def point(self) -> npt.NDArray[Any]:
        middle: npt.NDArray[Any] = self._found.segments[self._row].mean(axis=0)
        return middle

    @property
    def normal(self) -> npt.NDArray[np.float32]:
        normal: npt.NDArray[np.float32] = self._found.normals[self._row, 0]
        return normal

    def index(self, name: str) -> int:
        """The face of the object of that name."""
        return int(self._found.pairs[self._row, _place(self._names, name)])


class DistanceData:
    """The nearest triangles of two objects, with the properties that trimesh's has.

    Attributes
    ----------
    names : set of str
        Both objects.
    distance : float
        The smallest distance: the upper end of an interval that holds it.
    """

    __slots__ = ("_gap", "_names")

    def __init__(self, gap: Gap, names: tuple[str, str]) -> None:
        self._gap = gap
        self._names = names

    @property
    def names(self) -> set[str]:
        return set(self._names)

    @property
    def distance(self) -> float:
        return self._gap.distance

    def index(self, name: str) -> int:
        """The nearest face of the object of that name."""
        return self._gap.pair[_place(self._names, name)]

    def point(self, name: str) -> npt.NDArray[np.float64]:
        """The nearest point of the object of that name, in the world."""
        point: npt.NDArray[np.float64] = self._gap.points[_place(self._names, name)]
        return point


def _place(names: tuple[str, str], name: str) -> int:
    """Which of two names one is."""
    if name not in names:
        raise KeyError(name)
    return names.index(name)


def _nearest(scene: Scene, bodies: Iterable[int]) -> tuple[tuple[int, int], Gap] | None:
    """The two nearest bodies, of which the first is one of these, and how far apart they are."""
    best = None
    for body in bodies:
        found = scene.distance(body, limit=None if best is None else best[1].distance)
        if found is not None and (best is None or found[1].distance < best[1].distance):
            best = (body, found[0]), found[1]
            if found[1].distance == 0:
                break
    return best


def _data(found: SceneContacts, names: dict[tuple[int, int], tuple[str, str]]) -> list[ContactData]:
    """The contacts of the pairs of bodies that have names."""
    bodies = map(tuple, found.bodies.tolist())
    return [ContactData(found, row, names[two]) for row, two in enumerate(bodies) if two in names]


class CollisionManager:
    """Named objects, as trimesh's manager keeps them.

    Examples
    --------
    >>> import numpy as np, pfront as pf
    >>> manager = pf.compat.CollisionManager()
    >>> box = pf.Mesh(*pf._box())
    >>> pose = np.eye(4); pose[0, 3] = 1
    >>> _ = manager.add_object("a", box), manager.add_object("b", box, pose)
    >>> manager.in_collision_internal(return_names=True)
    (True, {('a', 'b')})
    """

    def __init__(self) -> None:
        self._scene = Scene()
        self._ids: dict[str, int] = {}

    def add_object(self, name: str, mesh: MeshLike, transform: OnePose = None) -> int:
        """Add an object; one of that name is replaced."""
        body = self._scene.add(mesh if isinstance(mesh, Mesh) else Mesh(mesh), transform, name=name)
        if name in self._ids:
            self.remove_object(name)
        self._ids[name] = body
        return body

    def remove_object(self, name: str) -> None:
        """Take an object out; ValueError if there is none."""
        if name not in self._ids:
            raise ValueError(f"{name} not in collision manager!")
        self._scene.remove(self._ids.pop(name))

    def set_transform(self, name: str, transform: OnePose) -> None:
        """Move an object; ValueError if there is none."""
        if name not in self._ids:
            raise ValueError(f"{name} not in collision manager!")
        self._scene.set_poses([self._ids[name]], transform)

    def in_collision_internal(self, return_names: bool = False, return_data: bool = False) -> Any:
        """Whether any two objects meet; with their names, and with data of each pair of triangles."""
        if not (return_names or return_data):
            return self._scene.collides()
        found = self._scene.contacts() if return_data else None
        pairs = {(a, b): (self._name(a), self._name(b)) for a, b in self._scene.intersecting_bodies().tolist()}
        data = [] if found is None else _data(found, pairs)
        names = {(min(two), max(two)) for two in pairs.values()}
        return self._answer(bool(names), names, data, return_names, return_data)

    def in_collision_single(
        self, mesh: MeshLike, transform: OnePose = None, return_names: bool = False, return_data: bool = False
    ) -> Any:
        """Whether a mesh meets any object; with the names of those, and with data. Objects are not asked about each other."""
        other = CollisionManager()
        other.add_object("__external", mesh, transform)
        found = self.in_collision_other(other, True, return_data)
        names = {name for name, _ in found[1]}
        return self._answer(found[0], names, found[2] if return_data else [], return_names, return_data)

    def in_collision_other(
        self, other_manager: CollisionManager, return_names: bool = False, return_data: bool = False
    ) -> Any:
        """Whether an object meets one of another manager; with the names of both. Objects of one manager are not asked about each other."""
        both, _ = self._scene._across(other_manager._scene, True)
        if not (return_names or return_data):
            return both.collides()
        across = both.intersecting_bodies()
        owners = both.user_ids(across).tolist()
        pairs = {(a, b): (self._name(i), other_manager._name(j)) for (a, b), (i, j) in zip(across.tolist(), owners)}
        names = set(pairs.values())
        data = _data(both.contacts(), pairs) if return_data and pairs else []
        return self._answer(bool(names), names, data, return_names, return_data)

    def min_distance_internal(self, name: str | None = None, return_names: bool = False, return_data: bool = False) -> Any:
        """The smallest distance of any two objects, or of one to the others; with both names, sorted, and with data.

        For n objects, n searches in boxes of n. ValueError if there is no object of that name.
        """
        if name is not None and name not in self._ids:
            raise ValueError(f"{name} not in collision manager!")
        found = _nearest(self._scene, self._ids.values() if name is None else [self._ids[name]])
        if found is None:
            return self._answer(np.inf, None, None, return_names, return_data)
        (a, b), gap = found
        names = (self._name(a), self._name(b))
        return self._answer(gap.distance, (min(names), max(names)), DistanceData(gap, names), return_names, return_data)

    def min_distance_single(
        self, mesh: MeshLike, transform: OnePose = None, return_name: bool = False, return_data: bool = False
    ) -> Any:
        """The smallest distance of a mesh to any object; with the name of that, and with data, where the mesh is ``"__external"``."""
        other = CollisionManager()
        other.add_object("__external", mesh, transform)
        distance, names, data = self.min_distance_other(other, True, True)
        return self._answer(distance, names and names[0], data, return_name, return_data)

    def min_distance_other(self, other_manager: CollisionManager, return_names: bool = False, return_data: bool = False) -> Any:
        """The smallest distance of an object to one of another manager; with the names of both, this manager's first, and with data.

        A search for each object of the manager that has fewer.
        """
        both, count = self._scene._across(other_manager._scene, False)
        is_own = 2 * count <= len(both)
        found = _nearest(both, range(count) if is_own else range(count, len(both)))
        if found is None:
            return self._answer(np.inf, None, None, return_names, return_data)
        two, gap = found
        if not is_own:
            two, gap = (two[1], two[0]), Gap(gap.interval, (gap.pair[1], gap.pair[0]), gap.points[::-1])
        own, theirs = both.user_ids(two).tolist()
        names = (self._name(own), other_manager._name(theirs))
        return self._answer(gap.distance, names, DistanceData(gap, names), return_names, return_data)

    def __reduce_ex__(self, protocol: Any) -> Any:
        raise TypeError("a manager has a scene, and is neither copied nor pickled: add its objects to a new one")

    def _name(self, body: int) -> str:
        return str(self._scene.name(body))

    @staticmethod
    def _answer(hit: Any, names: Any, data: Any, return_names: bool, return_data: bool) -> Any:
        if return_names and return_data:
            return hit, names, data
        if return_names:
            return hit, names
        return (hit, data) if return_data else hit
