"""What is given is copied at the call; what cannot be tested as it is given is refused."""

import os
import pickle

import numpy as np
import pytest
from conftest import ball, placed, poses

import pfront as pf

POINTS, FACES = ball(12)
MESH = pf.Mesh(POINTS, FACES)


def spoiled(array):
    """The same array with other numbers in it, as a caller leaves it who uses it again."""
    array[...] = 0 if array.dtype.kind in "iu" else np.nan


@pytest.mark.parametrize("kind", [np.float32, np.float64])
def test_meshes_and_poses_are_copied_when_they_are_given(kind):
    points, faces = POINTS.astype(kind), FACES.copy()
    mesh = pf.Mesh(points, faces)
    moved = points * 2
    grown = mesh.with_vertices(moved)
    spoiled(points), spoiled(faces), spoiled(moved)
    assert np.array_equal(mesh.vertices, POINTS) and np.array_equal(mesh.faces, FACES) and np.array_equal(grown.vertices, POINTS * 2)
    scene, pose, many, user_ids = pf.Scene(), placed(0.5, kind=kind), poses(3, spread=1, kind=kind), np.arange(3)
    scene.add(mesh, pose)
    ids = scene.add(mesh, many, user_id=user_ids)
    truth = scene.count()
    spoiled(pose), spoiled(many), spoiled(user_ids)
    assert scene.count() == truth == len(scene.pairs()) and scene.user_ids(ids).tolist() == [0, 1, 2]
    pose, many = placed(9, kind=kind), np.stack([placed(20 * i, kind=kind) for i in (1, 2, 3)])
    scene.set_poses([0], pose)
    scene.set_poses(ids, many)
    spoiled(pose), spoiled(many)
    assert scene.count() == 0


@pytest.mark.parametrize("rows", [3, 4])
@pytest.mark.parametrize("kind", [np.float32, np.float64])
@pytest.mark.parametrize("executor", [None, "threads"])
def test_a_sweep_copies_its_poses_at_the_call(rows, kind, executor):
    import concurrent.futures

    many = np.ascontiguousarray(poses(40, kind=kind)[:, :rows])
    truth = pf.collides(MESH, MESH, many).tolist()
    assert True in truth and False in truth
    with concurrent.futures.ThreadPoolExecutor(2) as pool:
        answers = pf.sweep(MESH, MESH, many, chunk=7, window=2, executor=pool if executor else None)
        spoiled(many)
        assert [hit for _, hit in answers] == truth


@pytest.mark.parametrize("kind", [np.float32, np.float64])
def test_a_progress_function_may_overwrite_the_poses(kind):
    many = poses(40_000, kind=kind)
    truth = pf.collides(MESH, MESH, many)
    assert np.array_equal(pf.collides(MESH, MESH, many, progress=lambda *_: spoiled(many)), truth)


def test_the_manager_copies_its_transforms():
    manager, pose = pf.compat.CollisionManager(), np.eye(4)
    manager.add_object("a", MESH, pose)
    spoiled(pose)
    assert manager.in_collision_single(MESH) is True
    pose = placed(9, kind=np.float64)
    manager.set_transform("a", pose)
    pose[...] = np.eye(4)
    assert manager.in_collision_single(MESH) is False and manager.in_collision_internal() is False


def test_arrays_of_a_mesh_stay_read_only():
    for array in (MESH.vertices, MESH.faces):
        with pytest.raises(ValueError):
            array[0] = 1
        with pytest.raises(ValueError):
            array.flags.writeable = True


def test_masked_arrays_are_refused():
    masked = np.ma.masked_array(POINTS, mask=False)
    scene = pf.Scene()
    body = scene.add(MESH)
    identity = np.ma.masked_array(np.eye(4), mask=False)
    for refused in (lambda: pf.Mesh(masked, FACES), lambda: pf.Mesh(POINTS, np.ma.masked_array(FACES)), lambda: pf.Mesh(list(masked), FACES),
                    lambda: MESH.with_vertices(masked), lambda: pf.collides(MESH, MESH, identity), lambda: scene.add(MESH, identity),
                    lambda: pf.count(MESH, MESH, identity.astype(np.float32)), lambda: pf.sweep(MESH, MESH, identity[None]),
                    lambda: scene.set_poses([body], identity), lambda: scene.set_poses(np.ma.masked_array([body]), np.eye(4))):  # fmt: skip
        with pytest.raises(TypeError, match="masked array.*filled"):
            refused()


def test_parts_and_other_integers_that_are_none_are_refused():
    for i, n in [(0, 0), (5, 3), (-1, 3), (0, 65537), (0, 2**62), (2**70, 2**71)]:
        with pytest.raises(ValueError, match="0 ≤ i < n"):
            pf.Part(i, n)
        with pytest.raises(ValueError):
            pf.part(i, n)
    assert pf.Part(np.int64(1), 3) == pf.part(1, np.uint8(3))
    some = pf.pairs(MESH, MESH, poses(3))
    for refused in (lambda: pf.part(0.5, 2), lambda: pf.part(0, "2"), lambda: some[1.5], lambda: pf.sweep(MESH, MESH, poses(3), chunk=1.5),
                    lambda: pf.sweep(MESH, MESH, poses(3), window=2.0), lambda: pf.Scene().name(0.5), lambda: pf.Scene().remove(0.0)):  # fmt: skip
        with pytest.raises(TypeError):
            refused()


@pytest.mark.parametrize("id", [-1, 1, 99, 2**40, 2**63, 2**64, 2**64 - 1, -(2**70)])
def test_ids_out_of_range_are_bodies_that_are_not_there(id):
    scene = pf.Scene()
    body = scene.add(MESH)
    for refused in (lambda: scene.remove(id), lambda: scene.set_mesh(id, MESH), lambda: scene.ignore(id, body), lambda: scene.ignore(body, id),
                    lambda: scene.user_ids([body, id]), lambda: scene.user_ids(id), lambda: scene.set_poses([id], np.eye(4)),
                    lambda: scene.set_poses(id, np.eye(4))):  # fmt: skip
        with pytest.raises(pf.StaleBody, match=f"body {id} is not in the scene") as caught:
            refused()
        assert "split" not in str(caught.value)
    with pytest.raises(pf.StaleBody) as caught:
        scene.set_poses([body, id], np.stack([np.eye(4)] * 2))
    assert caught.value.pose == 1 and len(scene) == 1


def test_errors_of_files_and_of_last_rows_name_them(tmp_path):
    with pytest.raises(FileNotFoundError) as caught:
        pf.Mesh(tmp_path / "nope.obj")
    assert "No such file" in str(caught.value) and caught.value.filename == str(tmp_path / "nope.obj")
    many = poses(5)
    many[3, 3, 0] = 7
    with pytest.raises(pf.PoseError, match="pose 3: .*row 3"):
        pf.collides(MESH, MESH, many)


def test_a_mesh_without_faces_warns():
    with pytest.warns(UserWarning, match="without faces"):
        pf.Mesh(POINTS, [])


class Named(pf.Mesh):
    __slots__ = ("slot",)

    def __init__(self, *arrays, name):
        super().__init__(*arrays)
        self.name = name
        self.slot = [name]


@pytest.mark.parametrize("protocol", [2, 4, 5])
def test_pickles_and_copies_are_of_the_same_kind(protocol):
    import copy

    named, tagged = Named(POINTS, FACES, name="cup"), pf.Mesh(POINTS, FACES)
    named.vertices, named.faces, pickle.dumps(named)
    tagged.tag = "tag"
    for again in (pickle.loads(pickle.dumps(named, protocol)), copy.copy(named), copy.deepcopy(named)):
        assert type(again) is Named and again.name == "cup" and again.slot == ["cup"] and np.array_equal(again.vertices, named.vertices)
        assert pf.pairs(again, MESH, placed(0.5)).shape == pf.pairs(MESH, MESH, placed(0.5)).shape
    assert copy.copy(named).slot is named.slot and copy.deepcopy(named).slot is not named.slot
    for again in (pickle.loads(pickle.dumps(tagged, protocol)), copy.copy(tagged)):
        assert type(again) is pf.Mesh and again.tag == "tag"
    plain = pickle.loads(pickle.dumps(pf.Mesh(POINTS, FACES), protocol))
    assert type(plain) is pf.Mesh and not hasattr(plain, "tag") and not hasattr(plain, "name")


def test_scenes_are_neither_copied_nor_pickled():
    import copy

    manager = pf.compat.CollisionManager()
    for refused in (copy.copy, copy.deepcopy, pickle.dumps):
        for one in (pf.Scene(), manager):
            with pytest.raises(TypeError, match="scene"):
                refused(one)


def test_a_pickled_mesh_keeps_no_blob():
    import gc
    import tracemalloc

    mesh = pf.Mesh(*ball(60))
    size = len(pickle.dumps(mesh))
    tracemalloc.start()
    try:
        pickle.dumps(mesh)
        gc.collect()
        kept, most = tracemalloc.get_traced_memory()
    finally:
        tracemalloc.stop()
    assert size > 200_000 and most > size and kept < size / 10


def test_a_save_that_fails_leaves_the_file_that_was_there(tmp_path):
    import resource
    import stat

    path = tmp_path / "ball.pfb"
    MESH.save(path)
    path.chmod(0o640)
    good, large = path.read_bytes(), pf.Mesh(*ball(40))
    limits = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (len(good) // 2, limits[1]))
    try:
        with pytest.raises(OSError) as caught:
            large.save(path)
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, limits)
    assert caught.value.filename == str(path) and path.read_bytes() == good and os.listdir(tmp_path) == ["ball.pfb"]
    with pytest.raises(FileNotFoundError) as caught:
        large.save(tmp_path / "none" / "ball.pfb")
    assert caught.value.filename == str(tmp_path / "none" / "ball.pfb")
    (tmp_path / "link.pfb").symlink_to(path)
    large.save(tmp_path / "link.pfb")
    assert (tmp_path / "link.pfb").is_symlink() and len(pf.load(path).faces) == len(large.faces)
    assert stat.S_IMODE(path.stat().st_mode) == 0o640 and sorted(os.listdir(tmp_path)) == ["ball.pfb", "link.pfb"]
    large.save(os.devnull)
