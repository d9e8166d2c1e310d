"""Many meshes in one world."""

from __future__ import annotations

from collections.abc import Hashable
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from . import _pfront
from ._errors import StaleBody
from ._mesh import Mesh
from ._poses import Pose
from ._questions import Contacts
from ._settings import current

__all__ = ["Scene", "Hits", "SceneContacts"]


@dataclass(frozen=True, eq=False, repr=False)
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

    def __repr__(self) -> str:
        return f"Hits({len(self)} pairs)"


@dataclass(frozen=True, eq=False, repr=False)
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

    def add(self, mesh: Any, pose: Pose = None, *, name: Hashable = None, user_id: Any = None) -> Any:
        """Add a body, or one for each of many poses.

        Parameters
        ----------
        mesh : Mesh
            Bodies may share one.
        pose : array_like, optional
            ``world_from_body``, as for `collides`: one pose, or (k, 4, 4).
        name : optional
            Anything; see `name`.
        user_id : int, or array_like of k, optional
            Numbers of your own; see `user_ids`.

        Returns
        -------
        int or ndarray of int64
            The id of each body: 0, 1, 2, ... in the order of adding; none is ever used again.
        """
        body = self._scene.add(_mesh(mesh), pose, None if user_id is None else _numbers(user_id, np.int64))
        if name is not None:
            self._names.update(dict.fromkeys(np.atleast_1d(body).tolist(), name))
        return body

    def remove(self, body: int) -> None:
        """Take a body out; one that is not there raises `StaleBody`."""
        self._scene.remove(body)
        self._names.pop(body, None)

    def name(self, body: int) -> Any:
        """The name of a body; None if it was given none."""
        return self._names.get(int(body))

    def user_ids(self, bodies: npt.ArrayLike) -> npt.NDArray[np.int64]:
        """Look up the numbers that `add` was given for bodies; by default a body has its id.

        Parameters
        ----------
        bodies : int, or array_like of any shape
            Ids, as those of `body_pairs` or of ``Hits.bodies``.

        Examples
        --------
        >>> import numpy as np, pfront as pf
        >>> scene, box = pf.Scene(), pf.Mesh(*pf._box())
        >>> _ = scene.add(box, np.tile(np.eye(4), (2, 1, 1)), user_id=[70, 71])
        >>> scene.user_ids(scene.body_pairs())
        array([[70, 71]])
        """
        ids = _numbers(bodies, np.uint64)
        return self._scene.user_ids(ids.reshape(-1)).reshape(np.shape(bodies))

    def set_poses(self, bodies: npt.ArrayLike, poses: Pose) -> None:
        """Move bodies; body ``bodies[i]`` to ``poses[i]``.

        Raises
        ------
        StaleBody, PoseError
            With the index in ``.pose``; bodies before it have moved.
        """
        self._scene.set_poses(_numbers(bodies, np.uint64), poses)

    def set_mesh(self, body: int, mesh: Any) -> None:
        """Give a body another mesh, as `Mesh.with_vertices` makes of one that deforms; it stays where it is.

        Examples
        --------
        >>> import numpy as np, pfront as pf
        >>> box, pose = pf.Mesh(*pf._box()), np.eye(4)
        >>> pose[2, 3] = 1.5
        >>> scene = pf.Scene()
        >>> table, balloon = scene.add(box), scene.add(box, pose)
        >>> scene.collides()
        False
        >>> scene.set_mesh(balloon, box.with_vertices(2 * box.vertices))
        >>> scene.collides()
        True
        """
        self._scene.set_model(body, _mesh(mesh))

    def ignore(self, a: int, b: int, ignored: bool = True) -> None:
        """Ignore what two bodies do to each other, as links of a joint that overlap by design; or no longer."""
        self._scene.ignore(a, b, ignored)

    def __len__(self) -> int:
        return self._scene.len()

    def __repr__(self) -> str:
        return f"Scene({len(self)} bodies)"

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


def _mesh(mesh: Any) -> _pfront.Model:
    return mesh._model if isinstance(mesh, Mesh) else Mesh(mesh)._model


def _numbers(numbers: npt.ArrayLike, kind: Any) -> npt.NDArray[Any]:
    """Integers, in an array that is aligned and in C order."""
    array = np.atleast_1d(np.asarray(numbers))
    if array.size == 0:
        return np.empty(array.shape, kind)
    if array.dtype.kind not in "iu":
        raise TypeError(f"ids of dtype {array.dtype} are no integers")
    if kind == np.uint64 and array.min() < 0:
        raise StaleBody("ids of bodies are 0 and more")
    if kind == np.int64 and array.max() > np.iinfo(np.int64).max:
        raise ValueError(f"user id {array.max()} does not fit in int64")
    return np.require(array, kind, ("C", "A"))
