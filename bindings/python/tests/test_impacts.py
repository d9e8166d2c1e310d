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


MOVED = placed(3, kind=np.float64), placed(-1, kind=np.float64)
TILE = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0]], float)


def tiles(*places):
    return np.concatenate([TILE + place for place in places]), np.arange(3 * len(places)).reshape(-1, 3)


def slides(certain):
    """Tiles that slide in the plane of others, which is open; and one that goes through, if that is asked for."""
    floor = pf.Mesh(*tiles([0, 0, 0], [3, 0, 0], [6, 0, 0]))
    starts, ends = [[-1.5, 0, 0], [1.5, 0, 0], [6, 0, 1]], [[1.5, 0, 0], [4.5, 0, 0], [6, 0, -1 if certain else 0.5]]
    return (floor, pf.Mesh(*tiles(*starts))), {"b_end": tiles(*ends)[0]}


@pytest.mark.parametrize("threads", [1, 2])
@pytest.mark.parametrize("within", [0, 0.75])
def test_whether_any_and_how_many_are_those_of_the_list(threads, within):
    box, sheet = pf.Mesh(*pf._box()), pf.Mesh(sheets(0.5), FACES)
    kinds = set()
    for meshes, motion in [
        ((box, box, MOVED[0]), {"pose_end": MOVED[1]}),
        ((box, box, MOVED[0]), {}),
        ((box, box, placed(9, kind=np.float64)), {"pose_end": MOVED[0]}),
        ((sheet,), {"a_end": sheets(-0.5)}),
        ((sheet,), {"a_end": sheets(0.25)}),
        slides(False),
        slides(True),
    ]:
        with pf.using(threads=threads):
            found = pf.impacts(*meshes, **motion, within=within)
            some = pf.any_impact(*meshes, **motion, within=within)
            first = pf.first_impact(*meshes, **motion, within=within)
            low, high = pf.count_impacts(*meshes, **motion, within=within)
        assert (low, high) == (found.proven.sum(), len(found))
        rows = [pf.Impact(tuple(pair), *times) for pair, *times in zip(found.pairs.tolist(), found.start, found.end)]
        if some is None:
            assert first is None and high == 0
        else:
            assert some in rows and some.proven == (low > 0)
            assert first == min(rows, key=lambda impact: (impact.start, impact.pair))
        kinds.add((low > 0, high > low))
    assert kinds >= {(False, False), (True, False)}
    # What slides in the plane is within the distance for certain.
    assert within > 0 or kinds >= {(False, True), (True, True)}


def test_a_distance_is_reached_on_the_way():
    box = pf.Mesh(*pf._box())
    meshes, end = (box, box, MOVED[0]), {"pose_end": placed(1.5, kind=np.float64)}
    assert pf.first_impact(*meshes, **end) is None and pf.count_impacts(*meshes, **end) == (0, 0)
    # From a gap of 2 to one of 0.5.
    assert 0.666 < pf.first_impact(*meshes, **end, within=1).start <= 2 / 3
    assert len(pf.impacts(*meshes, **end, within=0.4)) == 0 and pf.any_impact(*meshes, **end, within=0.4) is None
    for ask in (pf.impacts, pf.first_impact, pf.any_impact, pf.count_impacts):
        for bad in (float("nan"), float("inf"), -1):
            with pytest.raises(ValueError, match="must be finite and not negative"):
                ask(*meshes, **end, within=bad)
        with pytest.raises(ValueError, match="has to move"):
            ask(box)


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


@pytest.mark.parametrize("threads", [1, 2])
def test_bodies_of_a_scene_that_move(threads):
    box, scene = pf.Mesh(*pf._box()), pf.Scene()
    arm, wall, door = (scene.add(box, placed(x, kind=np.float64), name=name) for name, x in [("arm", 0), ("wall", 3), ("door", 6)])
    end = placed(6, kind=np.float64)
    with pf.using(threads=threads):
        found = scene.impacts("arm", end)
        low, high = scene.count_impacts(arm, end)
        some, first = scene.any_impact([arm], [end]), scene.first_impact("arm", end)
    assert np.unique(found.bodies, axis=0).tolist() == [[arm, wall], [arm, door]]
    assert found.bodies.shape == (len(found), 2) and (low, high) == (found.proven.sum(), len(found))
    assert first.bodies == (arm, wall) and first.start == found.start.min() and first.proven
    assert some.proven and some.bodies in {(arm, wall), (arm, door)}
    # The scene is the same, and nothing has to move.
    nobody = [], np.empty((0, 4, 4))
    assert not scene.collides() and len(scene.impacts(*nobody)) == 0 and scene.first_impact(*nobody) is None
    # As two meshes that are asked alone.
    alone = pf.impacts(box, box, placed(3, kind=np.float64), pose_end=placed(-3, kind=np.float64))
    of_wall = found.bodies[:, 1] == wall
    assert sorted(map(sorted, found.pairs[of_wall].tolist())) == sorted(map(sorted, alone.pairs.tolist()))


def test_bodies_that_cannot_move_are_refused():
    box, scene = pf.Mesh(*pf._box()), pf.Scene()
    body, other = (scene.add(box, placed(x, kind=np.float64)) for x in (0, 3))
    end, bad = placed(1, kind=np.float64), np.full((4, 4), np.nan)
    for ask in (scene.impacts, scene.first_impact, scene.any_impact, scene.count_impacts):
        with pytest.raises(ValueError, match="two ends of its motion"):
            ask([body, body], [end, end])
        with pytest.raises(ValueError, match="2 poses were given for 1 bodies"):
            ask([body], [end, end])
        with pytest.raises(pf.PoseError):
            ask(body, bad)
    scene.remove(other)
    with pytest.raises(pf.StaleBody):
        scene.impacts(other, end)
