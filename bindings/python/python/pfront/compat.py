"""The collision manager of trimesh, answered by pfront: change one import.

Meshes are surfaces here, where trimesh takes convex ones for solids: a box inside another does not collide. Distances are not there.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

from ._mesh import Mesh, MeshLike
from ._poses import OnePose
from ._scene import Scene, SceneContacts

__all__ = ["CollisionManager", "ContactData"]


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
        if name not in self._names:
            raise KeyError(name)
        return int(self._found.pairs[self._row, self._names.index(name)])


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
        both = self._scene._across(other_manager._scene)
        if not (return_names or return_data):
            return both.collides()
        across = both.intersecting_bodies()
        owners = both.user_ids(across).tolist()
        pairs = {(a, b): (self._name(i), other_manager._name(j)) for (a, b), (i, j) in zip(across.tolist(), owners)}
        names = set(pairs.values())
        data = _data(both.contacts(), pairs) if return_data and pairs else []
        return self._answer(bool(names), names, data, return_names, return_data)

    def __reduce_ex__(self, protocol: Any) -> Any:
        raise TypeError("a manager has a scene, and is neither copied nor pickled: add its objects to a new one")

    def _name(self, body: int) -> str:
        return str(self._scene.name(body))

    @staticmethod
    def _answer(hit: bool, names: Any, data: Any, return_names: bool, return_data: bool) -> Any:
        if return_names and return_data:
            return hit, names, data
        if return_names:
            return hit, names
        return (hit, data) if return_data else hit
