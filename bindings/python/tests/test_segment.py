"""Points and segments, against boxes of integers, which fractions tell all about."""

from fractions import Fraction

import numpy as np
import pytest
from conftest import placed

import pfront as pf

CORNERS, FACES = (np.array(part) for part in pf._box())


def box(low, high, kind=float):
    return pf.Mesh(np.where(CORNERS < 0, low, high).astype(kind), FACES)


def along(low, high, start, end):
    """Where a segment is in the box of two corners, as an interval of its parameter; None if nowhere."""
    least, most = Fraction(0), Fraction(1)
    for lower, upper, p, q in zip(low, high, start, end):
        if p == q:
            if not lower <= p <= upper:
                return None
            continue
        ends = sorted(Fraction(int(side - p), int(q - p)) for side in (lower, upper))
        least, most = max(least, ends[0]), min(most, ends[1])
    return (least, most) if least <= most else None


def is_within(low, high, point):
    """Whether a point is in the box and, apart from that, on its surface."""
    inside = all(a <= x <= b for a, x, b in zip(low, point, high))
    return inside, inside and any(x in (a, b) for a, x, b in zip(low, point, high))


@pytest.mark.parametrize("kind", [np.float32, np.float64])
def test_points(kind):
    rng = np.random.default_rng(7)
    for _ in range(10):
        low = rng.integers(-5, 5, 3)
        high = low + rng.integers(1, 5, 3)
        solid = box(low, high, kind)
        points = rng.integers(-6, 10, (500, 3))
        truth = np.array([is_within(low, high, point) for point in points])
        found = pf.inside(solid, points)
        assert found.dtype == bool and found.tolist() == truth[:, 0].tolist()
        assert pf.inside(solid, points, surface=False).tolist() == (truth[:, 0] & ~truth[:, 1]).tolist()
        assert [pf.inside(solid, point) for point in points[:9].astype(np.float32)] == found[:9].tolist()
        scene = pf.Scene()
        moved, still = scene.add(solid, placed(1, 2, 3, kind=kind)), scene.add(solid)
        for point, (inside, surface) in zip(points[:50], truth):
            told = scene.inside(point + [1, 2, 3])
            assert told.get(moved) == (None if not inside else "surface" if surface else "inside")
            assert (still in scene.inside(point)) == inside
    assert pf.inside(solid, np.empty((0, 3))).shape == (0,)
    many = rng.uniform(-6, 10, (20_000, 3))
    assert pf.inside(solid, many).tolist() == ((low <= many) & (many <= high)).all(1).tolist()
    assert pf.explain() == "one thread"


def test_where_bodies_of_one_mesh_overlap():
    vertices = np.concatenate([CORNERS, CORNERS + 0.25])
    both = np.concatenate([FACES, FACES + 8])
    points = [[0, 0, 0], [-0.4, -0.4, -0.4], [0.7, 0.7, 0.7], [0.7, -0.4, 0]]
    assert pf.inside(pf.Mesh(vertices, both), points).tolist() == [True, True, True, False]


@pytest.mark.parametrize("kind", [np.float32, np.float64])
def test_segments(kind):
    rng = np.random.default_rng(8)
    low, high = np.array([-2, -1, 0]), np.array([1, 3, 2])
    solid, scene = box(low, high, kind), pf.Scene()
    shift = np.array([4, -1, 2])
    bodies = [scene.add(solid), scene.add(solid, placed(*shift, kind=kind))]
    starts, ends = rng.integers(-5, 7, (2, 400, 3))
    ends[:20] = starts[:20]
    faces, at = pf.segment_first(solid, starts, ends)
    hits = 0
    for start, end, face, where in zip(starts, ends, faces, at):
        interval = along(low, high, start, end)
        # From the inside, the way out is the first point on a face.
        if interval is not None and not is_within(low, high, start)[1] and is_within(low, high, start)[0]:
            interval = (interval[1], interval[1]) if not all(low < end) or not all(end < high) else None
        assert (face >= 0) == (interval is not None)
        own, of_own = pf.segment(solid, start, end)
        assert own.tolist() == sorted(set(own.tolist()))
        if interval is None:
            assert np.isnan(where) and len(own) == 0
            continue
        hits += 1
        assert where == pytest.approx(float(interval[0]), abs=1e-14)
        # The lowest of the faces in the same point.
        assert face == own[np.isclose(of_own, where, atol=1e-14)].min()
        found = scene.segment(start, end)
        assert found[1][found[0] == bodies[0]].tolist() == own.tolist()
        moved = scene.segment(start + shift, end + shift)
        assert moved[1][moved[0] == bodies[1]].tolist() == own.tolist()
        assert moved[2][moved[0] == bodies[1]].tolist() == of_own.tolist()
        first = scene.segment_first(start, end)
        assert first is not None and first[2] == found[2].min() and first[0] in bodies
    assert 50 < hits < 390
    assert pf.segment_first(solid, [-5, 0, 1], starts)[0].shape == (400,)


def test_what_is_refused():
    solid, scene = box([0] * 3, [1] * 3), pf.Scene()
    with pytest.raises(pf.NotSolid) as raised:
        pf.inside((CORNERS, FACES[1:]), [0, 0, 0])
    assert (raised.value.mesh, raised.value.face, raised.value.edge) == ("mesh", 0, 0)
    for points in ([0, 1], [[0, 1]], 3, [[[0, 0, 0]]]):
        with pytest.raises(ValueError, match="shape"):
            pf.inside(solid, points)
    for number in (np.nan, np.inf, 1e38):
        with pytest.raises(ValueError, match="row 1"):
            pf.inside(solid, [[0, 0, 0], [0, number, 0]])
        with pytest.raises(ValueError, match="end"):
            pf.segment(solid, [0, 0, 0], [0, 0, number])
        with pytest.raises(ValueError, match="start"):
            scene.segment_first([0, 0, number], [0, 0, 0])
        with pytest.raises(ValueError, match="point"):
            scene.inside([number, 0, 0])
    with pytest.raises(ValueError, match="one point"):
        scene.segment([[0, 0, 0]], [0, 0, 0])
    with pytest.raises(ValueError, match="broadcast"):
        pf.segment_first(solid, np.zeros((2, 3)), np.zeros((3, 3)))
    assert scene.inside([0, 0, 0]) == {} and scene.segment_first([0, 0, 0], [1, 1, 1]) is None
