"""Many meshes in one world."""

from __future__ import annotations

import re
import warnings
from collections.abc import Hashable, Iterable, Mapping
from dataclasses import dataclass
from typing import Any, Literal, NoReturn, overload

import numpy as np
import numpy.typing as npt

from . import _pfront
from ._arrays import Rows, array, integer, rows
from ._arrays import point as _point
from ._check import CheckedPair, CheckReport, ContactSize
from ._errors import NotSolid, StaleBody
from ._mesh import Mesh, MeshLike, Path, bodies
from ._poses import OnePose, Pose, Poses, SomePoses
from ._questions import Contacts, Gap, Gaps, Impact, Impacts, Relation
from ._settings import current

__all__ = ["Scene", "Hits", "SceneContacts", "SceneImpact", "SceneImpacts", "check"]


@dataclass(frozen=True, eq=False, repr=False)
class Hits:
    """Pairs of triangles of different bodies that meet, or of one that is asked about itself, sorted.

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

    def __getitem__(self, index: Rows) -> Hits:
        """The hits that a slice, a mask or an array of indices selects, as ``hits[hits.bodies[:, 0] == table]``."""
        return Hits(self.bodies[rows(index, "hits")], self.pairs[index])

    def to_dict(self) -> dict[str, npt.NDArray[Any]]:
        """Columns by their names, as ``pandas.DataFrame(hits.to_dict())`` takes them.

        Examples
        --------
        >>> import pfront as pf
        >>> scene, box = pf.Scene(), pf.Mesh(*pf._box())
        >>> _ = scene.add(box), scene.add(box)
        >>> list(scene.pairs()[:1].to_dict())
        ['body_a', 'body_b', 'face_a', 'face_b']
        """
        faces = {"face_a": self.pairs[:, 0], "face_b": self.pairs[:, 1]}
        return {"body_a": self.bodies[:, 0], "body_b": self.bodies[:, 1], **faces}


@dataclass(frozen=True, eq=False, repr=False)
class SceneContacts(Contacts):
    """Where bodies meet, in the world: `Contacts`, and the `bodies` of each.

    Attributes
    ----------
    bodies : ndarray of int64, shape (n, 2)
        The ids of both bodies.
    """

    bodies: npt.NDArray[np.int64]

    def to_dict(self) -> dict[str, npt.NDArray[Any]]:
        """Columns by their names: those of `Contacts.to_dict`, after ``body_a`` and ``body_b``."""
        return {"body_a": self.bodies[:, 0], "body_b": self.bodies[:, 1], **super().to_dict()}


@dataclass(frozen=True)
class SceneImpact(Impact):
    """When two faces of bodies meet first: `Impact`, and the `bodies`.

    Attributes
    ----------
    bodies : (int, int)
        The ids of both bodies, the one that was added first before the other.
    """

    bodies: tuple[int, int]


@dataclass(frozen=True, eq=False, repr=False)
class SceneImpacts(Impacts):
    """Pairs of faces of bodies that meet on the way, and when: `Impacts`, and the `bodies` of each.

    Attributes
    ----------
    bodies : ndarray of int64, shape (n, 2)
        The ids of both bodies; pairs are sorted by these first.
    """

    bodies: npt.NDArray[np.int64]


class Scene:
    """Bodies, each a mesh in a pose, that are added, moved and removed between questions.

    Every vertex is posed into the world, so that `pose` here is ``world_from_body``. What has not moved since the last
    `pairs` or `contacts` is not asked again. Wherever a method takes the id of a body it takes its name too, if that is a str and no
    other body has it.

    Parameters
    ----------
    within : float
        All questions are about pairs at most so far apart in the world, in place of those that intersect, as for `collides`;
        contacts are those of pairs that intersect.

    Examples
    --------
    >>> import numpy as np, pfront as pf
    >>> box, pose = pf.Mesh(*pf._box()), np.eye(4)
    >>> scene = pf.Scene()
    >>> table = scene.add(box, name="table")
    >>> pose[2, 3] = 1  # stands on it
    >>> cup = scene.add(box, pose, name="cup")
    >>> scene.names(scene.intersecting_bodies())
    [['table', 'cup']]
    >>> scene.ignore("table", "cup")
    >>> scene.collides()
    False
    >>> near = pf.Scene(within=0.25)
    >>> pose[2, 3] = 1.25
    >>> _ = near.add(box), near.add(box, pose)
    >>> near.collides(), len(near.contacts())
    (True, 0)
    """

    __slots__ = ("_scene", "_names", "_named")

    def __init__(self, *, within: float = 0.0) -> None:
        self._scene = _pfront.Scene(within)
        self._names: dict[int, Hashable] = {}
        # The ids of the bodies of each name that is a str, which may stand for them.
        self._named: dict[str, set[int]] = {}

    @classmethod
    def from_file(cls, path: Path, *, within: float = 0.0) -> Scene:
        """Make a scene of the bodies of a file, by their names, where its coordinates put them: see `bodies`.

        Examples
        --------
        >>> import pathlib, tempfile, pfront as pf
        >>> path = pathlib.Path(tempfile.mkdtemp(), "two.obj")
        >>> _ = path.write_text("v 0 0 0\\nv 1 0 0\\nv 0 1 0\\no lid\\nf 1 2 3\\no box\\nf 3 2 1\\n")
        >>> scene = pf.Scene.from_file(path)
        >>> scene.names(scene.intersecting_bodies())
        [['lid', 'box']]
        """
        scene = cls(within=within) if within else cls()
        for name, mesh in bodies(path).items():
            scene.add(mesh, name=name)
        return scene

    @classmethod
    def from_trimesh(cls, source: Any, *, within: float = 0.0) -> Scene:
        """Make a scene of the nodes of a ``trimesh.Scene``, by their names, in their poses; nodes of one geometry share its BVH.

        What is no mesh, such as a path or a cloud of points, is left out, with a warning.

        Examples
        --------
        >>> import trimesh, pfront as pf
        >>> box, world = trimesh.creation.box(), trimesh.Scene()
        >>> for name, x in [("left", 0), ("right", 1)]:
        ...     pose = trimesh.transformations.translation_matrix([x, 0, 0])
        ...     _ = world.add_geometry(box, node_name=name, geom_name="box", transform=pose)
        >>> scene = pf.Scene.from_trimesh(world)
        >>> scene.names(scene.intersecting_bodies())
        [['left', 'right']]
        """
        scene = cls(within=within) if within else cls()
        meshes = {name: Mesh(found) for name, found in source.geometry.items() if hasattr(found, "faces")}
        for node in source.graph.nodes_geometry:
            pose, name = source.graph[node]
            if name in meshes:
                scene.add(meshes[name], pose, name=node)
            else:
                warnings.warn(f"{node} is no mesh", stacklevel=2)
        return scene

    @overload
    def add(
        self, mesh: MeshLike, pose: SomePoses, *, name: Hashable = None, user_id: npt.ArrayLike | None = None, itself: bool = False
    ) -> Any: ...
    @overload
    def add(
        self, mesh: MeshLike, pose: OnePose = None, *, name: Hashable = None, user_id: int | None = None, itself: bool = False
    ) -> int: ...
    @overload
    def add(
        self, mesh: MeshLike, pose: Poses, *, name: Hashable = None, user_id: npt.ArrayLike | None = None, itself: bool = False
    ) -> npt.NDArray[np.int64]: ...
    def add(
        self, mesh: MeshLike, pose: Pose = None, *, name: Hashable = None, user_id: npt.ArrayLike | None = None, itself: bool = False
    ) -> Any:
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
        itself : bool
            Whether it is also asked, with all else, whether the body meets itself, as cloth does; its hits have the same
            body twice. What two faces share by index is no contact.

        Returns
        -------
        int or ndarray of int64
            The id of each body: 0, 1, 2, ... in the order of adding; none is ever used again.
        """
        user_ids = None if user_id is None else _user_ids(user_id)
        body = self._scene.add(_mesh(mesh), pose, user_ids, bool(itself))
        if name is not None:
            ids = np.atleast_1d(body).tolist()
            self._names.update(dict.fromkeys(ids, name))
            if isinstance(name, str):
                self._named.setdefault(name, set()).update(ids)
        return body

    def remove(self, body: int | str) -> None:
        """Take a body out; one that is not there raises `StaleBody`."""
        id = _id(self._numbers(body))
        self._scene.remove(id)
        name = self._names.pop(id, None)
        if isinstance(name, str):
            self._named[name].remove(id)
            if not self._named[name]:
                del self._named[name]

    def name(self, body: int) -> Any:
        """The name of a body; None if it was given none."""
        return self._names.get(integer(body, "a body"))

    def names(self, bodies: npt.ArrayLike) -> Any:
        """The names of bodies, in lists of the shape of their ids, as those of `intersecting_bodies`."""

        def named(ids: Any) -> Any:
            return [named(of_one) for of_one in ids] if isinstance(ids, list) else self._names.get(ids)

        return named(_ids(bodies).reshape(np.shape(bodies)).tolist())

    def _numbers(self, bodies: Any) -> Any:
        """Ids in place of names, and everything else as it is."""
        if isinstance(bodies, (list, tuple)) and any(isinstance(body, str) for body in bodies):
            return [self._numbers(body) for body in bodies]
        if not isinstance(bodies, str):
            return bodies
        found = self._named.get(bodies, set())
        if not found:
            raise StaleBody(f"no body of the scene has the name {bodies!r}")
        if len(found) > 1:
            raise ValueError(f"{len(found)} bodies have the name {bodies!r}: give their ids")
        return next(iter(found))

    def _matched(self, body: Any) -> list[int]:
        """The id of a body, or those of all bodies whose names match a pattern that is no name."""
        if not isinstance(body, str) or body in self._named or not set(body) & set("*?"):
            return [_id(self._numbers(body))]
        pattern = re.compile("".join({"*": ".*", "?": "."}.get(letter, re.escape(letter)) for letter in body), re.DOTALL)
        found = [id for name, ids in self._named.items() if pattern.fullmatch(name) for id in ids]
        if not found:
            raise StaleBody(f"no body of the scene has a name like {body!r}")
        return found

    def user_ids(self, bodies: npt.ArrayLike) -> npt.NDArray[np.int64]:
        """Look up the numbers that `add` was given for bodies; by default a body has its id.

        Parameters
        ----------
        bodies : int, or array_like of any shape
            Ids, as those of `intersecting_bodies` or of ``Hits.bodies``.

        Examples
        --------
        >>> import numpy as np, pfront as pf
        >>> scene, box = pf.Scene(), pf.Mesh(*pf._box())
        >>> _ = scene.add(box, np.tile(np.eye(4), (2, 1, 1)), user_id=[70, 71])
        >>> scene.user_ids(scene.intersecting_bodies())
        array([[70, 71]])
        """
        numbers = self._numbers(bodies)
        return self._scene.user_ids(_ids(numbers).reshape(-1)).reshape(np.shape(numbers))

    def set_poses(self, bodies: npt.ArrayLike, poses: Pose) -> None:
        """Move bodies; body ``bodies[i]`` to ``poses[i]``.

        Raises
        ------
        StaleBody, PoseError
            With the index in ``.pose``; bodies before it have moved.
        """
        self._scene.set_poses(_ids(self._numbers(bodies)), poses)

    def set_mesh(self, body: int | str, mesh: MeshLike) -> None:
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
        self._scene.set_model(_id(self._numbers(body)), _mesh(mesh))

    def ignore(self, a: int | str, b: int | str, ignored: bool = True) -> None:
        """Ignore what two bodies do to each other, as links of a joint that overlap by design; or no longer.

        A pattern stands for every body whose name it matches: ``*`` is any text and ``?`` any character.

        Examples
        --------
        >>> import pfront as pf
        >>> scene, box = pf.Scene(), pf.Mesh(*pf._box())
        >>> for name in ("bolt 1", "bolt 2", "plate"):
        ...     _ = scene.add(box, name=name)
        >>> scene.ignore("bolt*", "plate")
        >>> scene.names(scene.intersecting_bodies())
        [['bolt 1', 'bolt 2']]
        """
        for one in self._matched(a):
            for other in self._matched(b):
                self._scene.ignore(one, other, ignored)

    def __len__(self) -> int:
        return self._scene.len()

    def _across(self, other: Scene, may_touch: bool) -> tuple[Scene, int]:
        """A scene of the bodies of both in which only those of different scenes are asked about, with their ids as user ids; and how
        many of the first come first in it: those that may touch one of the other scene, or all that have faces."""
        both = Scene()
        both._scene, count = self._scene.across(other._scene, may_touch)
        return both, count

    def __reduce_ex__(self, protocol: Any) -> NoReturn:
        raise TypeError("a scene is neither copied nor pickled: add its bodies to a new one")

    def __repr__(self) -> str:
        return f"Scene({len(self)} bodies)"

    def pairs(self) -> Hits:
        """List the pairs of triangles of different bodies that meet."""
        return Hits(*self._scene.pairs(current()))

    def intersecting_bodies(self) -> npt.NDArray[np.int64]:
        """List the pairs of bodies that meet, (n, 2); each two are asked until their first hit, which takes far less."""
        return self._scene.intersecting_bodies(current())

    def contacts(self) -> SceneContacts:
        """Find where bodies meet, in the world: in float64 if some body is, else in float32."""
        bodies, found = self._scene.contacts(current())
        return SceneContacts(*found, bodies)

    def impacts(self, bodies: npt.ArrayLike, poses: Pose) -> SceneImpacts:
        """Find the faces of bodies that meet while some of these move, and when: body ``bodies[i]`` goes to ``poses[i]``.

        All others stay where they are, and the scene is the same afterwards. Every vertex goes in a straight line, from its place at time 0 to
        that at time 1, also where a pose turns. No pair is missed. In a ``Scene(within=d)`` pairs are those that come so near on the way.

        Parameters
        ----------
        bodies : id or name, or array_like of these
            Those that move, each once.
        poses
            The pose of each at time 1, as for `set_poses`; at time 0 they are where they are.

        Returns
        -------
        SceneImpacts
            Pairs, sorted, with the time before which each does not meet and that before which it certainly does. CPUs answer.

        Raises
        ------
        StaleBody, PoseError
            If a body is not there, or a pose is not finite.
        ValueError
            If a body is given twice, or there are not as many poses as bodies.

        Examples
        --------
        >>> import numpy as np, pfront as pf
        >>> box, pose = pf.Mesh(*pf._box()), np.eye(4)
        >>> scene = pf.Scene()
        >>> for name, x in [("arm", 0), ("wall", 2), ("door", 5)]:
        ...     pose[0, 3] = x
        ...     _ = scene.add(box, pose, name=name)
        >>> pose[0, 3] = 4  # through the wall, up to the door
        >>> found = scene.impacts("arm", pose)
        >>> scene.names(np.unique(found.bodies, axis=0))
        [['arm', 'wall'], ['arm', 'door']]
        >>> first = scene.first_impact("arm", pose)
        >>> scene.names(first.bodies), first.start <= 0.25 <= first.end
        (['arm', 'wall'], True)
        >>> low, high = scene.count_impacts("arm", pose)
        >>> high == len(found), low == int(found.proven.sum()), scene.any_impact("arm", pose).proven
        (True, True, True)
        """
        found, pairs, start, end = _pfront.scene_impacts(self._scene, self._moving(bodies, poses), current())
        return SceneImpacts(pairs, start, end, found)

    def first_impact(self, bodies: npt.ArrayLike, poses: Pose) -> SceneImpact | None:
        """Find the faces that meet first while bodies move, by the time, then by the bodies and the pair; all else as for `impacts`."""
        return _impact(_pfront.scene_first_impact(self._scene, self._moving(bodies, poses), current()))

    def any_impact(self, bodies: npt.ArrayLike, poses: Pose) -> SceneImpact | None:
        """Find some faces that meet while bodies move, and stop at the first that certainly do; all else as for `impacts`.

        It is proven if any of `impacts` is. Other numbers of threads may find another.
        """
        return _impact(_pfront.scene_any_impact(self._scene, self._moving(bodies, poses), current()))

    def count_impacts(self, bodies: npt.ArrayLike, poses: Pose) -> tuple[int, int]:
        """Count the pairs of `impacts`: how many are proven, and how many there are. No list is kept."""
        return _pfront.scene_count_impacts(self._scene, self._moving(bodies, poses), current())

    def _moving(self, bodies: Any, poses: Pose) -> tuple[npt.NDArray[np.uint64], Pose]:
        return _ids(self._numbers(bodies)), poses

    def distance(self, body: int | str, *, limit: float | None = None) -> tuple[int, Gap] | None:
        """Find the body that is nearest to one, and their smallest distance in the world, 0 if they intersect.

        Bodies that are ignored beside it are left out; of bodies that are equally near the one that was added first is told.

        Parameters
        ----------
        body : int or str
            Its faces are the first of ``Gap.pair``.
        limit : float, optional
            As for `pfront.distance`: farther bodies are left out.

        Returns
        -------
        (int, Gap) or None
            The id of the other body; None if there is none with faces, or none so near.

        Examples
        --------
        >>> import numpy as np, pfront as pf
        >>> box, pose = pf.Mesh(*pf._box()), np.eye(4)
        >>> scene = pf.Scene()
        >>> for name, z in [("floor", 0), ("lamp", 2.5), ("roof", 4)]:
        ...     pose[2, 3] = z
        ...     _ = scene.add(box, pose, name=name)
        >>> nearest, gap = scene.distance("lamp")
        >>> scene.name(nearest), round(gap.distance, 6)
        ('roof', 0.5)
        >>> print(scene.distance("floor", limit=1))
        None
        """
        found = self._scene.distance(_id(self._numbers(body)), limit, current())
        gap = None if found is None else Gaps(*found[1])[0]
        return None if found is None or gap is None else (found[0], gap)

    def segment(self, start: Any, end: Any) -> tuple[npt.NDArray[np.int64], npt.NDArray[np.uint32], npt.NDArray[np.float64]]:
        """Find all faces that the segment between two points of the world meets, exactly. Touching counts.

        Parameters
        ----------
        start, end : array_like, shape (3,)
            The points; taken as float64. Each body is asked as it is posed, in the precision of its mesh and its pose.

        Returns
        -------
        bodies : ndarray of int64, shape (h,)
            The bodies, sorted.
        faces : ndarray of uint32, shape (h,)
            The face of each hit, sorted within a body.
        at : ndarray of float64, shape (h,)
            Where the first point in common is, from 0 at the start to 1 at the end, rounded.

        Examples
        --------
        >>> import numpy as np, pfront as pf
        >>> box, pose = pf.Mesh(*pf._box()), np.eye(4)
        >>> scene = pf.Scene()
        >>> for name, x in [("near", 0), ("far", 2)]:
        ...     pose[0, 3] = x
        ...     _ = scene.add(box, pose, name=name)
        >>> bodies, faces, at = scene.segment([-1, 0.1, 0.2], [3, 0.1, 0.2])
        >>> scene.names(bodies), faces.tolist(), at.tolist()
        (['near', 'near', 'far', 'far'], [0, 3, 0, 3], [0.125, 0.375, 0.625, 0.875])
        """
        bodies, (faces, at) = self._scene.segment(_ends(start, end), current())
        return bodies, faces, at

    def segment_first(self, start: Any, end: Any) -> tuple[int, int, float] | None:
        """Find the first face along the segment from one point of the world to another, exactly: its body, its number, and where.

        Of faces that it meets in one point, that of the body that was added first is told, and of its faces the one with the lowest number.

        Examples
        --------
        >>> import numpy as np, pfront as pf
        >>> scene, box = pf.Scene(), pf.Mesh(*pf._box())
        >>> body = scene.add(box)
        >>> scene.segment_first([3, 0.1, 0.2], [-1, 0.1, 0.2]) == (body, 3, 0.625)
        True
        >>> print(scene.segment_first([3, 0.1, 0.2], [1, 0.1, 0.2]))
        None
        """
        return self._scene.segment_first(_ends(start, end), current())

    def inside(self, point: Any) -> dict[int, Literal["inside", "surface"] | NotSolid]:
        """Find the bodies that contain a point of the world, exactly, by winding numbers.

        Parameters
        ----------
        point : array_like, shape (3,)
            The point; taken as float64.

        Returns
        -------
        dict
            Whether it is inside or on the surface, by the ids of the bodies that contain it, in the order of adding. Then why there is
            no answer, by the ids of those whose box contains it and whose mesh is open.

        Examples
        --------
        >>> import numpy as np, pfront as pf
        >>> scene, box = pf.Scene(), pf.Mesh(*pf._box())
        >>> near, lid = scene.add(box), scene.add((box.vertices, box.faces[:-1]))
        >>> found = scene.inside([0, 0.5, 0])
        >>> found[near], found[lid].face
        ('surface', 0)
        >>> scene.remove(lid)
        >>> scene.inside([0, 0, 0]) == {near: "inside"}, scene.inside([0, 0, 1])
        (True, {})
        """
        containing, refused = self._scene.inside(_point(point, "point"), current())
        words: tuple[Any, Literal["inside"], Literal["surface"]] = (None, "inside", "surface")
        return {**{body: words[code] for body, code in containing}, **dict(refused)}

    def check(self, *, allow: Iterable[Relation] = (), allow_overlap: float = 0.0, patches: bool = False) -> CheckReport:
        """Tell what all bodies whose boxes overlap are to each other, and whether that is allowed: is this assembly right?

        Bodies are solids here, as for `pfront.relation`; one that is none is told of. In a ``Scene(within=d)`` those that are apart, and at
        most so far, are near. Two that are turned alike and flush stay flush: each pair is asked in the frame of the first.

        Parameters
        ----------
        allow : iterable of str
            Relations that are allowed, beside apart and touching.
        allow_overlap : float
            The largest volume by which bodies that cross may overlap.
        patches : bool
            Whether contacts are measured too: see `CheckedPair`.

        Returns
        -------
        CheckReport
            Its ``allowed`` is whether all is; its ``pairs`` have the relation, the volume in common or the gap, and a place.

        Raises
        ------
        ValueError
            If a word is no relation, or the volume is negative or NaN.

        Examples
        --------
        >>> import numpy as np, pfront as pf
        >>> box, pose = pf.Mesh(*pf._box()), np.eye(4)
        >>> scene = pf.Scene(within=0.5)
        >>> for name, x in [("lid", 0), ("jar", 0.75), ("box", 1.75), ("tin", 3)]:
        ...     pose[0, 3] = x
        ...     _ = scene.add(box, pose, name=name)
        >>> report = scene.check(allow=["near"])
        >>> report, report.counts
        (CheckReport(3 pairs, 1 not allowed), {'crossing': 1, 'touching': 1, 'near': 1})
        >>> [clash] = [pair for pair in report.pairs if not pair.allowed]
        >>> low, high = clash.overlap_volume
        >>> clash.names, clash.relation, low <= 0.25 <= high
        (('lid', 'jar'), 'crossing', True)
        >>> scene.check(allow=["near"], allow_overlap=0.3).allowed
        True
        >>> touching = scene.check(patches=True).pairs[1]
        >>> low, high = touching.contact.area
        >>> touching.names, touching.contact.dimension, low <= 1 <= high
        (('jar', 'box'), 2, True)
        """
        if not allow_overlap >= 0:
            raise ValueError(f"a volume of {allow_overlap} cannot be allowed")
        pairs, refused = self._scene.check(list(allow), allow_overlap, bool(patches), current())
        name = self._names.get
        found = [
            CheckedPair(bodies, (name(bodies[0]), name(bodies[1])), *rest[:4], rest[4] and ContactSize(*rest[4]), *rest[5:])
            for bodies, rest in pairs
        ]
        return CheckReport(found, dict(refused))

    def show(self, *, off_screen: bool = False, screenshot: Any = None) -> SceneContacts:
        """Draw the bodies, those that meet in another colour, and in red where they do; as `pfront.show`."""
        from ._show import draw  # which loads no pyvista before it draws

        found = self.contacts()
        marked = np.unique(found.bodies)
        placed = [(Mesh(model), np.array(pose), bool((marked == id).any())) for id, model, pose in self._scene.bodies()]
        draw(placed, found, off_screen, screenshot)
        return found

    def count(self) -> int:
        """Count the pairs of triangles that meet."""
        return self._scene.count(current())

    def collides(self) -> bool:
        """Whether any two bodies meet."""
        return self._scene.any(current())


def check(
    source: Path | Mapping[str, MeshLike], *, within: float = 0.0, ignore: Iterable[tuple[str, str]] = (),
    allow: Iterable[Relation] = (), allow_overlap: float = 0.0, patches: bool = False,
) -> CheckReport:  # fmt: skip
    """Check an assembly, as ``pfront check``, the command, does: what its bodies are to each other, and whether that is allowed.

    Parameters
    ----------
    source : path, or dict of str to Mesh
        A file, whose bodies are asked about (see `bodies`), or bodies by their names.
    within : float
        Bodies that are apart, and at most so far, are near.
    ignore : iterable of (str, str)
        Pairs of names or patterns that are left out: see `Scene.ignore`.
    allow, allow_overlap, patches
        As for `Scene.check`.

    Examples
    --------
    >>> import pfront as pf
    >>> vertices, faces = pf._box()
    >>> parts = {"lid": (vertices, faces), "bolt 1": (vertices, faces[1:])}
    >>> report = pf.check(parts)
    >>> report.allowed, report.counts, str(report.refused[1])
    (False, {'undetermined': 1}, 'edge 0 of triangle 0 is open: an odd number of triangles have it')
    >>> pf.check(parts, ignore=[("bolt*", "*")]).pairs
    []
    """
    if isinstance(source, Mapping):
        scene = Scene(within=within)
        for name, mesh in source.items():
            scene.add(mesh, name=name)
    else:
        scene = Scene.from_file(source, within=within)
    for two in ignore:
        if isinstance(two, str) or len(two) != 2:
            raise TypeError(f"{two!r} is no pair of names or patterns to ignore")
        scene.ignore(*two)
    return scene.check(allow=allow, allow_overlap=allow_overlap, patches=patches)


def _mesh(mesh: MeshLike) -> _pfront.Model:
    return mesh._model if isinstance(mesh, Mesh) else Mesh(mesh)._model


def _stale(id: int, at: int | None = None) -> StaleBody:
    """The error of an id that no body can have."""
    error = StaleBody(f"body {id} is not in the scene: ids are 0 and more, in the order of adding")
    error.pose = at
    return error


def _impact(found: tuple[list[int], tuple[int, int], float, float] | None) -> SceneImpact | None:
    if found is None:
        return None
    (a, b), pair, start, end = found
    return SceneImpact(pair, start, end, (a, b))


def _ends(start: Any, end: Any) -> tuple[tuple[float, float, float], tuple[float, float, float]]:
    return _point(start, "start"), _point(end, "end")


def _id(body: Any) -> int:
    """The id of a body; one that none can have is refused as one that is not there."""
    id = integer(body, "the id of a body")
    if not 0 <= id < 2**63:
        raise _stale(id)
    return id


def _integers(numbers: Any) -> npt.NDArray[Any]:
    found = np.atleast_1d(array(numbers, "ids are"))
    if found.size and found.dtype.kind not in "iu":
        # A list of integers that no dtype holds becomes one of objects, or of float64.
        exact = np.atleast_1d(np.array(numbers, object)) if isinstance(numbers, (int, list, tuple)) else found
        if not all(isinstance(number, (int, np.integer)) and not isinstance(number, bool) for number in exact.flat):
            raise TypeError(f"ids of dtype {found.dtype} are no integers")
        return exact
    return found


def _beyond(numbers: npt.NDArray[Any]) -> npt.NDArray[np.bool_]:
    """Which numbers are above int64. None that a signed dtype holds is, and no dtype compares with one that is."""
    if numbers.dtype.kind in "if":
        return np.zeros(numbers.shape, bool)
    return numbers > (np.uint64(2**63 - 1) if numbers.dtype.kind == "u" else 2**63 - 1)


def _ids(bodies: Any) -> npt.NDArray[np.uint64]:
    """Ids of bodies, in an array that is aligned and in C order."""
    found = _integers(bodies)
    wrong = (found < 0) | _beyond(found)
    if wrong.any():
        at = int(np.argmax(wrong))
        raise _stale(int(found.flat[at]), at)
    return np.require(found, np.uint64, ("C", "A"))


def _user_ids(numbers: Any) -> npt.NDArray[np.int64]:
    """Numbers of the user's own, in an array that is aligned and in C order."""
    found = _integers(numbers)
    wrong = _beyond(found) | (found < -(2**63)) if found.dtype.kind == "O" else _beyond(found)
    if wrong.any():
        raise ValueError(f"user id {found.flat[int(np.argmax(wrong))]} does not fit in int64")
    return np.require(found, np.int64, ("C", "A"))
