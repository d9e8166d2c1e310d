"""Smallest distances: against every two triangles, in each form of the question."""

import pickle
from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest
from conftest import ball, placed, poses

import pfront as pf

BAD = [float("nan"), float("inf"), -1, -1e-300, 1e300]
FLAT = pf.Mesh([[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 1, 2]])
with pytest.warns(UserWarning):
    NONE = pf.Mesh(np.empty((0, 3)), np.empty((0, 3), int))


def distances(a, b):
    """Distances of all triangles, (n, 3, 3), to all of another list, in float64; where they intersect, of their outlines."""

    def of_segments(p, d, q, e):
        """Ends on both, or the middle where the lines are nearest, whichever is least."""
        r = p - q
        dd, ee, de, dr, er = ((x * y).sum(-1) for x, y in ((d, d), (e, e), (d, e), (d, r), (e, r)))
        least = np.inf
        with np.errstate(divide="ignore", invalid="ignore"):
            inner = np.clip(np.nan_to_num((de * er - dr * ee) / (dd * ee - de * de)), 0, 1)
        for s in (0 * dd, 0 * dd + 1, inner):
            t = np.clip((s * de + er) / ee, 0, 1)
            s = np.clip((t * de - dr) / dd, 0, 1)
            least = np.minimum(least, np.linalg.norm(r + s[..., None] * d - t[..., None] * e, axis=-1))
        return least

    def of_points(p, triangle):
        """Of a point to the plane, where it lies over the triangle."""
        normal = np.cross(triangle[..., 1, :] - triangle[..., 0, :], triangle[..., 2, :] - triangle[..., 0, :])
        sides = [(np.cross(triangle[..., (k + 1) % 3, :] - triangle[..., k, :], p - triangle[..., k, :]) * normal).sum(-1) for k in range(3)]
        height = np.abs(((p - triangle[..., 0, :]) * normal).sum(-1)) / np.linalg.norm(normal, axis=-1)
        return np.where(np.min(sides, 0) >= 0, height, np.inf)

    a, b = a[:, None].astype(float), b[None].astype(float)
    least = np.inf
    for i in range(3):
        for j in range(3):
            p, q = a[..., i, :], b[..., j, :]
            least = np.minimum(least, of_segments(p, a[..., (i + 1) % 3, :] - p, q, b[..., (j + 1) % 3, :] - q))
        least = np.minimum(least, np.minimum(of_points(a[..., i, :], b), of_points(b[..., i, :], a)))
    return least


def corners(mesh, pose=None):
    found = mesh.vertices[mesh.faces].astype(float)
    return found if pose is None else found @ pose[:3, :3].T.astype(float) + pose[:3, 3]


def same(one, other):
    """Whether two gaps are the same to the bit."""
    if one is None or other is None:
        return one is other
    return one.interval == other.interval and one.pair == other.pair and np.array_equal(one.points, other.points)


@pytest.mark.parametrize("kind", [np.float32, np.float64])
@pytest.mark.parametrize("threads", [1, 2])
def test_of_all_triangles(kind, threads):
    a, b = pf.Mesh(*ball(7)), pf.Mesh(*ball(9, 0.5))
    many, told = poses(40, spread=2, kind=kind), []
    many[3] = np.eye(4)  # inside, where surfaces do not meet
    with pf.using(threads=threads):
        gaps = pf.distance(a, b, many, progress=lambda *x: told.append(x))
        meets = pf.collides(a, b, many)
        singles = [pf.distance(a, b, pose) for pose in many]
        near = pf.distance(a, b, many, limit=0.5)
    assert told == [(40, 40)] and len(gaps) == 40 and 5 < meets.sum() < 35 and not meets[3]
    assert gaps.intervals.dtype == gaps.points.dtype == float and gaps.pairs.dtype == np.int64
    assert np.array_equal(gaps.distances, gaps.intervals[:, 1])
    for i, (pose, single, gap) in enumerate(zip(many, singles, gaps)):
        low, high = single.interval
        if meets[i]:
            assert (low, high) == gap.interval == (0, 0) and np.array_equal(*single.points)
            listed = pf.pairs(a, b, pose).tolist()
            assert list(single.pair) in listed and list(gap.pair) in listed
            continue
        truth = distances(corners(a), corners(b, pose))
        least = truth.min()
        # What float32 rounds the vertices of b by.
        slack = 1e-6 if kind is np.float32 else 1e-12
        assert same(single, gap) and low - slack <= least <= high + slack and 0 < low < high < low + 1e-6
        assert truth[single.pair] <= least + slack and abs(np.linalg.norm(single.points[1] - single.points[0]) - least) <= slack
        on_a, on_b = corners(a)[single.pair[0]], corners(b, pose)[single.pair[1]]
        for point, triangle in ((single.points[0], on_a), (single.points[1], on_b)):
            assert distances(point[None, None] + np.diag([1e-9, 2e-9, 3e-9])[None], triangle[None]).min() < 1e-6
    is_near = gaps.distances <= 0.5
    assert 0 < is_near.sum() < 40 and np.array_equal(np.isfinite(near.distances), is_near)
    apart = is_near & ~meets
    assert all(np.array_equal(getattr(near[apart], name), getattr(gaps[apart], name)) for name in ("intervals", "pairs", "points"))
    assert (near.intervals[~is_near] == np.inf).all() and (near.pairs[~is_near] == -1).all() and np.isnan(near.points[~is_near]).all()
    assert near[int(np.argmin(is_near))] is None


def test_a_limit_is_exact_and_rounded_up():
    pose = placed(z=0.02, kind=np.float64)
    assert float(np.float32(0.02)) < 0.02
    for limit, is_found in ((0.02, True), (np.float32(0.02), False), (0.25, True), (0, False)):
        assert (pf.distance(FLAT, FLAT, pose, limit=limit) is not None) is is_found
        assert (pf.distance(FLAT, FLAT, pose[None], limit=limit)[0] is not None) is is_found
    assert pf.distance(FLAT, FLAT, limit=0).distance == 0
    for limit in BAD:
        for ask in (lambda: pf.distance(FLAT, FLAT, limit=limit), lambda: pf.distance(FLAT, FLAT, np.eye(4)[None], limit=limit),
                    lambda: pf.sweep(FLAT, FLAT, np.eye(4)[None], "distance", limit=limit)):  # fmt: skip
            with pytest.raises(ValueError, match="must be finite and not negative"):
                ask()
    with pytest.raises(TypeError):
        pf.distance(FLAT, FLAT, limit="near")


def test_where_there_is_none():
    for a, b in ((FLAT, NONE), (NONE, FLAT), (NONE, NONE)):
        assert pf.distance(a, b) is None
        gaps = pf.distance(a, b, poses(3))
        assert list(gaps) == [None] * 3 and (gaps.intervals == np.inf).all() and (gaps.pairs == -1).all() and np.isnan(gaps.points).all()
    empty = pf.distance(FLAT, FLAT, np.empty((0, 4, 4)))
    assert len(empty) == 0 and empty.points.shape == (0, 2, 3) and list(empty) == []
    with pytest.raises(TypeError):
        pf.distance(FLAT)
    with pytest.raises(pf.PoseError) as caught:
        pf.distance(FLAT, FLAT, np.stack([np.eye(4), np.full((4, 4), np.inf)]))
    assert caught.value.pose == 1


def test_gaps_are_a_sequence_and_pickle():
    many = np.stack([placed(z=z) for z in (0.5, 1, 2, 3)])
    gaps = pickle.loads(pickle.dumps(pf.distance(FLAT, FLAT, many, limit=2)))
    assert [gap and round(gap.distance, 6) for gap in gaps] == [0.5, 1, 2, None] and gaps[-1] is None
    assert gaps[1:3].distances.shape == (2,) and gaps[gaps.distances < 1.5].points[:, 1, 2].tolist() == [0.5, 1]
    assert gaps[np.int64(1)].points.shape == (2, 3) and repr(gaps) == "Gaps(4 poses)"
    with pytest.raises(IndexError):
        gaps[4]


def test_a_sweep_elsewhere():
    many = np.stack([placed(z=z) for z in (0.5, 1, 2, 3)])
    told = pf.distance(FLAT, FLAT, many, limit=2)
    for executor in (None, ThreadPoolExecutor(2)):
        found = list(pf.sweep(FLAT, FLAT, many, "distance", limit=2, chunk=3, executor=executor))
        assert [i for i, _ in found] == [0, 1, 2, 3] and all(same(gap, told[i]) for i, gap in found)
    with pytest.raises(ValueError, match="leave out within"):
        pf.sweep(FLAT, FLAT, many, "distance", within=1)
    with pytest.raises(ValueError, match="has no limit"):
        pf.sweep(FLAT, FLAT, many, "count", limit=1)


def test_a_scene():
    mesh, places = pf.Mesh(*ball(6, 0.4)), poses(12, seed=3)
    scene = pf.Scene()
    ids = [scene.add(mesh, pose, name=f"body {i}") for i, pose in enumerate(places)]
    none = scene.add(NONE, name="none")
    world = [corners(mesh, pose) for pose in places]
    soups = [pf.Mesh(triangles.reshape(-1, 3), np.arange(3 * len(triangles)).reshape(-1, 3)) for triangles in world]
    truths = np.full((12, 12), np.inf)
    for i in ids:
        for j in ids[i + 1 :]:
            truths[i, j] = truths[j, i] = 0 if pf.collides(soups[i], soups[j]) else distances(world[i], world[j]).min()
    assert (truths == 0).any()
    for threads in (1, 2):
        for i, truth in zip(ids, truths):
            with pf.using(threads=threads):
                nearest, gap = scene.distance(f"body {i}")
                assert abs(gap.distance - truth.min()) < 1e-6 and truth[nearest] < truth.min() + 1e-6
                if gap.distance > 0:
                    pair = world[i][gap.pair[0]][None], world[nearest][gap.pair[1]][None]
                    assert distances(*pair)[0, 0] < gap.distance + 1e-6
                    assert scene.distance(i, limit=gap.distance * 0.999) is None and scene.distance(i, limit=gap.distance)[0] == nearest
                    scene.ignore(i, nearest)
                    assert scene.distance(i)[0] != nearest
                    scene.ignore(i, nearest, False)
    assert scene.distance(none) is None
    scene.remove("none")
    for body in (none, "none"):
        with pytest.raises(pf.StaleBody):
            scene.distance(body)
    for limit in BAD:
        with pytest.raises(ValueError, match="must be finite and not negative"):
            scene.distance(0, limit=limit)
    alone = pf.Scene()
    assert alone.distance(alone.add(mesh)) is None


def test_a_manager_as_trimesh_is_used():
    mesh, small = pf.Mesh(*ball(8)), pf.Mesh(*ball(8, 0.25))
    manager, other = pf.compat.CollisionManager(), pf.compat.CollisionManager()
    assert manager.min_distance_internal(return_names=True, return_data=True) == (np.inf, None, None)
    assert manager.min_distance_single(mesh, return_name=True) == (np.inf, None) and manager.min_distance_other(other) == np.inf
    for name, x in (("c", 0), ("b", 3), ("a", 7)):
        manager.add_object(name, mesh, placed(x))
    assert manager.min_distance_other(other, True) == (np.inf, None) == other.min_distance_other(manager, True)
    b_c, a_b = (pf.distance(mesh, mesh, placed(x)).distance for x in (3, 4))
    assert manager.min_distance_internal() == b_c
    distance, names, data = manager.min_distance_internal(return_names=True, return_data=True)
    assert (distance, names) == (b_c, ("b", "c")) and data.names == {"b", "c"} and data.distance == b_c
    assert data.point("c")[0] < 1.5 < data.point("b")[0] and data.index("c") == pf.distance(mesh, mesh, placed(3)).pair[0]
    assert manager.min_distance_internal("a", return_names=True) == (pytest.approx(a_b, abs=1e-6), ("a", "b"))
    with pytest.raises(ValueError, match="not in collision manager"):
        manager.min_distance_internal("d")
    with pytest.raises(KeyError):
        data.index("a")
    # A mesh, nearest to the last; and one that is far from all boxes.
    for x, name, at in ((9, "a", 7), (100, "a", 7), (-50, "c", 0)):
        truth = pf.distance(mesh, small, placed(x - at))
        distance, found, data = manager.min_distance_single(small, placed(x), True, True)
        assert found == name and data.names == {name, "__external"} and abs(distance - truth.distance) < 1e-5
        faces = corners(mesh, placed(at))[data.index(name)], corners(small, placed(x))[data.index("__external")]
        assert abs(distances(faces[0][None], faces[1][None])[0, 0] - truth.distance) < 1e-5
        assert np.allclose(data.point("__external") - data.point(name), truth.points[1] - truth.points[0], atol=1e-5)
    # Of two managers the one that has fewer objects is asked: both ways, with a body of no faces on either side.
    manager.add_object("none", NONE), other.add_object("none", NONE)
    other.add_object("x", small, placed(12)), other.add_object("y", small, placed(9.5))
    one = manager.min_distance_other(other, True, True)
    two = other.min_distance_other(manager, True, True)
    assert one[1] == ("a", "y") and two[1] == ("y", "a") and one[0] == two[0] == pytest.approx(pf.distance(mesh, small, placed(2.5)).distance)
    assert all(one[2].index(name) == two[2].index(name) and np.array_equal(one[2].point(name), two[2].point(name)) for name in ("a", "y"))
    # Objects that meet.
    manager.set_transform("b", placed(1))
    assert manager.min_distance_internal(return_names=True) == (0, ("b", "c")) and manager.min_distance_single(mesh) == 0
    other.set_transform("y", placed(8))
    assert manager.min_distance_other(other, True) == (0, ("a", "y"))


def test_the_accessor_of_pyvista():
    import pyvista

    pf.register()
    points, triangles = ball(12)
    mesh = pyvista.PolyData.from_regular_faces(points, triangles)
    assert same(mesh.pfront.distance(mesh, placed(3), limit=2), pf.distance((points, triangles), (points, triangles), placed(3)))
