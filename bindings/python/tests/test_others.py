"""What takes the place of other libraries, and what they draw."""

import subprocess
import sys

import numpy as np
import pytest
from conftest import TOP, ball, placed, poses

import pfront as pf


def test_the_manager_answers_as_trimesh_is_used():
    import trimesh

    mesh = trimesh.Trimesh(*ball(12), process=False)
    manager = pf.compat.CollisionManager()
    for name, x in [("a", 0), ("b", 1.0), ("c", 5)]:
        manager.add_object(name, mesh, placed(x))
    assert manager.in_collision_internal() is True
    assert manager.in_collision_internal(return_names=True) == (True, {("a", "b")})
    hit, names, data = manager.in_collision_internal(return_names=True, return_data=True)
    truth = pf.count(mesh, mesh, placed(1.0))
    assert hit and names == {("a", "b")} and len(data) == truth and data[0].names == {"a", "b"}
    assert data[0].index("a") >= 0 and data[0].point.shape == (3,)
    assert manager.in_collision_single(mesh, placed(5.5), return_names=True) == (True, {"c"})
    other = pf.compat.CollisionManager()
    other.add_object("d", mesh, placed(-1))
    assert manager.in_collision_other(other, return_names=True) == (True, {("a", "d")})
    assert len(manager.in_collision_other(other, return_data=True)[1]) > 10
    manager.set_transform("b", placed(9))
    assert manager.in_collision_internal() is False
    manager.remove_object("b")
    with pytest.raises(ValueError):
        manager.set_transform("b", placed())


def test_objects_of_one_manager_are_not_asked_about_each_other():
    mesh = pf.Mesh(*ball(12))
    manager, other = pf.compat.CollisionManager(), pf.compat.CollisionManager()
    for i in range(4):
        manager.add_object(f"own {i}", mesh, placed(0.1 * i))
        other.add_object(f"other {i}", mesh, placed(0.1 * i + 1.7))
    across, _ = manager._scene._across(other._scene, True)
    owners = across.user_ids(across.intersecting_bodies()).tolist()
    assert manager.in_collision_internal() and other.in_collision_internal() and owners
    found = manager.in_collision_other(other, return_names=True)
    expected = {
        (f"own {i}", f"other {j}")
        for i in range(4)
        for j in range(4)
        if pf.collides(mesh, mesh, placed(0.1 * j + 1.7 - 0.1 * i))
    }
    assert found == (True, expected) and len(owners) == len(expected) < 16
    assert manager.in_collision_single(mesh, placed(9)) is False


def test_a_picture_has_red_pixels_where_meshes_meet(tmp_path):
    from matplotlib import image

    a = pf.Mesh(*ball(16))
    red = []
    for x in (0.7, 3.0):
        found = pf.show(a, a, placed(x), off_screen=True, screenshot=tmp_path / "picture.png")
        pixels = image.imread(tmp_path / "picture.png")[..., :3]
        red.append(int(((pixels[..., 0] > 0.6) & (pixels[..., 1:].max(-1) < 0.3)).sum()))
        assert (len(found) > 0) == (x < 2)
    assert red[0] > 100 and red[1] == 0, red


def test_the_accessor_follows_its_mesh():
    import pyvista

    pf.register()
    points, faces = ball(12)
    mesh = pyvista.PolyData.from_regular_faces(points, faces)
    assert mesh.pfront.collides(mesh) and mesh.pfront.count() == 0
    assert mesh.pfront.mesh is mesh.pfront.mesh and len(mesh.pfront.contacts(mesh, placed(0.5))) == len(mesh.pfront.pairs(mesh, placed(0.5)))
    before = mesh.pfront.mesh
    mesh.points = mesh.points + np.float32(9)
    assert mesh.pfront.mesh is not before and not mesh.pfront.collides((points, faces))


def test_a_scene_of_trimesh_keeps_its_names_and_poses():
    import trimesh

    world, box = trimesh.Scene(), trimesh.creation.box()
    for i, x in enumerate([0, 1, 2.5]):
        world.add_geometry(box, node_name=f"box {i}", geom_name="box", transform=placed(x))
    world.add_geometry(trimesh.load_path([[0, 0, 0], [1, 1, 1]]), node_name="wire")
    with pytest.warns(UserWarning, match="wire is no mesh"):
        scene = pf.Scene.from_trimesh(world)
    assert len(scene) == 3 and scene.names(scene.intersecting_bodies()) == [["box 0", "box 1"]]


def test_rotations_and_transforms_of_scipy_are_poses():
    from scipy.spatial.transform import RigidTransform, Rotation

    mesh, turns = pf.Mesh(*ball(12)), Rotation.random(5, rng=1)
    moves = RigidTransform.from_components(poses(5, spread=0.3)[:, :3, 3], turns)
    for many, matrices in [(turns, np.tile(np.eye(4), (5, 1, 1))), (moves, moves.as_matrix())]:
        matrices[:, :3, :3] = turns.as_matrix()
        assert pf.count(mesh, mesh, many).tolist() == pf.count(mesh, mesh, matrices).tolist()
        assert pf.count(mesh, mesh, many[2]) == pf.count(mesh, mesh, matrices[2]) > 0
    scene = pf.Scene()
    assert scene.add(mesh, moves).tolist() == [0, 1, 2, 3, 4]


def test_without_pyvista_a_picture_says_what_to_install(monkeypatch):
    monkeypatch.setitem(sys.modules, "pyvista", None)
    scene = pf.Scene()
    scene.add(pf.Mesh(*ball(12)))
    for draw in (scene.show, lambda: pf.show(ball(12)), pf.register):
        with pytest.raises(ImportError, match="pip install pyvista"):
            draw()


def test_a_clash_check_names_the_parts_and_draws_them(tmp_path):
    import trimesh
    from matplotlib import image

    world = trimesh.Scene()
    for i in range(40):
        place = placed(2 * (i % 8), 2 * (i // 8), 0.25 * (i % 3))
        place[0, 3] -= 1.5 * (i in (3, 21))
        world.add_geometry(trimesh.creation.box(), node_name=f"part {i}", transform=place)
    world.export(tmp_path / "assembly.glb")
    example = [sys.executable, TOP / "bindings/python/examples/clash.py", "assembly.glb", "clash.png"]
    told = subprocess.run(example, cwd=tmp_path, capture_output=True, text=True)
    lines = told.stdout.splitlines()
    assert told.returncode == 1 and lines[-1] == "40 parts, 2 clashes", told
    assert [line[:33].split("  ")[0] for line in lines[:-1]] == ["part 2", "part 20"]
    pixels = image.imread(tmp_path / "clash.png")[..., :3]
    assert ((pixels[..., 0] > 0.6) & (pixels[..., 1:].max(-1) < 0.3)).sum() > 20
