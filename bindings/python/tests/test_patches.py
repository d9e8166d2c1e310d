"""Contacts as connected patches of curves and areas."""

import numpy as np
import pytest
from conftest import placed, poses

import pfront as pf


def holds(interval, number):
    low, high = interval
    return low <= number <= high < low + 1e-9


def test_flush_boxes_have_an_area_and_its_outline():
    box = pf.Mesh(*pf._box())
    pose = placed(1, 0.25, 0.5, kind=np.float64)
    [patch] = pf.patches(box, box, pose)
    assert patch.dimension == 2 and not patch.closed
    assert holds(patch.area, 0.375) and holds(patch.length, 2.5)
    assert patch.pairs.tolist() == pf.pairs(box, box, pose).tolist()
    assert patch.points[:, 0].tolist() == [0.5] * len(patch.points)
    [corner] = pf.patches(box, box, placed(1, 1, 1, kind=np.float64))
    assert corner.dimension == 0 and corner.points.tolist() == [[0.5] * 3] and corner.segments.shape == (0, 2)
    assert pf.patches(box, box, placed(3)) == []
    [same] = pf.patches(box, box)
    assert same.closed and same.dimension == 2 and holds(same.area, 6) and same.length == (0, 0)


def test_curves_of_solids_that_cross_are_closed():
    box = pf.Mesh(*pf._box())
    for pose in poses(20, spread=0.4, kind=np.float64):
        found = pf.patches(box, box, pose)
        assert sum(len(patch.pairs) for patch in found) == pf.count(box, box, pose)
        for patch in found:
            ends = patch.points[patch.segments]
            lengths = np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1).sum()
            assert patch.dimension == 1 and patch.closed
            assert patch.length[0] - 1e-9 < lengths < patch.length[1] + 1e-9


def test_one_pose_is_asked_about():
    with pytest.raises(pf.PoseError, match="one pose"):
        pf.patches(pf._box(), pf._box(), np.stack([np.eye(4)] * 2))


def test_a_check_has_contacts_if_asked():
    bodies = {"lid": pf._box(), "jar": pf.Mesh(np.array(pf._box()[0]) + [1, 0, 0], pf._box()[1])}
    assert pf.check(bodies).pairs[0].contact is None
    report = pf.check(bodies, patches=True)
    size = report.pairs[0].contact
    assert (size.dimension, size.patches) == (2, 1) and holds(size.area, 1) and holds(size.length, 4)
    columns = report.to_dict()
    assert columns["area_low"].tolist() == [size.area[0]] and columns["length_high"].tolist() == [size.length[1]]
