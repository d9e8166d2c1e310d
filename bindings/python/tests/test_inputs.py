"""What meshes and poses are made of, and what is refused."""

import pickle

import numpy as np
import pytest
from conftest import ball, layouts, placed, poses

import pfront as pf

POINTS, FACES = ball(12)


@pytest.mark.parametrize("kind", [np.float32, np.float64])
def test_layouts_of_vertices(kind):
    truth = pf.Mesh(POINTS, FACES)
    for name, points in layouts(POINTS.astype(kind)):
        mesh = pf.Mesh(points, FACES)
        assert np.array_equal(mesh.vertices, POINTS) and mesh.dtype == np.float32, name
        assert np.array_equal(pf.pairs(mesh, mesh), pf.pairs(truth, truth)), name


@pytest.mark.parametrize("kind", [np.uint32, np.int64, np.int32, np.uint64, np.uint16])
def test_layouts_of_faces(kind):
    for name, faces in layouts(FACES.astype(kind)):
        assert np.array_equal(pf.Mesh(POINTS, faces).faces, FACES), name


@pytest.mark.parametrize("kind", [np.float32, np.float64])
def test_layouts_of_poses(kind):
    mesh = pf.Mesh(POINTS, FACES)
    many = poses(6, kind=kind)
    truth = [pf.pairs(mesh, mesh, pose) for pose in many]
    assert sum(map(len, truth)) > 100
    for name, one in layouts(many):
        assert all(map(np.array_equal, pf.pairs(mesh, mesh, one), truth)), name
    for name, one in layouts(many[1]):
        assert np.array_equal(pf.pairs(mesh, mesh, one), truth[1]), name
        assert np.array_equal(pf.pairs(mesh, mesh, one[:3]), truth[1]), name


def test_float64_decides_where_float32_cannot():
    floor = pf.Mesh([[0.1, 0.1, 1000.1], [1.1, 0.1, 1000.1], [0.1, 1.1, 1000.1]], [[0, 1, 2]])
    assert floor.dtype == np.float64 and floor.vertices.dtype == np.float64
    assert pf.collides(floor, floor) and not pf.collides(floor, floor, placed(z=1e-9, kind=np.float64))
    small = pf.Mesh(np.eye(3, dtype=np.float32), [[0, 1, 2]])
    # float32 rounds the sum 1 + 1e-9 to 1, float64 does not.
    assert pf.collides(small, small, placed(x=1e-9)) != pf.collides(small, small, placed(x=1e-9, kind=np.float64))


@pytest.mark.filterwarnings("ignore:a mesh without faces")
def test_other_precisions_and_lists():
    assert pf.Mesh(POINTS.astype(np.float16), FACES).dtype == np.float32
    assert pf.Mesh([[0, 0, 0], [1, 0, 0], [0, 1, 0]], [(0, 1, 2)]).dtype == np.float32
    assert pf.Mesh((POINTS, FACES)).faces.dtype == np.uint32
    assert len(pf.pairs(pf.Mesh(np.empty((0, 3)), []), pf.Mesh(POINTS, FACES))) == 0


@pytest.mark.filterwarnings("ignore:a mesh without faces")
def test_errors_name_what_is_at_fault():
    def refused(kind, call, **names):
        with pytest.raises(kind) as caught:
            call()
        assert {name: getattr(caught.value, name) for name in names} == names
        again = pickle.loads(pickle.dumps(caught.value))
        assert type(again) is kind and {name: getattr(again, name) for name in names} == names

    bad = POINTS.copy()
    bad[7, 1] = np.nan
    refused(pf.MeshError, lambda: pf.Mesh(bad, FACES), vertex=7, face=None)
    refused(pf.MeshError, lambda: pf.Mesh(POINTS, [[0, 1, 2], [0, 1, 999]]), vertex=None, face=1)
    refused(pf.MeshError, lambda: pf.Mesh(POINTS, [[0, 1, 2], [0, -1, 2]]), face=1)
    refused(pf.MeshError, lambda: pf.Mesh(POINTS, [[0, 1, 2], [0, 2**32, 2]]), face=1)
    refused(pf.MeshError, lambda: pf.Mesh(POINTS, [[0, 1, 2, 3]]))
    refused(pf.MeshError, lambda: pf.Mesh(POINTS[:, :2], FACES))
    refused(pf.MeshError, lambda: pf.Mesh([[1e300, 0, 0]], []), vertex=0)
    mesh = pf.Mesh(POINTS, FACES)
    pose = placed()
    pose[1, 2] = np.inf
    refused(pf.PoseError, lambda: pf.collides(mesh, mesh, pose), row=1, pose=None)
    refused(pf.PoseError, lambda: pf.pairs(mesh, mesh, np.stack([placed(), pose])), row=1, pose=1)
    refused(pf.PoseError, lambda: list(pf.sweep(mesh, mesh, np.stack([placed()] * 5 + [pose]), chunk=3)), row=1, pose=5)
    with pytest.raises(pf.PoseError, match="^pose 5: .*row 1"):
        list(pf.sweep(mesh, mesh, np.stack([placed()] * 5 + [pose]), "count", chunk=2))
    refused(pf.PoseError, lambda: pf.count(mesh, mesh, np.ones((4, 4))), row=3)
    refused(pf.PoseError, lambda: pf.first(mesh, mesh, np.stack([placed(), placed()])))
    refused(pf.PoseError, lambda: pf.count(mesh, mesh, np.ones((2, 4, 4))), row=3, pose=0)
    refused(pf.PoseError, lambda: pf.count(mesh, mesh, np.ones(16)))
    refused(pf.BlobError, lambda: pf.Mesh(pf._mesh._from_blob(b"", b"no blob at all" * 20)))
    for wrong in (lambda: pf.Mesh(POINTS.astype(complex), FACES), lambda: pf.Mesh(POINTS, FACES + 0.5),
                  lambda: pf.collides(mesh, mesh, np.full((4, 4), "x")), lambda: pf.collides(mesh, None, placed()),
                  lambda: pf.Mesh(object()), lambda: pf.Mesh(np.array([["a", "b", "c"]]), [])):  # fmt: skip
        with pytest.raises(TypeError):
            wrong()


def test_meshes_of_others(tmp_path):
    import meshio
    import pyvista
    import trimesh

    truth = pf.Mesh(POINTS, FACES)
    tri = trimesh.Trimesh(POINTS, FACES, process=False)
    path = tmp_path / "ball.ply"
    tri.export(path)
    io = meshio.Mesh(POINTS, [("triangle", FACES[:30]), ("triangle", FACES[30:])])
    vtk = pyvista.PolyData.from_regular_faces(POINTS, FACES)
    for source in (tri, vtk, io, (POINTS, FACES), path, str(path), truth):
        mesh = pf.Mesh(source)
        assert np.array_equal(mesh.vertices, POINTS) and np.array_equal(mesh.faces, FACES), type(source)
    cube = pf.Mesh(pyvista.Cube())
    assert len(cube.faces) == 12 and len(cube.vertices) >= 8
    quads = meshio.Mesh(np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0.0]]), [("quad", np.array([[0, 1, 2, 3]]))])
    assert pf.Mesh(quads).faces.tolist() == [[0, 1, 2], [0, 2, 3]]
    with pytest.raises(FileNotFoundError):
        pf.Mesh(tmp_path / "none.stl")


@pytest.mark.parametrize("points", [POINTS, POINTS + 0.1])
def test_files_and_pickles(tmp_path, points):
    mesh = pf.Mesh(points.astype(np.float64) if points is not POINTS else points, FACES)
    mesh.save(tmp_path / "ball.pfb")
    read = pf.load(tmp_path / "ball.pfb")
    assert np.array_equal(read.vertices, mesh.vertices) and read.dtype == mesh.dtype
    assert np.array_equal(pf.pairs(pf.Mesh(tmp_path / "ball.pfb"), mesh), pf.pairs(mesh, mesh))
    broken = bytearray((tmp_path / "ball.pfb").read_bytes())
    broken[len(broken) // 2] ^= 1
    (tmp_path / "broken.pfb").write_bytes(broken)
    with pytest.raises(pf.BlobError):
        pf.load(tmp_path / "broken.pfb")
    buffers = []
    small = pickle.dumps(mesh, protocol=5, buffer_callback=buffers.append)
    assert len(small) < 200 and len(buffers) == 1
    again = pickle.loads(small, buffers=buffers)
    assert np.array_equal(again.faces, mesh.faces) and pickle.loads(small, buffers=buffers) is again
    assert np.array_equal(pickle.loads(pickle.dumps(mesh, protocol=4)).vertices, mesh.vertices)


def test_arrays_of_a_mesh_are_read_only_and_its_own():
    points = POINTS.copy()
    mesh = pf.Mesh(points, FACES)
    points[:] = 0
    assert np.array_equal(mesh.vertices, POINTS)
    with pytest.raises(ValueError):
        mesh.vertices[0] = 1


def test_user_ids_fit():
    """A user id beyond int64 is refused, not wrapped."""
    with pytest.raises(ValueError, match="int64"):
        pf.Scene().add(pf.Mesh(*pf._box()), user_id=2**63 + 5)
