"""Files are read as the command reads them; what is passed over is a warning."""

import struct
import warnings

import numpy as np
import pytest

import pfront as pf

CUBE = [(x, y, z) for x in (0, 1) for y in (0, 1) for z in (0, 1)]
QUADS = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
BLADE = pf.Mesh([[0.25, 0.5, 0.5], [0.375, 0.5, 0.5], [0.25, 0.75, 2]], [[0, 1, 2]])
TRIANGLES = [[a, b, c] for q in QUADS for a, b, c in ((q[0], q[1], q[2]), (q[0], q[2], q[3]))]
TRUTH = len(pf.pairs(pf.Mesh(CUBE, TRIANGLES), BLADE))


def off():
    lines = ["OFF", "8 6 0", *(" ".join(map(str, p)) for p in CUBE), *("4 " + " ".join(map(str, q)) for q in QUADS)]
    return "\n".join(lines) + "\n"


def obj(face="{0}"):
    vertices = "".join(f"v {x} {y} {z}\n" for x, y, z in CUBE)
    return vertices + "".join("f " + " ".join(face.format(v + 1) for v in q) + "\n" for q in QUADS)


def stl(count=None):
    triangles = [struct.pack("<3f", 0, 0, 0) + b"".join(struct.pack("<3f", *CUBE[v]) for v in t) + bytes(2) for t in TRIANGLES]
    return bytes(80) + struct.pack("<I", len(triangles) if count is None else count) + b"".join(triangles)


FILES = [
    ("cube.off", off(), None),
    ("cube.obj", obj(), None),
    ("cube.obj", obj("{0}/{0}/{0}"), None),
    ("cube.STL", stl(), None),
    ("cube.stl", stl() + b"\n", "bytes after the last triangle are passed over: 1"),
    ("cube.stl", stl(count=0), "counts 0 triangles"),
    ("glued.off", off().replace("OFF\n", "OFF"), "no space after OFF"),
    ("lower.off", off().lower(), "capitals"),
    ("line.off", off().replace("\n", " "), "follow the counts"),
    ("edge.obj", obj() + "f 1 2\n", "one or two corners"),
    ("nan.obj", obj() + "v nan 0 0\n", "not finite"),
]


@pytest.mark.parametrize("name, content, note", FILES)
def test_files_are_read_as_the_command_reads_them(tmp_path, name, content, note):
    path = tmp_path / name
    path.write_bytes(content if isinstance(content, bytes) else content.encode())
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        mesh = pf.Mesh(path)
    assert len(pf.pairs(mesh, BLADE)) == TRUTH == 1
    assert len(pf.pairs(mesh)) == 0
    assert [note in str(warning.message) and str(path) in str(warning.message) for warning in caught] == [True] * (note is not None)
    assert all(warning.filename == __file__ for warning in caught)


def test_faces_of_any_shape(tmp_path):
    # An L, and a pin through its notch.
    path = tmp_path / "plate.obj"
    path.write_text("v 0 0 0\nv 0 3 0\nv 1 3 0\nv 1 1 0\nv 3 1 0\nv 3 0 0\nf 2 3 4 5 6 1\n")
    plate = pf.Mesh(str(path))
    pin = pf.Mesh([[2, 2, -1], [2.5, 2, -1], [2, 2.5, 1]], [[0, 1, 2]])
    assert not pf.collides(plate, pin) and not pf.collides(plate)
    corners = plate.vertices[plate.faces]
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    assert np.abs(normals[:, 2]).sum() / 2 == 5


def test_what_is_lost_is_refused(tmp_path):
    for name, content, why in [
        ("short.stl", stl()[:-1], "684 bytes, not 683"),
        ("nan.obj", obj().replace("v 0 0 0", "v nan 0 0"), "line 1: vertex 0 has a NaN"),
        ("empty.obj", "v 0 0 0\n", "no triangle"),
        ("words.txt", "words", "unknown format"),
        ("stray.off", off().replace("4 0 1 3 2", "4 0 1 3 9"), "line 11: there is no vertex 9"),
    ]:
        path = tmp_path / name
        path.write_bytes(content if isinstance(content, bytes) else content.encode())
        with pytest.raises(pf.MeshError, match=why) as caught:
            pf.Mesh(path)
        assert str(path) in str(caught.value)
    with pytest.raises(FileNotFoundError) as caught:
        pf.Mesh(tmp_path / "none.stl")
    assert caught.value.filename == str(tmp_path / "none.stl")
    with pytest.raises(OSError):
        pf.Mesh(tmp_path)


def test_bodies_of_a_file(tmp_path):
    path = tmp_path / "two.obj"
    path.write_text("o lid\n" + obj() + "o box\nf 1 2 4\n")
    found = pf.bodies(path)
    assert list(found) == ["lid", "box"] and len(found["lid"].faces) == 12
    assert found["box"].vertices.tolist() == [[0, 0, 0], [0, 0, 1], [0, 1, 1]]
    assert len(pf.Mesh(path).faces) == 13
    path.write_text(obj())
    assert list(pf.bodies(path)) == ["two.obj"]


def test_split_vertices_are_told():
    points = np.array(CUBE, np.float32)[np.array(TRIANGLES).ravel()]
    soup = pf.Mesh(points, np.arange(36).reshape(-1, 3))
    with pytest.warns(UserWarning, match="share a position, but no vertex"):
        pf.pairs(soup)
