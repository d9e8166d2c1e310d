"""Answers agree with each other, by every way to ask."""

import os

import numpy as np
import pytest
from conftest import ball, heap, layouts, placed, poses
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
    some = lists[40:60]
    assert len(some) == 20 and all(map(np.array_equal, some, list(lists)[40:60])) and len(lists[5:2]) == 0 == len(lists[300:])
    assert repr(some).startswith("Ragged(20 lists")
    with pytest.raises(IndexError):
        lists[300]


def test_no_poses():
    none = np.empty((0, 4, 4))
    assert len(pf.pairs(BALL, BALL, none)) == 0 and pf.collides(BALL, BALL, none).shape == (0,)


def test_threads_take_over_long_questions():
    soup = pf.Mesh(*heap(1500))  # far longer than threads take to wake, on a busy machine too
    with pf.using(threads=1):
        truth, own = pf.pairs(soup, soup), pf.pairs(soup)
        assert pf.explain().startswith("one thread")
    with pf.using(threads=2):
        assert np.array_equal(pf.pairs(soup, soup), truth) and pf.explain() == "2 threads"
        assert np.array_equal(pf.pairs(soup), own) and pf.count(soup) == len(own)
        assert np.array_equal(pf.contacts(soup, soup).pairs, truth)
    assert len(truth) > 1_000_000


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
    with pytest.raises(TypeError):
        pf.part(0, 2).pairs(BALL, BALL, poses(2))
    with pytest.raises(TypeError):
        pf.part(0, 2).count(BALL, BALL, poses(2))
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
    some = found[~found.flat]
    assert np.array_equal(some.normals, found.normals) and len(found[:3]) == 3 and len(found[np.array([2, 0])].polylines()) > 0
    with pytest.raises(TypeError):
        found[0]


@pytest.mark.parametrize("kind", [np.float32, np.float64])
@pytest.mark.parametrize("threads", [1, 2])
def test_contacts_of_many_poses(kind, threads):
    many = poses(400, spread=1, kind=kind)
    many[7] = np.eye(4)
    told = []
    with pf.using(threads=threads):
        found = pf.contacts(BALL, BALL, many, progress=lambda *x: told.append(x))
        listed = pf.pairs(BALL, BALL, many)
    assert told == [(400, 400)] and len(found.values) > 1 << 14, "more than one look at signals"
    assert np.array_equal(found.values.pairs, listed.values) and np.array_equal(found.offsets, listed.offsets)
    assert found.values.segments.dtype == kind
    with pf.using(threads=1):
        for pose, contacts in zip(many[:50], found):
            one = pf.contacts(BALL, BALL, pose)
            assert all(np.array_equal(getattr(one, name), getattr(contacts, name)) for name in ("pairs", "segments", "normals", "flat"))
    swept = [len(contacts) for _, contacts in pf.sweep(BALL, BALL, many, "contacts", chunk=150)]
    assert swept == [len(pairs) for pairs in listed]
    with pytest.raises(pf.PoseError) as caught:
        pf.contacts(BALL, BALL, np.concatenate([many, np.full((1, 4, 4), np.inf, kind)]))
    assert caught.value.pose == 400


@pytest.mark.parametrize("kind", [np.float32, np.float64])
def test_vertices_move(kind):
    """A mesh that deforms is the mesh that would be built of the same vertices."""
    rng = np.random.default_rng(5)
    points = BALL.vertices.astype(kind) + (np.pi / 100 if kind == np.float64 else 0)
    mesh, other = pf.Mesh(points, BALL.faces), pf.Mesh(*ball(9))
    first, before = mesh, mesh.vertices
    for _ in range(20):
        moved = (mesh.vertices + rng.normal(0, 0.02, points.shape)).astype(kind)
        mesh = mesh.with_vertices(moved)
        built = pf.Mesh(moved, BALL.faces)
        assert mesh.dtype == kind and np.array_equal(mesh.vertices, moved)
        assert np.array_equal(pf.pairs(mesh), pf.pairs(built))
        assert np.array_equal(pf.pairs(mesh, other, placed(0.9)), pf.pairs(built, other, placed(0.9)))
    assert first.vertices is before and len(pf.pairs(first)) == 0 < len(pf.pairs(mesh))
    for moved in (np.asfortranarray(mesh.vertices), mesh.vertices.astype(np.dtype(kind).newbyteorder(">"))):
        assert np.array_equal(first.with_vertices(moved).vertices, mesh.vertices)


def test_vertices_move_to_other_precisions():
    wide = BALL.with_vertices(BALL.vertices.astype(float) + 0.1)
    assert wide.dtype == np.float64 and np.array_equal(wide.vertices, BALL.vertices.astype(float) + 0.1)
    assert wide.with_vertices(BALL.vertices).dtype == np.float64 and BALL.with_vertices(BALL.vertices.astype(float)).dtype == np.float32
    bad = BALL.vertices.copy()
    bad[5] = np.nan
    for mesh in (BALL, wide):
        with pytest.raises(pf.MeshError) as caught:
            mesh.with_vertices(bad)
        assert caught.value.vertex == 5
        for wrong in (bad[:-1], bad[:, :2], np.concatenate([bad, bad])):
            with pytest.raises(pf.MeshError):
                mesh.with_vertices(wrong)


@pytest.mark.parametrize("device", [None, "gpu"])
def test_meshes_of_bodies_change(device):
    with pf.using(threads=2, device=device):
        scene, cloth = pf.Scene(), pf.Mesh(*ball(9))
        ids = scene.add(cloth, np.stack([placed(3 * i) for i in range(4)]))
        assert not scene.collides() and len(scene.pairs()) == 0
        for i in range(3):
            grown = cloth.with_vertices(cloth.vertices * np.float32(1.6 + 0.1 * i))
            scene.set_mesh(ids[1], grown)
            assert scene.count() == 0
            scene.set_mesh(ids[2], grown)
            assert scene.intersecting_bodies().tolist() == [[1, 2]]
            truth = pf.Scene()
            truth.add(grown, np.stack([placed(3), placed(6)]))
            assert np.array_equal(scene.pairs().pairs, truth.pairs().pairs) and len(scene.contacts()) == scene.count() > 0
            scene.set_mesh(ids[2], cloth)
            assert not scene.collides()
        with pytest.raises(pf.StaleBody):
            scene.set_mesh(9, cloth)


def test_user_ids():
    scene = pf.Scene()
    ids = scene.add(BALL, np.stack([placed(0.1 * i) for i in range(3)]), name="rank", user_id=[70, -1, 2**62])
    one = scene.add(BALL, placed(0.5), user_id=9)
    rest = scene.add(BALL, np.stack([placed(9), placed(9.1)]), user_id=4)
    own = scene.add(BALL)
    assert type(one) is int and scene.name(ids[2]) == "rank" and scene.name(one) is None
    assert scene.user_ids([*ids, one, *rest, own]).tolist() == [70, -1, 2**62, 9, 4, 4, own]
    assert scene.user_ids(scene.pairs().bodies).shape == scene.pairs().bodies.shape and scene.user_ids(one).shape == ()
    scene.remove(one)
    for refused, kind in [(lambda: scene.user_ids(one), pf.StaleBody), (lambda: scene.user_ids([-1]), pf.StaleBody),
                          (lambda: scene.user_ids([0.5]), TypeError), (lambda: scene.add(BALL, user_id=[1, 2]), pf.PoseError),
                          (lambda: scene.add(BALL, user_id="a"), TypeError)]:  # fmt: skip
        with pytest.raises(kind):
            refused()
    assert len(scene) == 6


def test_scene():
    scene = pf.Scene()
    many = poses(60, spread=4)
    ids = scene.add(BALL, many)
    last = scene.add(BALL, many[0], name="copy")
    assert scene.name(last) == "copy" and scene.name(int(ids[0])) is None and len(scene) == 61
    hits = scene.pairs()
    bodies = np.unique(hits.bodies, axis=0)
    assert len(bodies) > 10 and np.array_equal(bodies, scene.intersecting_bodies()) and scene.count() == len(hits) and scene.collides()
    found = scene.contacts()
    assert np.array_equal(found.pairs, hits.pairs) and np.array_equal(found.bodies, hits.bodies)
    assert found.segments.dtype == np.float32
    scene.set_poses(ids[:1], many[:1].astype(np.float64))
    assert scene.contacts().segments.dtype == np.float64 and len(scene.contacts()) == scene.count()
    scene.ignore(int(ids[0]), last)
    assert not (scene.intersecting_bodies() == [ids[0], last]).all(1).any()
    shifted = many.copy()
    shifted[:, 0, 3] += 100 * (ids % 2)
    scene.set_poses(ids, shifted)
    scene.remove(last)
    moved = scene.intersecting_bodies()
    assert (moved[:, 0] % 2 == moved[:, 1] % 2).all()
    with pf.using(threads=2):
        assert np.array_equal(scene.intersecting_bodies(), moved)
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
        scene.add(BALL, wrong)
    assert caught.value.pose == 3 and len(scene) == 60


def test_scene_in_float64():
    scene = pf.Scene()
    flat = pf.Mesh([[0, 0, 0.1], [1, 0, 0.1], [0, 1, 0.1]], [[0, 1, 2]])
    scene.add(flat)
    above = scene.add(flat, placed(z=1e-12, kind=np.float64))
    assert not scene.collides()
    scene.set_poses(above, placed(kind=np.float64))
    assert scene.collides()


def test_a_body_that_is_asked_about_itself():
    points = [[0, 0, 0], [4, 0, 0], [0, 4, 0], [0, 0, 4], [1, 1, -1], [1, 1, 1], [9, 9, 9]]
    fold, pose = pf.Mesh(points, [[0, 1, 2], [1, 0, 3], [4, 5, 6]]), placed(z=2)
    for device in ["cpu", "gpu"]:
        with pf.using(device=device):
            scene = pf.Scene()
            scene.add(fold)
            cloth = scene.add(fold, pose, itself=True)
            hits = scene.pairs()
            own = hits.pairs[(hits.bodies == cloth).all(axis=1)]
            assert np.array_equal(own, pf.pairs(fold)) and len(own) == 1
            assert not (hits.bodies == 0).all(axis=1).any()
            contacts = scene.contacts()
            at = contacts.segments[(contacts.bodies == cloth).all(axis=1)]
            assert np.allclose(at, pf.contacts(fold).segments + [0, 0, 2])


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
        pf.sweep(BALL, BALL, many, "volume")


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
        scene.add(BALL, many)
        on_gpu = scene.pairs()
    with pf.using(threads=1):
        assert np.array_equal(scene.pairs().pairs, on_gpu.pairs)
        other = pf.Scene()
        other.add(BALL, many)
        assert np.array_equal(other.pairs().bodies, on_gpu.bodies)
    with pytest.raises(ValueError):
        with pf.using(device="tpu"):
            pass


# The long run asks 10^5 of each test: PFRONT_EXAMPLES=100000 (8 minutes).
EXAMPLES = int(os.environ.get("PFRONT_EXAMPLES", "1000"))
relaxed = settings(max_examples=EXAMPLES, deadline=None, suppress_health_check=list(HealthCheck))
entries = st.one_of(st.integers(-2, 2).map(float), st.integers(-2, 2).map(float), st.floats(width=32))


def outcome(points, faces, pose):
    """All answers about arrays, or the kind of error."""
    try:
        mesh = pf.Mesh(points, faces)
        found = pf.pairs(mesh, mesh, pose)
    except (pf.MeshError, pf.PoseError, TypeError) as refused:
        return type(refused)
    listed = found.values if isinstance(found, pf.Ragged) else found
    contacts = pf.contacts(mesh, mesh, pose)
    assert len(contacts.values if isinstance(found, pf.Ragged) else contacts) == len(listed) == np.sum(pf.count(mesh, mesh, pose))
    assert np.any(pf.collides(mesh, mesh, pose)) == (len(listed) > 0) and len(pf.contacts(mesh)) == pf.count(mesh)
    return mesh.vertices.tolist(), mesh.faces.tolist(), listed.tolist()


@pytest.mark.filterwarnings("ignore:a mesh without faces")
@relaxed
@given(
    hnp.arrays(st.sampled_from([np.float32, np.float64, np.float16, np.int64, np.int8]),
               st.tuples(st.integers(0, 8), st.sampled_from([3, 3, 3, 3, 3, 2])), fill=st.nothing()),
    hnp.arrays(st.sampled_from([np.uint32, np.int64, np.int16]), st.tuples(st.integers(0, 8), st.just(3)), elements=st.integers(0, 9), fill=st.nothing()),
    hnp.arrays(st.sampled_from([np.float32, np.float64]), st.sampled_from([(4, 4), (3, 4), (2, 4, 4), (3, 3)]), elements=entries),
    st.sampled_from([True, True, True, False]),
    st.integers(0, 6),
)  # fmt: skip
def test_any_array_is_answered_or_refused_in_any_layout(points, faces, pose, is_small, layout):
    if is_small:
        # Numbers of which many coincide and most meshes are made.
        with np.errstate(all="ignore"):
            points = np.nan_to_num(points) % 3 if points.dtype.kind == "f" else points % 3
        faces = faces % max(len(points), 1)
        pose[..., :3, :3] = np.eye(3)
    if pose.shape[-2] == 4:
        pose[..., 3, :] = [0, 0, 0, 1]
    plain = outcome(points, faces, pose)
    assert outcome(*(list(layouts(array))[layout][1] for array in (points, faces, pose))) == plain


@pytest.mark.filterwarnings("ignore:in .* share a position")
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


def test_names_wherever_ids_are():
    scene, box = pf.Scene(), pf.Mesh(*pf._box())
    lid, _ = scene.add(box, name="lid"), scene.add(box, name="jar")
    twins = scene.add(box, np.stack([placed(x=9), placed(x=19)]), name="twin")
    assert scene.names(scene.intersecting_bodies()) == [["lid", "jar"]]
    assert scene.names(lid) == "lid" and scene.names([lid, twins[0]]) == ["lid", "twin"] and scene.names([]) == []
    scene.ignore("lid", "jar")
    assert not scene.collides()
    scene.ignore("lid", "jar", False)
    scene.set_poses(["lid", "jar"], np.stack([placed(x=30), placed(x=40)]))
    assert not scene.collides()
    scene.set_poses("lid", placed(x=40))
    assert scene.user_ids("jar") == 1 and scene.user_ids(["jar", "lid"]).tolist() == [1, 0]
    scene.set_mesh("lid", box.with_vertices(box.vertices * 3 + 1))
    assert scene.count() > 0
    scene.remove("lid")
    with pytest.raises(pf.StaleBody, match="no body of the scene has the name 'lid'"):
        scene.remove("lid")
    with pytest.raises(ValueError, match="2 bodies have the name 'twin': give their ids"):
        scene.set_poses("twin", placed())
    scene.remove(twins[0])
    scene.remove("twin")
    assert len(scene) == 1
    # Other names than strings stand for nothing, so that they may be anything.
    other = scene.add(box, name=["a", 1])
    assert scene.name(other) == ["a", 1]
    scene.remove(other)
    assert scene.name(other) is None


def test_rows_and_columns_of_hits():
    scene, box = pf.Scene(), pf.Mesh(*pf._box())
    first, second, third = scene.add(box), scene.add(box), scene.add(box)
    hits, found = scene.pairs(), scene.contacts()
    chosen = hits[hits.bodies[:, 1] == third]
    assert 0 < len(chosen) < len(hits) and set(chosen.bodies[:, 0]) == {first, second}
    assert np.array_equal(hits[2:5].pairs, hits.pairs[2:5])
    with pytest.raises(TypeError, match="hits are selected by slices"):
        hits[3]
    columns = hits.to_dict()
    assert list(columns) == ["body_a", "body_b", "face_a", "face_b"]
    assert np.array_equal(np.stack([columns["face_a"], columns["face_b"]], 1), hits.pairs)
    columns = found.to_dict()
    assert list(columns)[:4] == ["body_a", "body_b", "face_a", "face_b"] and len(columns["x1"]) == len(found)
    assert np.array_equal(np.stack([columns["x1"], columns["y1"], columns["z1"]], 1), found.segments[:, 1])


def test_the_version_is_that_of_the_package():
    from importlib.metadata import version

    assert pf.__version__ == version("pfront")
