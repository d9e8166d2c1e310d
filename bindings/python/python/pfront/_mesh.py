"""Meshes, made of whatever holds vertices and faces."""

from __future__ import annotations

import hashlib
import os
import pickle
import weakref
from functools import cached_property
from typing import Any

import numpy as np
import numpy.typing as npt

from . import _pfront
from ._errors import MeshError
from ._settings import current

__all__ = ["Mesh", "load"]

_unpickled: weakref.WeakValueDictionary[bytes, Mesh] = weakref.WeakValueDictionary()


class Mesh:
    """A triangle mesh with its BVH, which is built here and never changes; `with_vertices` makes another of one that deforms.

    Parameters
    ----------
    source : array_like, path or mesh
        Vertices of shape (n, 3); or a path (``.pfb``, or whatever meshio or trimesh reads); or a mesh of trimesh, pyvista,
        Open3D or meshio; or a pair (vertices, faces).
    faces : array_like, optional
        Integers of shape (m, 3), which name vertices. Only with vertices.

    Notes
    -----
    Arrays may be in C or Fortran order, strided, misaligned, read-only or of the other byte order; they are copied. A mesh is
    float64 if some coordinate is not a float32 number, so the numbers that you give are the numbers that are tested.

    Threads and processes may share one: it is immutable, and pickles out of band (protocol 5).

    Raises
    ------
    MeshError
        With ``.vertex`` or ``.face``, if a coordinate is NaN or infinite, or a face names a vertex that there is not.

    Examples
    --------
    >>> import pfront as pf
    >>> pf.Mesh([[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 1, 2]])
    Mesh(3 vertices, 1 face, float32)
    >>> pf.Mesh([[0, 0, 0], [1, 0, 0], [0, 1, 0.1]], [[0, 1, 2]]).dtype
    dtype('float64')
    """

    __slots__ = ("__dict__", "__weakref__", "_model")
    _model: _pfront.Model

    def __init__(self, source: Any, faces: npt.ArrayLike | None = None) -> None:
        if faces is None:
            source, faces = _parts(source)
        if isinstance(source, _pfront.Model):
            self._model = source
        else:
            self._model = _model(source, faces)

    @cached_property
    def vertices(self) -> npt.NDArray[Any]:
        """The positions that are tested: read-only, (n, 3), float32 or float64."""
        return _read_only(self._model.vertices())

    @cached_property
    def faces(self) -> npt.NDArray[np.uint32]:
        """The corners of faces: read-only, (m, 3), uint32."""
        return _read_only(self._model.faces())

    @property
    def dtype(self) -> np.dtype[Any]:
        """The precision in which the mesh is tested."""
        return np.dtype(np.float64 if self._model.is_f64() else np.float32)

    @property
    def nbytes(self) -> int:
        """Bytes of memory that the mesh and its BVH take, without `vertices` and `faces` if these were looked at."""
        return self._model.nbytes()

    def with_vertices(self, vertices: npt.ArrayLike) -> Mesh:
        """Return this mesh with its vertices elsewhere, as of a cloth a frame later: the BVH is refitted, not built.

        Parameters
        ----------
        vertices : array_like, shape (n, 3)
            As many as there are. A mesh of float32 becomes one of float64, once and by a new BVH, if some coordinate is not a
            float32 number; one of float64 stays that.

        Examples
        --------
        >>> import pfront as pf
        >>> sheet = pf.Mesh([[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 1, 2]])
        >>> fallen = sheet.with_vertices(sheet.vertices - [0, 0, 2])
        >>> fallen.vertices[0].tolist(), pf.collides(sheet, fallen)
        ([0.0, 0.0, -2.0], False)
        """
        points = _points(vertices)
        own = self._model.counts()[0]
        if len(points) != own:
            raise MeshError(f"{len(points)} vertices are not the {own} of this mesh")
        return Mesh(self._model.with_vertices(points, current()))

    def save(self, path: str | os.PathLike[str]) -> None:
        """Write the mesh and its BVH as a ``.pfb``, which `load` reads without building the BVH anew.

        Parameters
        ----------
        path : path
            The file; one that is there is replaced.
        """
        with open(path, "wb") as file:
            file.write(self._model.to_blob())

    def __repr__(self) -> str:
        vertices, faces = self._model.counts()
        return f"Mesh({vertices} vert{'ex' if vertices == 1 else 'ices'}, {faces} face{'' if faces == 1 else 's'}, {self.dtype})"

    def __reduce_ex__(self, protocol: Any) -> tuple[Any, ...]:
        blob = self._blob
        digest = self._digest
        if protocol >= 5:
            return _from_blob, (digest, pickle.PickleBuffer(blob))
        return _from_blob, (digest, blob)

    @cached_property
    def _blob(self) -> bytes:
        return self._model.to_blob()

    @cached_property
    def _digest(self) -> bytes:
        return hashlib.blake2b(self._blob, digest_size=16).digest()


def load(path: str | os.PathLike[str]) -> Mesh:
    """Read a ``.pfb``, as `Mesh.save` and the command ``pfront bake`` write it. Nothing in it is trusted.

    Parameters
    ----------
    path : path
        The file.

    Returns
    -------
    Mesh
        The mesh, with the BVH of the file.

    Raises
    ------
    BlobError
        If the file is no .pfb, or has changed since it was written.
    """
    return Mesh(_pfront.Model.from_blob(np.fromfile(path, np.uint8)))


def _from_blob(digest: bytes, blob: Any) -> Mesh:
    """A mesh out of a pickle; one that is still there is not read again."""
    found = _unpickled.get(digest)
    if found is None:
        bytes_ = np.frombuffer(blob, np.uint8)
        found = _unpickled.setdefault(digest, Mesh(_pfront.Model.from_blob(np.require(bytes_, requirements=("C", "A")))))
    return found


def _read_only(array: npt.NDArray[Any]) -> npt.NDArray[Any]:
    array.flags.writeable = False
    return array


def _points(vertices: Any) -> npt.NDArray[Any]:
    """Vertices in an aligned array of float32 or float64, in C order."""
    points = np.asarray(vertices)
    if points.dtype.kind not in "fiub" or points.dtype.itemsize > 8:
        raise TypeError(f"vertices of dtype {points.dtype} are no real numbers of at most 64 bits")
    if points.ndim != 2 or points.shape[1] != 3:
        raise MeshError(f"vertices of shape {points.shape} are not (n, 3)")
    if points.dtype.kind in "iu" and points.dtype.itemsize == 8 and points.size:
        if max(abs(int(points.min())), abs(int(points.max()))) > 2**53:
            raise TypeError("vertices are integers beyond 2^53, which float64 does not hold")
    kind = np.float32 if points.dtype.kind == "f" and points.dtype.itemsize <= 4 else np.float64
    return np.require(points, kind, ("C", "A"))


def _model(vertices: Any, faces: Any) -> _pfront.Model:
    points = _points(vertices)
    corners = _corners(np.asarray(faces))
    make = _pfront.Model.from_f32 if points.dtype == np.float32 else _pfront.Model.from_f64
    return make(points, corners, current())


def _corners(faces: npt.NDArray[Any]) -> npt.NDArray[np.uint32]:
    if faces.size == 0:
        return np.empty((0, 3), np.uint32)
    if faces.dtype.kind not in "iu":
        raise TypeError(f"faces of dtype {faces.dtype} are no integers")
    if faces.ndim != 2 or faces.shape[1] != 3:
        raise MeshError(f"faces of shape {faces.shape} are not (m, 3): triangulate first")
    if faces.dtype != np.uint32:
        wrong = (faces < 0) | (faces > np.iinfo(np.uint32).max) if faces.dtype.kind == "i" else faces > np.iinfo(np.uint32).max
        if wrong.any():
            face, corner = (int(i) for i in np.argwhere(wrong)[0])
            error = MeshError(f"face {face} names vertex {faces[face, corner]}")
            error.face = face
            raise error
    return np.require(faces, np.uint32, ("C", "A"))


def _parts(source: Any) -> tuple[Any, Any]:
    """Vertices and faces of a mesh of another library, or a model."""
    if isinstance(source, _pfront.Model):
        return source, None
    if isinstance(source, Mesh):
        return source._model, None
    if isinstance(source, (str, os.PathLike)):
        return _file(os.fspath(source))
    if isinstance(source, (tuple, list)) and len(source) == 2:
        return source[0], source[1]
    if hasattr(type(source), "regular_faces"):
        # pyvista; quads are (n, 4) there until they are triangulated.
        triangles = source if source.is_all_triangles else source.triangulate()
        return triangles.points, triangles.regular_faces
    if hasattr(source, "cells_dict") and hasattr(source, "points"):
        found = [_halves(kind, cells) for kind, cells in source.cells_dict.items()]
        return source.points, np.concatenate([cells for cells in found if cells is not None] or [np.empty((0, 3), np.int64)])
    if hasattr(source, "vertices") and hasattr(source, "faces"):
        return source.vertices, source.faces
    if hasattr(source, "vertices") and hasattr(source, "triangles"):
        # Open3D; trimesh has triangles too, which are points.
        return np.asarray(source.vertices), np.asarray(source.triangles)
    if hasattr(source, "vertex") and hasattr(source, "triangle"):
        return source.vertex.positions.cpu().numpy(), source.triangle.indices.cpu().numpy()
    if isinstance(source, np.ndarray):
        raise TypeError(f"an array of shape {source.shape} is no mesh: give vertices and faces, as pf.Mesh(vertices, faces)")
    raise TypeError(
        f"{type(source).__name__} is no mesh: give (vertices, faces), a path, or a mesh of trimesh, pyvista, Open3D or meshio"
    )


def _halves(kind: str, cells: Any) -> Any:
    """The triangles of cells of one kind; None for points and lines."""
    if kind == "triangle":
        return cells
    if kind == "quad":
        return cells[:, [0, 1, 2, 0, 2, 3]].reshape(-1, 3)
    if kind in ("vertex", "line"):
        return None
    raise MeshError(f"cells of the kind {kind!r} are no triangles: take the surface first")


def _file(path: str) -> tuple[Any, Any]:
    if path.lower().endswith(".pfb"):
        return load(path)._model, None
    if not os.path.exists(path):
        raise FileNotFoundError(path)
    try:
        import trimesh
    except ImportError:
        raise ImportError(f"to read {path!r}, install trimesh: pip install trimesh") from None
    found = trimesh.load(path, process=False, force="mesh")
    return _parts(found)
