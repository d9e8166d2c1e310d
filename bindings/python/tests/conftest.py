"""Data and shapes of the tests. Recorded data lies in PFRONT_DATA, or in shared/data beside the checkout."""

import json
import os
import pathlib

import numpy as np
import pytest

import pfront as pf

TOP = pathlib.Path(__file__).resolve().parents[3]
DATA = pathlib.Path(os.environ.get("PFRONT_DATA") or TOP.parent / "shared" / "data")


def data(name):
    path = DATA / name
    if not path.exists():
        pytest.fail(f"no {path}: set PFRONT_DATA to the folder with oracle/cases.json, or leave out: -m 'not recorded'")
    return path


def read(name):
    """Vertices as float64, exactly as the file has them, and faces of OBJ, OFF and PLY files, without pfront."""
    path = data(name)
    if path.suffix in (".ply", ".stl"):
        import trimesh

        found = trimesh.load(path, process=False)
        return np.asarray(found.vertices), np.asarray(found.faces)
    lines = path.read_text().splitlines()
    if path.suffix == ".obj":
        points = [line.split()[1:4] for line in lines if line.startswith("v ")]
        faces = [[int(word.split("/")[0]) - 1 for word in line.split()[1:4]] for line in lines if line.startswith("f ")]
        return np.array(points, float), np.array(faces)
    words = [line.split() for line in lines if line.strip() and not line.startswith("#")]
    assert words[0] == ["OFF"]
    count = int(words[1][0])
    return np.array([row[:3] for row in words[2 : 2 + count]], float), np.array([row[1:4] for row in words[2 + count :]], int)


def cases():
    return json.loads(data("oracle/cases.json").read_text())


@pytest.fixture
def box():
    return pf.Mesh(*pf._box())


def ball(count=20, radius=1.0):
    """A sphere of rings, float32."""
    u, v = np.meshgrid(np.linspace(0, 2 * np.pi, count, endpoint=False), np.linspace(0.1, np.pi - 0.1, count))
    points = np.stack([np.cos(u) * np.sin(v), np.sin(u) * np.sin(v), np.cos(v)], -1).reshape(-1, 3) * radius
    rows, columns = np.meshgrid(np.arange(count - 1), np.arange(count), indexing="ij")
    a, b = rows * count + columns, rows * count + (columns + 1) % count
    faces = np.concatenate([np.stack([a, b, a + count], -1).reshape(-1, 3), np.stack([b, b + count, a + count], -1).reshape(-1, 3)])
    return points.astype(np.float32), faces.astype(np.uint32)


def heap(count=1500, seed=7):
    """Triangles of which almost all meet: count^2 pairs of the heap and itself."""
    rng = np.random.default_rng(seed)
    p, q = rng.uniform(-9, 9, (2, count, 3))
    r = rng.uniform(-0.01, 0.01, (count, 3)) - p - q
    return np.stack([p, q, r], 1).reshape(-1, 3).astype(np.float32), np.arange(3 * count).reshape(-1, 3)


def placed(x=0.0, y=0.0, z=0.0, kind=np.float32):
    pose = np.eye(4, dtype=kind)
    pose[:3, 3] = x, y, z
    return pose


def poses(count, seed=0, spread=2.0, kind=np.float32):
    """Random rigid poses."""
    rng = np.random.default_rng(seed)
    turns, _ = np.linalg.qr(rng.normal(size=(count, 3, 3)))
    found = np.tile(np.eye(4), (count, 1, 1))
    found[:, :3, :3], found[:, :3, 3] = turns, rng.uniform(-spread, spread, (count, 3))
    return found.astype(kind)


def layouts(array):
    """The same numbers in every layout that NumPy has."""
    yield "C", np.ascontiguousarray(array)
    yield "F", np.asfortranarray(array)
    yield "strided", np.repeat(array, 2, axis=0)[::2]
    yield "reversed", array[::-1][::-1]
    yield "big-endian", array.astype(array.dtype.newbyteorder(">"))
    raw = np.empty(array.nbytes + 1, np.uint8)
    misaligned = raw[1:].view(array.dtype).reshape(array.shape)
    misaligned[...] = array
    assert not misaligned.flags.aligned or array.itemsize == 1 or array.size == 0
    yield "misaligned", misaligned
    frozen = array.copy()
    frozen.flags.writeable = False
    yield "read-only", frozen
