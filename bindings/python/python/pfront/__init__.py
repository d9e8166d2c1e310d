"""Every intersecting triangle pair of two meshes, or within one: exact, sorted, fast.

Meshes are surfaces, not solids: a box inside another does not touch it, and does not collide; `relation` and `check` ask about solids. A
question is about one instant, but for `impacts`. Touching counts, and there is no tolerance, unless `within` asks for pairs at most so far apart.

    Meshes
      Mesh                                                  a triangle mesh of arrays, of a file, or of trimesh, pyvista, Open3D, meshio
      Mesh.vertices, .faces, .dtype, .nbytes                what is tested, in which precision, and the memory that it takes
      Mesh.with_vertices                                    the same faces with other vertices, by a refit
      Mesh.save, load                                       a .pfb, with its BVH
      bodies                                                the bodies of a file, by their names
    Questions about two meshes in a pose or in many, or about one and itself
      collides                                              whether they meet
      first                                                 a pair of triangles that meets, or None
      count                                                 how many pairs meet
      pairs                                                 which, sorted
      contacts                                              where: a segment and two normals for each pair
      patches                                               all that they have in common: connected curves and areas, measured
      distance                                              how far apart they are: an interval, the nearest faces and points
      relation                                              what one solid is to another, in a word: touching, crossing, inside, ...
      overlap_volume                                        the volume that two solids have in common: an interval
      impacts                                               which faces meet while meshes move, and when
      first_impact                                          the faces that meet first
      any_impact                                            some faces that meet while meshes move, or None
      count_impacts                                         how many pairs do: the least and the greatest number
      sweep                                                 any of these for many poses, one by one, on other processes too
      part, Part                                            one of n parts of a large question
    Questions about one mesh, and points
      inside                                                whether points are inside a solid
      segment                                               which faces a segment meets
      segment_first                                         the first face along a segment, or along each of many
    Many bodies in one world
      Scene, Scene.from_file, .from_trimesh                 bodies, each a mesh in a pose
      Scene.add, .remove, .set_poses, .set_mesh, .ignore    by ids or names
      Scene.name, .names, .user_ids                         what bodies are called
      Scene.collides, .count, .pairs, .contacts             as of two meshes
      Scene.intersecting_bodies                             which bodies meet
      Scene.impacts, .first_impact                          which faces of bodies meet while some move, and when
      Scene.any_impact, .count_impacts                      whether any do, and how many
      Scene.distance                                        which body is nearest to one, and how far
      Scene.segment, .segment_first                         which faces of which bodies a segment meets
      Scene.inside                                          which bodies contain a point
      Scene.check, check                                    what all bodies are to each other, and whether that is allowed
      Scene.show                                            a picture
    Answers
      Contacts, Contacts.pairs, .segments, .normals, .flat  arrays with a row for each pair
      Contacts.polylines                                    the curves along which meshes meet
      Contacts.to_dict, Hits.to_dict                        columns, for pandas
      Hits, Hits.bodies, .pairs                             pairs of triangles of a scene
      SceneContacts                                         contacts of a scene, with their bodies
      ContactPatch, ContactPatch.dimension, .closed         of what two meshes have in common
      ContactPatch.length, .area                            intervals
      ContactPatch.pairs, .points, .segments                the faces, and where that is
      Gap, Gap.interval, .pair, .points, .distance          the smallest distance
      Gaps, Gaps.intervals, .pairs, .points, .distances     arrays with a row for each pose
      Impacts, Impacts.pairs, .start, .end, .proven         arrays with a row for each pair
      Impact, Impact.pair, .start, .end, .proven            one of them
      SceneImpacts, SceneImpact                             those of a scene, with their bodies
      Ragged, Ragged.values, .offsets                       a list of pairs or contacts for each pose
      CheckReport, CheckReport.pairs, .allowed, .counts     of an assembly
      CheckReport.refused, .to_dict                         bodies that are no solids; columns, for pandas
      CheckedPair, CheckedPair.bodies, .names, .relation    of two bodies
      CheckedPair.allowed, .meets, .overlap_volume          whether that is allowed, and more of how they meet
      CheckedPair.contact, ContactSize                      how much of their surfaces meets
      ContactSize.dimension, .patches, .length, .area       in numbers
      CheckedPair.gap, .pair, .place                        how far apart they are; where they meet
    Who answers
      using                                                 threads, or a GPU, for a block
      devices                                               the GPU that there is
      explain                                               who answered
    Beside others
      show                                                  a picture of two meshes and where they meet
      register                                              the accessor of pyvista: mesh.pfront.collides(other)
      compat                                                the collision manager of trimesh
    Errors
      MeshError, PoseError, BlobError                       a ValueError each, with the vertex, face, row or pose
      NotSolid                                              a MeshError: no solid, with the edge or the faces
      StaleBody                                             a KeyError: no such body
      DeviceError                                           a RuntimeError: no such device, or one that failed

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
from ._check import CheckedPair, CheckReport, ContactSize
from ._errors import BlobError, DeviceError, MeshError, NotSolid, PoseError, StaleBody
from ._mesh import Mesh, bodies, load
from ._pfront import __version__ as __version__
from ._questions import (
    ContactPatch, Contacts, Gap, Gaps, Impact, Impacts, Part, Ragged, any_impact, collides, contacts, count,
    count_impacts, distance, first, first_impact, impacts, inside, overlap_volume, pairs, part, patches, relation, segment, segment_first, sweep,
)  # fmt: skip
from ._scene import Hits, Scene, SceneContacts, SceneImpact, SceneImpacts, check
from ._settings import devices, explain, using
from ._show import register, show

__all__ = [
    "BlobError", "CheckReport", "CheckedPair", "ContactPatch", "ContactSize", "Contacts", "DeviceError", "Gap", "Gaps", "Hits", "Impact", "Impacts", "Mesh", "MeshError", "NotSolid",
    "Part", "PoseError", "Ragged", "Scene", "SceneContacts", "SceneImpact", "SceneImpacts", "StaleBody", "any_impact", "bodies", "check", "collides", "compat", "contacts",
    "count", "count_impacts", "devices", "distance", "explain", "first", "first_impact", "impacts", "inside", "load", "overlap_volume", "pairs", "part", "patches", "register", "relation",
    "segment", "segment_first", "show", "sweep", "using",
]  # fmt: skip


def _box() -> tuple[Any, Any]:
    """The box of examples: [-1/2, 1/2] cubed."""
    corners = [[x, y, z] for x in (-0.5, 0.5) for y in (-0.5, 0.5) for z in (-0.5, 0.5)]
    quads = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
    return corners, [corner for a, b, c, d in quads for corner in ([a, b, c], [a, c, d])]
