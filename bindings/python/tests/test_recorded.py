"""Recorded truths: sets of pairs on which two independent programs agreed."""

import numpy as np
import pytest
from conftest import cases, data, read

import pfront as pf

pytestmark = pytest.mark.recorded


def truth(case):
    found = np.fromfile(data(f"oracle/{case['name']}.pairs.u32le"), "<u4").reshape(-1, 2)
    assert len(found) == case["pairs"]
    return found


def test_every_case_set_for_set():
    asked = 0
    for case in cases():
        (points, faces), (others, corners) = read(case["a"]), read(case["b"])
        world = data("oracle") / f"{case['name']}.b_world.f32le"
        if world.exists():
            others = np.fromfile(world, "<f4").reshape(-1, 3)
        else:
            # As it was posed when the pairs were recorded: in float32, step by step.
            r = np.array(case["rotation_row_major"], np.float32).reshape(3, 3)
            x, y, z = others.astype(np.float32).T
            t = np.array(case["translation"], np.float32)
            others = np.stack([((r[k, 0] * x + r[k, 1] * y) + r[k, 2] * z) + t[k] for k in range(3)], -1)
        a, b = pf.Mesh(points.astype(np.float32), faces), pf.Mesh(others, corners)
        expected = truth(case)
        for threads in (1, 2):
            with pf.using(threads=threads):
                assert np.array_equal(pf.pairs(a, b), expected), case["name"]
                assert pf.count(a, b) == len(expected)
                assert pf.collides(a, b) == (len(expected) > 0)
        joined = np.concatenate([pf.part(i, 5).pairs(a, b) for i in range(5)])
        assert np.array_equal(joined[np.lexsort(joined.T[::-1])], expected), case["name"]
        found = pf.contacts(a, b)
        assert np.array_equal(found.pairs, expected)
        asked += 1
    assert asked == 9


def test_float64_as_the_files_have_it():
    for a, b, in_f64, in_f32 in [
        ("Offset3.obj", "Offset4.obj", 29, 27),
        ("Havocglass8_left.obj", "Havocglass8_right.obj", 89, 95),
    ]:
        two = [read(f"nasty/{name}") for name in (a, b)]
        exact = [pf.Mesh(points, faces) for points, faces in two]
        assert [mesh.dtype for mesh in exact] == [np.float64] * 2
        assert pf.count(*exact) == in_f64 == len(pf.contacts(*exact)) == len(pf.pairs(*exact))
        assert pf.contacts(*exact).segments.dtype == np.float64
        assert pf.count(*(pf.Mesh(points.astype(np.float32), faces) for points, faces in two)) == in_f32


@pytest.mark.filterwarnings("ignore:in .* share a position")
def test_nasty_meshes():
    counts = [
        ("ballA.off", "ballB.off", 276),
        ("self_intersectA.obj", "self_intersectB.obj", 600),
        ("center_cylinder.obj", "offset_cylinder.obj", 72),
    ]
    for a, b, expected in counts:
        two = [read(f"nasty/{name}") for name in (a, b)]
        assert pf.count(*(pf.Mesh(points.astype(np.float32), faces) for points, faces in two)) == expected
    for name in ("ballA.off", "self_intersectA.obj", "wallhole.obj"):
        mesh = pf.Mesh(*read(f"nasty/{name}"))
        found = pf.pairs(mesh)
        assert len(found) == pf.count(mesh) == len(pf.contacts(mesh)) and (found[:, 0] < found[:, 1]).all()
        assert pf.collides(mesh) == (len(found) > 0)
