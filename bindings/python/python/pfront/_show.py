"""Pictures, by pyvista, and its accessor: ``mesh.pfront.collides(other)``."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

from . import _questions
from ._errors import PoseError
from ._mesh import Mesh, MeshLike
from ._poses import OnePose, Pose, matrix
from ._questions import Contacts

__all__ = ["show", "Accessor", "register"]


def _pyvista() -> Any:
    try:
        import pyvista
    except ImportError:
        raise ImportError("pictures need pyvista: pip install pyvista") from None
    return pyvista


def show(
    a: MeshLike, b: MeshLike | None = None, pose: OnePose = None, *, off_screen: bool = False, screenshot: Any = None
) -> Contacts:
    """Draw two meshes, or one, and in red where they meet; pyvista draws.

    Parameters
    ----------
    a, b, pose
        As for `contacts`; one pose.
    off_screen : bool
        Without a window.
    screenshot : path, optional
        The picture to write.

    Returns
    -------
    Contacts
        What is drawn in red.
    """
    found = _questions.contacts(a, b, pose)
    if not isinstance(found, Contacts):
        raise PoseError("a picture shows one pose")
    placed = [(a if isinstance(a, Mesh) else Mesh(a), np.eye(3, 4), False)]
    if b is not None:
        a_from_b = np.eye(3, 4) if pose is None else matrix(pose)
        placed.append((b if isinstance(b, Mesh) else Mesh(b), a_from_b, True))
    draw(placed, found, off_screen, screenshot)
    return found


def draw(placed: list[tuple[Mesh, npt.NDArray[Any], bool]], found: Contacts, off_screen: bool, screenshot: Any) -> None:
    """Draw meshes in their poses, in one of two colours, and in red the segments of contacts."""
    pyvista = _pyvista()
    plotter = pyvista.Plotter(off_screen=off_screen)
    for mesh, pose, is_marked in placed:
        points = mesh.vertices @ pose[:3, :3].T + pose[:3, 3]
        surface = pyvista.PolyData.from_regular_faces(points, mesh.faces)
        plotter.add_mesh(surface, color="wheat" if is_marked else "lightsteelblue", opacity=0.6)
    for line in found.polylines():
        plotter.add_mesh(pyvista.MultipleLines(points=line), color="red", line_width=6, lighting=False)
    plotter.show(screenshot=screenshot)
    plotter.close()


class Accessor:
    """``polydata.pfront``: the questions of pfront about a mesh of pyvista, whose BVH is built once."""

    def __init__(self, polydata: Any) -> None:
        self._polydata = polydata
        self._known: tuple[int, Mesh] | None = None

    @property
    def mesh(self) -> Mesh:
        """The mesh; built anew when that of pyvista has changed."""
        time = self._polydata.GetMTime()
        if self._known is None or self._known[0] != time:
            self._known = (time, Mesh(self._polydata))
        return self._known[1]

    def collides(self, other: Any = None, pose: Pose = None, *, within: float = 0.0) -> Any:
        """As `pfront.collides`."""
        return _questions.collides(self.mesh, other, pose, within=within)

    def count(self, other: Any = None, pose: Pose = None, *, within: float = 0.0) -> Any:
        """As `pfront.count`."""
        return _questions.count(self.mesh, other, pose, within=within)

    def pairs(self, other: Any = None, pose: Pose = None, *, within: float = 0.0) -> Any:
        """As `pfront.pairs`."""
        return _questions.pairs(self.mesh, other, pose, within=within)

    def contacts(self, other: Any = None, pose: Pose = None) -> Any:
        """As `pfront.contacts`."""
        return _questions.contacts(self.mesh, other, pose)

    def distance(self, other: Any, pose: Pose = None, *, limit: float | None = None) -> Any:
        """As `pfront.distance`."""
        return _questions.distance(self.mesh, other, pose, limit=limit)

    def relation(self, other: Any, pose: Pose = None, *, within: float = 0.0) -> Any:
        """As `pfront.relation`."""
        return _questions.relation(self.mesh, other, pose, within=within)

    def overlap_volume(self, other: Any, pose: Pose = None) -> Any:
        """As `pfront.overlap_volume`."""
        return _questions.overlap_volume(self.mesh, other, pose)


def register() -> None:
    """Give every PolyData of pyvista the attribute ``pfront``."""
    pyvista = _pyvista()
    if "pfront" in vars(pyvista.PolyData):
        return

    def accessor(polydata: Any) -> Accessor:
        found: Accessor | None = polydata.__dict__.get("_pfront")
        if found is None:
            found = Accessor(polydata)
            object.__setattr__(polydata, "_pfront", found)
        return found

    setattr(pyvista.PolyData, "pfront", property(accessor))
