"""Many meshes in one world."""

from __future__ import annotations

from collections.abc import Hashable
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from . import _pfront
from ._errors import PoseError, StaleBody
from ._mesh import Mesh
from ._questions import Contacts, Pose, _matrix, _pose
from ._settings import current

__all__ = ["Scene", "Hits", "SceneContacts"]


@dataclass(frozen=True, eq=False)
class Hits:
    """Pairs of triangles of different bodies that meet, sorted.

    Attributes
    ----------
    bodies : ndarray of int64, shape (n, 2)
        The ids of both bodies, the one that was added first before the other.
    pairs : ndarray of uint32, shape (n, 2)
        A face of each.
    """

    bodies: npt.NDArray[np.int64]
    pairs: npt.NDArray[np.uint32]

    def __len__(self) -> int:
        return len(self.pairs)


@dataclass(frozen=True, eq=False)
class SceneContacts(Contacts):
    """Where bodies meet, in the world: `Contacts`, and the `bodies` of each.

    Attributes
    ----------
    bodies : ndarray of int64, shape (n, 2)
        The ids of both bodies.
    """

    bodies: npt.NDArray[np.int64]


class Scene:
    """Bodies, each a mesh in a pose, that are added, moved and removed between questions.

    Every vertex is posed into the world, so that `pose` here is ``world_from_body``. What has not moved since the last
    `pairs` or `contacts` is not asked again.

    Examples
    --------
    >>> import numpy as np, pfront as pf
    >>> box, pose = pf.Mesh(*pf._box()), np.eye(4)
    >>> scene = pf.Scene()
    >>> table = scene.add(box, name="table")
    >>> pose[2, 3] = 1  # stands on it
    >>> cup = scene.add(box, pose, name="cup")
    >>> [[scene.name(i) for i in two] for two in scene.body_pairs()]
    [['table', 'cup']]
    >>> scene.ignore(table, cup)
    >>> scene.collides()
    False
    """

    __slots__ = ("_scene", "_names")

    def __init__(self) -> None:
        self._scene = _pfront.Scene()
        self._names: dict[int, Hashable] = {}

    def add(self, mesh: Any, pose: Pose = None, *, name: Hashable = None) -> int:
        """Add a body, or one for each of (k, 4, 4) poses by `add_many`, and return its id, which is never used again.

        Parameters
        ----------
        mesh : Mesh
            Bodies may share one.
        pose : array_like, optional
            ``world_from_body``, 4×4.
        name : optional
            Anything; see `name`.
        """
        array = _pose(pose)
        if array is not None and array.ndim == 3:
            raise PoseError("a body has one pose: add_many adds one for each")
        model = mesh if isinstance(mesh, Mesh) else Mesh(mesh)
        body = self._scene.add(model._model, array)
        if name is not None:
            self._names[body] = name
        return body

    def add_many(self, mesh: Any, poses: Pose) -> npt.NDArray[np.int64]:
        """Add a body of one mesh for each of (k, 4, 4) poses, and return their ids."""
        model = mesh if isinstance(mesh, Mesh) else Mesh(mesh)
        return self._scene.add_many(model._model, self._many(poses))

    def remove(self, body: int) -> None:
        """Take a body out; one that is not there raises `StaleBody`."""
        self._scene.remove(body)
        self._names.pop(body, None)

    def name(self, body: int) -> Any:
        """The name of a body; None if it was given none."""
        return self._names.get(int(body))

    def set_poses(self, bodies: npt.ArrayLike, poses: Pose) -> None:
        """Move bodies; body ``bodies[i]`` to ``poses[i]``.

        Raises
        ------
        StaleBody, PoseError
            With the index in ``.pose``; bodies before it have moved.
        """
        ids = np.atleast_1d(np.asarray(bodies))
        if ids.dtype.kind not in "iu" or (ids.dtype.kind == "i" and ids.size and ids.min() < 0):
            raise StaleBody("ids are numbers of 0 and more")
        array = self._many(poses)
        if len(ids) != len(array):
            raise PoseError(f"{len(array)} poses were given for {len(ids)} bodies")
        self._scene.set_poses(np.require(ids, np.uint64, ("C", "A")), array)

    @staticmethod
    def _many(poses: Pose) -> npt.NDArray[Any]:
        array = _matrix(poses)
        return array if array.ndim == 3 else np.require(array[None, :3], requirements=("C", "A"))

    def ignore(self, a: int, b: int, ignored: bool = True) -> None:
        """Ignore what two bodies do to each other, as links of a joint that overlap by design; or no longer."""
        self._scene.ignore(a, b, ignored)

    def __len__(self) -> int:
        return self._scene.len()

    def pairs(self) -> Hits:
        """List the pairs of triangles of different bodies that meet."""
        return Hits(*self._scene.pairs(current()))

    def body_pairs(self) -> npt.NDArray[np.int64]:
        """List the pairs of bodies that meet, (n, 2); each two are asked until their first hit, which takes far less."""
        return self._scene.body_pairs(current())

    def contacts(self) -> SceneContacts:
        """Find where bodies meet, in the world: in float64 if some body is, else in float32."""
        bodies, found = self._scene.contacts(current())
        return SceneContacts(*found, bodies)

    def count(self) -> int:
        """Count the pairs of triangles that meet."""
        return self._scene.count(current())

    def collides(self) -> bool:
        """Whether any two bodies meet."""
        return self._scene.any(current())
