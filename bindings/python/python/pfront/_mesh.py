"""Meshes, made of whatever holds vertices and faces."""

from __future__ import annotations

import copy
import errno
import hashlib
import os
import pickle
import secrets
import stat
import warnings
import weakref
from collections.abc import Callable
from contextlib import suppress
from typing import Any, Protocol, TypeVar, Union, overload

import numpy as np
import numpy.typing as npt

from . import _pfront
from ._arrays import array
from ._errors import MeshError
from ._settings import current

__all__ = ["Mesh", "bodies", "load"]


class _Trimesh(Protocol):
    vertices: Any
    faces: Any


class _Open3d(Protocol):
    vertices: Any
    triangles: Any


class _PolyData(Protocol):
    points: Any
    regular_faces: Any


Path = Union[str, bytes, "os.PathLike[str]", "os.PathLike[bytes]"]
# What `Mesh` takes. Meshes of meshio have no types.
MeshLike = Union["Mesh", Path, tuple[Any, Any], _Trimesh, _Open3d, _PolyData, _pfront.Model]
_unpickled: weakref.WeakValueDictionary[bytes, Mesh] = weakref.WeakValueDictionary()
_Kind = TypeVar("_Kind", bound="Mesh")
# What is made of the model when it is first asked for.
_CACHED = ("vertices", "faces", "_digest")


class Mesh:
    """A triangle mesh with its BVH, which is built here and never changes; `with_vertices` makes another of one that deforms.

    Parameters
    ----------
    source : array_like, path or mesh
        Vertices of shape (n, 3); or a path of a file, which is read as the command reads it (OBJ, PLY, STL, OFF, glTF, 3MF,
        ``.pfb``); or a mesh of trimesh, pyvista, Open3D or meshio; or a pair (vertices, faces).
    faces : array_like, optional
        Integers of shape (m, 3), which name vertices. Only with vertices.

    Notes
    -----
    Arrays may be in C or Fortran order, strided, misaligned, read-only or of the other byte order; they are copied. A mesh is
    float64 if some coordinate is not a float32 number, so the numbers that you give are the numbers that are tested.

    Threads and processes may share one: it is immutable, and pickles out of band (protocol 5). Copies share the BVH.

    Warns
    -----
    UserWarning
        If there are no faces: such a mesh intersects nothing. If something in a file was passed over.

    Raises
    ------
    MeshError
        With ``.vertex`` or ``.face``, if a coordinate is NaN or infinite, or a face names a vertex that there is not. If a file
        is not what its name says, or has no face.

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

    @overload
    def __init__(self, source: MeshLike, faces: None = None) -> None: ...
    @overload
    def __init__(self, source: npt.ArrayLike, faces: npt.ArrayLike) -> None: ...
    def __init__(self, source: Any, faces: npt.ArrayLike | None = None) -> None:
        if faces is None:
            source, faces = _parts(source)
        if isinstance(source, _pfront.Model):
            self._model = source
        else:
            self._model = _model(source, faces)
            _warn_if_empty(self._model)

    @property
    def vertices(self) -> npt.NDArray[Any]:
        """The positions that are tested: read-only, (n, 3), float32 or float64."""
        return self._kept("vertices", self._model.vertices)

    @property
    def faces(self) -> npt.NDArray[np.uint32]:
        """The corners of faces: read-only, (m, 3), uint32."""
        return self._kept("faces", self._model.faces)

    def _kept(self, name: str, make: Callable[[], npt.NDArray[Any]]) -> npt.NDArray[Any]:
        """An array that is made once. `functools.cached_property` has a lock before Python 3.12, which a fork may catch locked."""
        found: npt.NDArray[Any] | None = self.__dict__.get(name)
        return self.__dict__.setdefault(name, _read_only(make())) if found is None else found

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
            The file; one that is there is replaced as soon as all is written, and stays as it is if that fails.
        """
        _replace(path, self._model.to_blob())

    def __repr__(self) -> str:
        vertices, faces = self._model.counts()
        return f"Mesh({vertices} vert{'ex' if vertices == 1 else 'ices'}, {faces} face{'' if faces == 1 else 's'}, {self.dtype})"

    def __reduce_ex__(self, protocol: Any) -> tuple[Any, ...]:
        blob = self._model.to_blob()
        # The digest is kept, the blob is not.
        digest = self.__dict__.setdefault("_digest", hashlib.blake2b(blob, digest_size=16).digest())
        state = self._state()
        kind = type(self) if type(self) is not Mesh or state is not None else None
        return _from_blob, (digest, pickle.PickleBuffer(blob) if protocol >= 5 else blob, kind), state

    def __copy__(self: _Kind) -> _Kind:
        return _made(type(self), self._model, self._state())

    def __deepcopy__(self: _Kind, memo: dict[int, Any]) -> _Kind:
        return _made(type(self), self._model, copy.deepcopy(self._state(), memo))

    def _state(self) -> Any:
        """The attributes that users or subclasses have added, as pickle knows them; None without any."""
        state = super().__reduce_ex__(2)[2]
        if not (isinstance(state, tuple) and len(state) == 2 and isinstance(state[1], dict)):
            return state  # of a subclass that has __getstate__
        own, slots = ({name: part[name] for name in part if name not in (*_CACHED, "_model")} for part in (state[0] or {}, state[1]))
        return (own, slots) if own or slots else None


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
    model = _pfront.Model.from_blob(np.fromfile(path, np.uint8))
    _warn_if_empty(model)
    return Mesh(model)


def bodies(path: Path) -> dict[str, Mesh]:
    """Read the bodies of a file: the nodes of a glTF, the items of a 3MF, the objects or groups of an OBJ, the solids of an STL.

    Parameters
    ----------
    path : path
        The file; `Mesh` reads it as one mesh.

    Returns
    -------
    dict of str to Mesh
        The bodies in the order of the file. A file of one body has the name of the file.

    Examples
    --------
    >>> import pathlib, tempfile, pfront as pf
    >>> path = pathlib.Path(tempfile.mkdtemp(), "two.obj")
    >>> _ = path.write_text("v 0 0 0\\nv 1 0 0\\nv 0 1 0\\no lid\\nf 1 2 3\\no box\\nf 3 2 1\\n")
    >>> pf.bodies(path)
    {'lid': Mesh(3 vertices, 1 face, float32), 'box': Mesh(3 vertices, 1 face, float32)}
    """
    path = os.fsdecode(path)
    vertices, faces, parts, notes = _read(path)
    for note in notes:
        warnings.warn(f"{path}: {note}", stacklevel=2)
    if len(parts) < 2:
        return {os.path.basename(path): Mesh(vertices, faces)}
    found = {}
    for name, numbers in parts:
        used, corners = np.unique(faces[numbers], return_inverse=True)
        found[name] = Mesh(vertices[used], corners.reshape(-1, 3))
    return found


def _warn_if_empty(model: _pfront.Model) -> None:
    if model.counts()[1] == 0:
        warnings.warn("a mesh without faces intersects nothing", stacklevel=3)


def _from_blob(digest: bytes, blob: Any, kind: type[Mesh] | None = None) -> Mesh:
    """A mesh out of a pickle; one that is still there is not read again. One of another kind, or with attributes, is a mesh of its own."""
    found = _unpickled.get(digest)
    if found is None:
        bytes_ = np.frombuffer(blob, np.uint8)
        found = _unpickled.setdefault(digest, Mesh(_pfront.Model.from_blob(np.require(bytes_, requirements=("C", "A")))))
    return found if kind is None else _made(kind, found._model, None)


def _made(kind: type[_Kind], model: _pfront.Model, state: Any) -> _Kind:
    """A mesh of a model that is there, with the attributes of another."""
    mesh = kind.__new__(kind)
    mesh._model = model
    if state is not None and hasattr(mesh, "__setstate__"):
        mesh.__setstate__(state)
    elif state is not None:
        own, slots = state if isinstance(state, tuple) else (state, {})
        mesh.__dict__.update(own)
        for name, value in slots.items():
            setattr(mesh, name, value)
    return mesh


def _replace(path: str | os.PathLike[str], content: Any) -> None:
    """Write a file aside and put it where it belongs once it is whole; without that, nothing is left behind."""
    target = os.path.realpath(path)
    if os.path.exists(target) and not os.path.isfile(target):
        # A pipe or a device, which cannot be replaced.
        with open(path, "wb") as file:
            file.write(content)
        return
    is_there = os.path.exists(target)
    if is_there and not os.access(target, os.W_OK):
        raise PermissionError(errno.EACCES, os.strerror(errno.EACCES), os.fspath(path))
    aside = os.path.join(os.path.dirname(target), f".pfront-{secrets.token_hex(8)}.tmp")
    try:
        with open(aside, "xb") as file:
            file.write(content)
        if is_there:
            os.chmod(aside, stat.S_IMODE(os.stat(target).st_mode))
        os.replace(aside, target)
    except BaseException as error:
        with suppress(OSError):
            os.unlink(aside)
        if isinstance(error, OSError):
            raise OSError(error.errno, error.strerror, os.fspath(path)) from None
        raise


def _read_only(array: npt.NDArray[Any]) -> npt.NDArray[Any]:
    """A view that cannot be made writable again."""
    array.flags.writeable = False
    return array.view()


def _points(vertices: Any) -> npt.NDArray[Any]:
    """Vertices in an aligned array of float32 or float64, in C order."""
    points = array(vertices, "vertices are")
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
    corners = _corners(array(faces, "faces are"))
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
    if isinstance(source, (str, bytes, os.PathLike)):
        return _file(os.fsdecode(source))
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
    vertices, faces, _, notes = _read(path)
    for note in notes:
        # Beyond _file, _parts and __init__.
        warnings.warn(f"{path}: {note}", stacklevel=4)
    return vertices, faces


def _read(path: str) -> tuple[Any, Any, list[tuple[str, Any]], list[str]]:
    try:
        # The command takes - for standard input.
        return _pfront.read(os.path.join(os.curdir, path) if path == "-" else path)
    except OSError as error:
        raise OSError(error.errno, os.strerror(error.errno or 0), path) from None
