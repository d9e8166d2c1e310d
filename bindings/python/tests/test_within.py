"""Pairs of triangles at most so far apart."""

from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest

import pfront as pf

BAD = [float("nan"), float("inf"), -1, -1e-300, 1e300]


def square(count=3):
    """A square [0, 1]² of cells in the plane z = 0; coordinates are fractions of 4."""
    side = np.arange(count + 1) / 4
    points = np.stack([*np.meshgrid(side, side, indexing="ij"), np.zeros((count + 1, count + 1))], -1).reshape(-1, 3)
    low = (np.arange(count)[:, None] * (count + 1) + np.arange(count)).reshape(-1)
    corners = [[low, low + count + 1, low + 1], [low + 1, low + count + 1, low + count + 2]]
    return points, np.concatenate([np.stack(three, -1) for three in corners])


def distances(points_a, points_b, faces):
    """Distances of triangles of two parallel planes: of their outlines in the plane, and of the planes."""

    def to_segment(p, u, v):
        along = np.clip(np.dot(p - u, v - u) / np.dot(v - u, v - u), 0, 1)
        return np.linalg.norm(u + along * (v - u) - p)

    def has(triangle, p):
        turns = [np.cross(np.append(v - u, 0), np.append(p - u, 0))[2] for u, v in zip(triangle, np.roll(triangle, -1, 0))]
        return min(turns) >= 0 or max(turns) <= 0

    def flat(a, b):
        # Cells are equal, so that outlines that cross have a corner or the middle of one in the other.
        for one, other in ((a, b), (b, a)):
            if any(has(other, p) for p in [*one, one.mean(0)]):
                return 0.0
        sides = [(t, u, v) for t, o in ((a, b), (b, a)) for u, v in zip(o, np.roll(o, -1, 0))]
        return min(to_segment(p, u, v) for t, u, v in sides for p in t)

    gap = points_b[0, 2] - points_a[0, 2]
    rows = [[np.hypot(flat(points_a[a][:, :2], points_b[b][:, :2]), gap) for b in faces] for a in faces]
    return np.array(rows)


@pytest.mark.parametrize("threads", [1, 2])
@pytest.mark.parametrize("dtype", [np.float32, np.float64])
def test_two_squares_with_a_gap(dtype, threads):
    points, faces = square()
    mesh = pf.Mesh(points, faces)
    poses = np.tile(np.eye(4, dtype=dtype), (3, 1, 1))
    poses[:, 2, 3] = 0.125, 0.25, 0.5
    with pf.using(threads=threads):
        for within in (0.0625, 0.125, 0.3, 0.6):
            found, counts = pf.pairs(mesh, mesh, poses, within=within), pf.count(mesh, mesh, poses, within=within)
            for i, pose in enumerate(poses):
                expected = np.argwhere(distances(points, points + pose[:3, 3], faces) <= within)
                assert found[i].tolist() == expected.tolist()
                assert pf.pairs(mesh, mesh, pose, within=within).tolist() == expected.tolist()
                assert counts[i] == pf.count(mesh, mesh, pose, within=within) == len(expected)
                hit = len(expected) > 0
                assert pf.collides(mesh, mesh, pose, within=within) is hit
                assert (pf.first(mesh, mesh, pose, within=within) is not None) is hit
                parts = [pf.part(k, 3).pairs(mesh, mesh, pose, within=within) for k in range(3)]
                assert sorted(np.concatenate(parts).tolist()) == expected.tolist()
                assert sum(pf.part(k, 3).count(mesh, mesh, pose, within=within) for k in range(3)) == len(expected)
                scene = pf.Scene(within=within)
                ids = scene.add(mesh), scene.add(mesh, pose)
                assert scene.pairs().pairs.tolist() == expected.tolist()
                assert scene.collides() is hit and scene.count() == len(expected)
                assert scene.intersecting_bodies().tolist() == ([list(ids)] if hit else [])
                assert len(scene.contacts()) == 0
            assert pf.collides(mesh, mesh, poses, within=within).tolist() == (counts > 0).tolist()
            assert [count for _, count in pf.sweep(mesh, mesh, poses, "count", within=within)] == counts.tolist()
    assert pf.count(mesh, mesh, poses).tolist() == [0, 0, 0]


def test_one_mesh_whose_sheets_are_near():
    points, faces = square(1)
    mesh = pf.Mesh(np.concatenate([points, points + [0, 0, 0.25]]), np.concatenate([faces, faces + len(points)]))
    assert pf.count(mesh) == 0 and pf.count(mesh, within=0.2) == 0
    # Neighbours are decided as without.
    assert pf.pairs(mesh, within=0.25).tolist() == [[0, 2], [0, 3], [1, 2], [1, 3]]
    assert pf.first(mesh, within=0.25) is not None and pf.collides(mesh, within=0.25)


def test_a_distance_is_rounded_up():
    low = pf.Mesh([[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 1, 2]])
    pose = np.eye(4)
    pose[2, 3] = 0.02  # above the float32 nearest to it
    assert float(np.float32(0.02)) < 0.02
    assert pf.count(low, low, pose, within=0.02) == 1
    assert pf.count(low, low, pose, within=np.float32(0.02)) == 0


def test_distances_that_are_none():
    mesh = pf.Mesh([[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 1, 2]])
    for within in BAD:
        for ask in (pf.collides, pf.first, pf.count, pf.pairs, pf.part(0, 2).count, pf.part(0, 2).pairs):
            with pytest.raises(ValueError, match="must be finite and not negative"):
                ask(mesh, mesh, within=within)
        with pytest.raises(ValueError, match="must be finite and not negative"):
            pf.Scene(within=within)
        with pytest.raises(ValueError, match="must be finite and not negative"):
            pf.sweep(mesh, mesh, np.eye(4)[None], within=within)
    with pytest.raises(TypeError):
        pf.collides(mesh, mesh, within="near")
    with pytest.raises(ValueError, match="leave out within"):
        pf.sweep(mesh, mesh, np.eye(4)[None], "contacts", within=1)


def test_a_sweep_elsewhere():
    mesh = pf.Mesh(*square(1))
    poses = np.tile(np.eye(4), (4, 1, 1))
    poses[:, 2, 3] = 1, 2, 3, 4
    with ThreadPoolExecutor(2) as executor:
        found = list(pf.sweep(mesh, mesh, poses, within=2, chunk=1, executor=executor))
    assert found == [(0, True), (1, True), (2, False), (3, False)]
