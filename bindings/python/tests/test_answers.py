"""Answers agree with each other, by every way to ask."""

import numpy as np
import pytest
from conftest import ball, heap, placed, poses
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp

import pfront as pf

BALL = pf.Mesh(*ball(16))


def test_boxes_face_to_face(box):
    assert pf.collides(box, box, placed(1)) and not pf.collides(box, box, placed(np.nextafter(np.float32(1), np.float32(2))))
    # A surface holds nothing inside.
    assert not pf.collides(box, pf.Mesh(0.5 * box.vertices, box.faces))


@pytest.mark.parametrize("kind", [np.float32, np.float64])
@pytest.mark.parametrize("threads", [1, 2, 5])
def test_batches_are_single_questions(kind, threads):
    many = poses(300, kind=kind)
    told = []
    with pf.using(threads=threads):
        lists = pf.pairs(BALL, BALL, many, progress=lambda done, total: told.append((done, total)))
        counts, hits = pf.count(BALL, BALL, many), pf.collides(BALL, BALL, many)
    assert told == [(300, 300)] and lists.offsets[-1] == len(lists.values) and len(lists) == 300
    assert 10 < hits.sum() < 290 and counts.dtype == np.int64 and lists.values.dtype == np.uint32
    with pf.using(threads=1):
        for pose, found, n, hit in zip(many, lists, counts, hits):
            assert np.array_equal(pf.pairs(BALL, BALL, pose), found) and len(found) == n and (n > 0) == hit
    assert np.array_equal(lists[-1], lists[299])
    with pytest.raises(IndexError):
        lists[300]


def test_no_poses():
    none = np.empty((0, 4, 4))
    assert len(pf.pairs(BALL, BALL, none)) == 0 and pf.collides(BALL, BALL, none).shape == (0,)


def test_threads_take_over_long_questions():
    soup = pf.Mesh(*heap(400))
    with pf.using(threads=1):
        truth, own = pf.pairs(soup, soup), pf.pairs(soup)
        assert pf.explain().startswith("one thread")
    with pf.using(threads=2):
        assert np.array_equal(pf.pairs(soup, soup), truth) and pf.explain() == "2 threads"
        assert np.array_equal(pf.pairs(soup), own) and pf.count(soup) == len(own)
        assert np.array_equal(pf.contacts(soup, soup).pairs, truth)
    assert len(truth) > 100_000


def test_parts_are_the_whole():
    soup = pf.Mesh(*heap(200))
    for a, b, pose in [(BALL, BALL, placed(0.5)), (soup, soup, None), (soup, None, None), (BALL, BALL, placed(9))]:
        truth = pf.pairs(a, b, pose)
        for n in (1, 2, 7, 100):
            parts = [pf.part(i, n).pairs(a, b, pose) for i in range(n)]
            joined = np.concatenate(parts)
            assert np.array_equal(joined[np.lexsort(joined.T[::-1])], truth)
            assert sum(pf.part(i, n).count(a, b, pose) for i in range(n)) == len(truth)
            assert n != 7 or len(truth) < 1000 or max(map(len, parts)) < len(truth) / 3
    for i, n in [(-1, 2), (2, 2), (0, 0), (0, 70000)]:
        with pytest.raises(ValueError):
            pf.part(i, n)


def test_contacts_and_polylines():
    found = pf.contacts(BALL, BALL, placed(0.5, 0.3, 0.1))
    assert np.array_equal(found.pairs, pf.pairs(BALL, BALL, placed(0.5, 0.3, 0.1)))
    assert found.segments.dtype == np.float32 and found.normals.shape == (len(found), 2, 3) and not found.flat.any()
    lengths = np.linalg.norm(found.normals, axis=-1)
    assert np.abs(lengths - 1).max() < 1e-6
    lines = found.polylines()
    assert sum(len(line) - 1 for line in lines) == (found.segments[:, 0] != found.segments[:, 1]).any(1).sum()
    assert any((line[0] == line[-1]).all() for line in lines)
    exact = pf.contacts(BALL, BALL, placed(0.51, 0.32, 0.13, kind=np.float64))
    assert exact.segments.dtype == np.float64 and len(exact) > 20
    assert all((line[0] == line[-1]).all() for line in exact.polylines())
    apart = pf.contacts(BALL, BALL, placed(9))
    assert len(apart) == 0 == len(apart.polylines())
    with pytest.raises(pf.PoseError):
        pf.contacts(BALL, BALL, poses(2))


def test_scene():
    scene = pf.Scene()
    many = poses(60, spread=4)
    ids = scene.add_many(BALL, many)
    last = scene.add(BALL, many[0], name="copy")
    assert scene.name(last) == "copy" and scene.name(int(ids[0])) is None and len(scene) == 61
    hits = scene.pairs()
    bodies = np.unique(hits.bodies, axis=0)
    assert len(bodies) > 10 and np.array_equal(bodies, scene.body_pairs()) and scene.count() == len(hits) and scene.collides()
    found = scene.contacts()
    assert np.array_equal(found.pairs, hits.pairs) and np.array_equal(found.bodies, hits.bodies)
    assert found.segments.dtype == np.float32
    scene.set_poses(ids[:1], many[:1].astype(np.float64))
    assert scene.contacts().segments.dtype == np.float64 and len(scene.contacts()) == scene.count()
    scene.ignore(int(ids[0]), last)
    assert not (scene.body_pairs() == [ids[0], last]).all(1).any()
    shifted = many.copy()
    shifted[:, 0, 3] += 100 * (ids % 2)
    scene.set_poses(ids, shifted)
    scene.remove(last)
    moved = scene.body_pairs()
    assert (moved[:, 0] % 2 == moved[:, 1] % 2).all()
    with pf.using(threads=2):
        assert np.array_equal(scene.body_pairs(), moved)
        assert np.array_equal(np.unique(scene.pairs().bodies, axis=0), moved)
        assert pf.explain()
    with pytest.raises(pf.StaleBody):
        scene.remove(last)
    with pytest.raises(pf.StaleBody) as caught:
        scene.set_poses([ids[0], last], many[:2])
    assert caught.value.pose == 1
    with pytest.raises(pf.PoseError):
        scene.set_poses(ids, many[:3])
    wrong = many.copy()
    wrong[3, 0, 0] = np.nan
    with pytest.raises(pf.PoseError) as caught:
        scene.add_many(BALL, wrong)
    assert caught.value.pose == 3 and len(scene) == 60


def test_scene_in_float64():
    scene = pf.Scene()
    flat = pf.Mesh([[0, 0, 0.1], [1, 0, 0.1], [0, 1, 0.1]], [[0, 1, 2]])
    scene.add(flat)
    above = scene.add(flat, placed(z=1e-12, kind=np.float64))
    assert not scene.collides()
    scene.set_poses(above, placed(kind=np.float64))
    assert scene.collides()


def test_sweep():
    many = poses(250)
    for what, whole in [("collides", pf.collides), ("count", pf.count), ("pairs", pf.pairs)]:
        told, found = [], []
        for i, answer in pf.sweep(BALL, BALL, many, what, chunk=40, progress=lambda *x: told.append(x)):
            assert i == len(found)
            found.append(answer)
        assert told[-1] == (250, 250) and len(told) == 7
        assert all(map(np.array_equal, found, whole(BALL, BALL, many)))
    with pytest.raises(ValueError):
        pf.sweep(BALL, BALL, many, "distance")


def test_gpu():
    """The software adapter of the Rust tests serves where there is no other."""
    kinds = pf.devices()
    assert kinds, "no adapter: apt-get install mesa-vulkan-drivers libvulkan1"
    many = poses(20)
    with pf.using(threads=1):
        truth, counts = pf.pairs(BALL, BALL, many), pf.count(BALL, BALL, many)
    with pf.using(device="gpu"):
        assert np.array_equal(pf.pairs(BALL, BALL, many).values, truth.values)
        assert np.array_equal(pf.count(BALL, BALL, many), counts) and pf.explain() == "GPU"
        assert np.array_equal(pf.pairs(BALL, BALL, many[3]), truth[3])
        scene = pf.Scene()
        scene.add_many(BALL, many)
        on_gpu = scene.pairs()
    with pf.using(threads=1):
        assert np.array_equal(scene.pairs().pairs, on_gpu.pairs)
        other = pf.Scene()
        other.add_many(BALL, many)
        assert np.array_equal(other.pairs().bodies, on_gpu.bodies)
    with pytest.raises(ValueError):
        with pf.using(device="tpu"):
            pass


# 10^5 inputs between them: the short run of CI asks fewer, the long one sets PFRONT_EXAMPLES.
import os  # noqa: E402

EXAMPLES = int(os.environ.get("PFRONT_EXAMPLES", "1000"))
relaxed = settings(max_examples=EXAMPLES, deadline=None, suppress_health_check=list(HealthCheck))
numbers = st.one_of(st.floats(width=64), st.integers(-3, 3).map(float))


@relaxed
@given(
    hnp.arrays(st.sampled_from([np.float32, np.float64, np.float16, np.dtype(">f8"), np.int64, np.int8]),
               st.tuples(st.integers(0, 8), st.sampled_from([3, 3, 3, 2]))),
    hnp.arrays(st.sampled_from([np.uint32, np.int64, np.int8]), st.tuples(st.integers(0, 8), st.just(3))),
    hnp.arrays(st.sampled_from([np.float32, np.float64]), st.sampled_from([(4, 4), (3, 4), (2, 4, 4), (3, 3)]), elements=st.integers(-2, 2)),
)  # fmt: skip
def test_any_array_is_answered_or_refused(points, faces, pose):
    try:
        if len(points):
            faces = faces % len(points)
        mesh = pf.Mesh(points, faces)
        if pose.shape[-2] == 4:
            pose[..., 3, :] = [0, 0, 0, 1]
        found = pf.pairs(mesh, mesh, pose)
    except (pf.MeshError, pf.PoseError, TypeError):
        return
    counts = pf.count(mesh, mesh, pose)
    assert np.sum(counts) == len(found.values if isinstance(found, pf.Ragged) else found)


@relaxed
@given(hnp.arrays(np.float32, (9, 3), elements=st.integers(-2, 2)))
def test_small_integers_agree_in_both_precisions(points):
    faces = np.arange(9).reshape(3, 3)
    mesh = pf.Mesh(points, faces)
    apart = pf.Mesh(np.concatenate([points, [[0.1, 0.1, 0.1]]]), faces)
    assert apart.dtype == np.float64
    assert np.array_equal(pf.pairs(mesh), pf.pairs(apart)) and np.array_equal(pf.pairs(mesh, mesh), pf.pairs(apart, apart))
    transposed = pf.pairs(mesh, mesh)[:, ::-1]
    assert np.array_equal(transposed[np.lexsort(transposed.T[::-1])], pf.pairs(mesh, mesh))
