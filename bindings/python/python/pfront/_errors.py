"""What pfront refuses, with the vertex, face or row at fault."""

from __future__ import annotations


class MeshError(ValueError):
    """Vertices and faces that are not a mesh; `vertex` or `face` is the first one at fault."""

    vertex: int | None = None
    face: int | None = None


class NotSolid(MeshError):
    """A mesh that has no inside, or none that can be told.

    An open edge is `edge` of `face`: 0, 1 or 2, from that corner to the next. If faces meet beyond the corners that they share,
    `pair` are the first two that do. All three are None if the mesh has no volume. `mesh` is "a" or "b", where two were given.
    """

    edge: int | None = None
    pair: tuple[int, int] | None = None
    mesh: str | None = None


class PoseError(ValueError):
    """A pose that is not finite or takes a mesh out of range; `row` is the row at fault, `pose` the index of one of many."""

    row: int | None = None
    pose: int | None = None


class BlobError(ValueError):
    """Bytes that are no .pfb."""


class StaleBody(KeyError):
    """A body that is no longer in the scene; `pose` is its index in a call about many."""

    pose: int | None = None

    def __str__(self) -> str:
        return str(self.args[0]) if self.args else ""


class DeviceError(RuntimeError):
    """A device that is not there, has failed, or cannot answer the question."""
