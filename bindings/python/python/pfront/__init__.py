"""Every intersecting triangle pair of two meshes, or within one: exact, sorted, fast.

Meshes are surfaces, not solids: a box inside another does not touch it, and does not collide. A question is about one instant, not
about a motion. Touching counts, and there is no tolerance.

>>> import numpy as np
>>> import pfront as pf
>>> floor = pf.Mesh([[0, 0, 0], [4, 0, 0], [0, 4, 0]], [[0, 1, 2]])
>>> blade = pf.Mesh([[1, 1, -1], [1, 2, -1], [1, 1, 1]], [[0, 1, 2]])
>>> pf.collides(floor, blade)
True
"""

from __future__ import annotations

from typing import Any

from . import compat
from ._errors import BlobError, DeviceError, MeshError, PoseError, StaleBody
from ._mesh import Mesh, bodies, load
from ._pfront import __version__ as __version__
from ._questions import Contacts, Part, Ragged, collides, contacts, count, pairs, part, sweep
from ._scene import Hits, Scene, SceneContacts
from ._settings import devices, explain, using
from ._show import register, show

__all__ = [
    "BlobError", "Contacts", "DeviceError", "Hits", "Mesh", "MeshError", "Part", "PoseError", "Ragged", "Scene",
    "SceneContacts", "StaleBody", "bodies", "collides", "compat", "contacts", "count", "devices", "explain", "load", "pairs", "part", "register", "show",
    "sweep", "using",
]  # fmt: skip


def _box() -> tuple[Any, Any]:
    """The box of examples: [-1/2, 1/2] cubed."""
    corners = [[x, y, z] for x in (-0.5, 0.5) for y in (-0.5, 0.5) for z in (-0.5, 0.5)]
    quads = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
    return corners, [corner for a, b, c, d in quads for corner in ([a, b, c], [a, c, d])]
