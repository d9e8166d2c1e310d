"""Faces that meet while meshes move."""

import numpy as np
import pytest
from conftest import placed

import pfront as pf


def sheets(gap):
    """Two triangles above each other."""
    low = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0]], float)
    return np.concatenate([low, low + [0, 0, gap]])


FACES = [[0, 1, 2], [3, 4, 5]]


def test_what_passes_through_is_found():
    mesh = pf.Mesh(sheets(0.5), FACES)
    for end in (sheets(-0.5), pf.Mesh(sheets(-0.5), FACES)):
        found = pf.impacts(mesh, a_end=end)
        assert found.pairs.tolist() == [[0, 1]] and found.proven.tolist() == [True]
        assert 0.499999 < found.start[0] <= 0.5 <= found.end[0] < 0.500001
        first = pf.first_impact(mesh, a_end=end)
        assert (first.pair, first.start, first.end) == ((0, 1), found.start[0], found.end[0]) and first.proven
    assert len(pf.impacts(mesh, a_end=sheets(0.25))) == 0
    assert pf.first_impact(mesh, a_end=sheets(0.25)) is None


def test_boxes_hit_when_their_gap_is_gone():
    box = pf.Mesh(*pf._box())
    start, end = placed(3, kind=np.float64), placed(-1, kind=np.float64)
    first = pf.first_impact(box, box, start, pose_end=end)
    assert 0.499 < first.start <= 0.5
    found = pf.impacts(box, box, start, pose_end=end)
    assert first.start == found.start.min() and sorted(found.pairs.tolist()) == found.pairs.tolist()
    with pf.using(threads=2):
        again = pf.impacts(box, box, start, pose_end=end)
    assert again.pairs.tolist() == found.pairs.tolist() and again.start.tolist() == found.start.tolist()
    # At rest, those that meet are those that intersect.
    still = pf.impacts(box, box, placed(0.5, kind=np.float64))
    assert still.pairs.tolist() == pf.pairs(box, box, placed(0.5, kind=np.float64)).tolist()


def test_what_is_no_motion_is_refused():
    box, mesh = pf.Mesh(*pf._box()), pf.Mesh(sheets(1), FACES)
    with pytest.raises(ValueError, match="has to move"):
        pf.impacts(box)
    with pytest.raises(ValueError, match="which is not given"):
        pf.impacts(box, a_end=box, pose_end=np.eye(4))
    with pytest.raises(ValueError, match="has no pose"):
        pf.impacts(box, mesh, np.eye(4), b_end=mesh)
    with pytest.raises(ValueError, match="triangle"):
        pf.impacts(mesh, a_end=box)
    with pytest.raises(pf.PoseError, match="one pose"):
        pf.impacts(box, box, pose_end=np.stack([np.eye(4)] * 2))
