"""Answers do not depend on the floating-point environment of the caller, which a library may have changed."""

import platform
import subprocess
import sys

import pytest

pytestmark = pytest.mark.skipif(
    platform.machine() != "x86_64" or platform.libc_ver()[0] != "glibc", reason="sets MXCSR by fesetenv of glibc"
)

# Each setting of MXCSR: flushed results, subnormal operands as zeros, both, three roundings, and traps.
SETTINGS = {"ftz": 0x9F80, "daz": 0x1FC0, "ftz+daz": 0x9FC0, "down": 0x3F80, "up": 0x5F80, "to zero": 0x7F80, "traps": 0x0000}

SETUP = '''
import ctypes, sys, numpy as np, pfront as pf
libm = ctypes.CDLL("libm.so.6")
def set(mxcsr):
    """As a library does that is linked with -ffast-math, or a host that rounds otherwise."""
    environment = (ctypes.c_uint32 * 8)()
    libm.fegetenv(environment)
    environment[7] = mxcsr
    libm.fesetenv(environment)
def mxcsr():
    environment = (ctypes.c_uint32 * 8)()
    libm.fegetenv(environment)
    return environment[7] & 0xffc0
FACES = [[0, 1, 2]]
SCALES = {"f32": np.float32(1e-45), "f64": np.float64(5e-324)}
FLOOR = np.array([[0, 0, 0], [4, 0, 0], [0, 4, 0]])
BLADES = [np.array([[1, 1, z], [1, 2, z], [1, 1, 3]]) for z in (1, 0, -1)]
GRID = np.random.default_rng(3).random((900, 3)).astype(np.float32)
def soups():
    for kind in SCALES:
        scale = SCALES[kind]
        yield kind, [(points * scale).astype(type(scale)) for points in (FLOOR, *BLADES)]
ARRAYS = dict(soups())
SIDES = [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]]
CHIPS = [(np.array([[0, 0, 0], [size, 0, 0], [0, size, 0], [0, 0, size]]) * np.float32(1e-45)).astype(np.float32) for size in (3, 5)]
TINY = np.array([[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 1e-45], [0, 0, 0, 1]], np.float32)
TINY64 = TINY.astype(float)
LOW = np.eye(4); LOW[2, 3] = 5e-324
BAD = np.eye(4); BAD[3, 0] = 5e-324
THIRD = np.eye(4, dtype=np.float32); THIRD[:3, :3] /= 3
def answers(meshes=None, threads=1):
    """Every question."""
    found = []
    with pf.using(threads=threads):
        for kind, arrays in ARRAYS.items():
            floor, *blades = meshes[kind] if meshes else [pf.Mesh(points, FACES) for points in arrays]
            for blade in blades:
                for pose in (None, TINY, LOW, TINY64, np.stack([LOW, np.eye(4)]), np.stack([TINY] * 3)):
                    found.append(np.asarray(pf.count(floor, blade, pose)).tolist())
                    found.append(np.asarray(pf.collides(floor, blade, pose)).tolist())
                found.append(pf.pairs(floor, blade).tolist())
                found.append(pf.contacts(floor, blade).segments.view(np.uint32).tolist())
                found.append(len(pf.contacts(floor, blade).polylines()))
                gaps = pf.distance(floor, blade, np.stack([LOW, TINY64, np.eye(4)]), limit=1e-45)
                found.append([gaps.intervals.view(np.uint64).tolist(), gaps.points.view(np.uint64).tolist()])
            scene = pf.Scene()
            scene.add(floor), scene.add(blades[0]), scene.add(blades[1]), scene.add(blades[0], TINY)
            found += [scene.pairs().pairs.tolist(), scene.intersecting_bodies().tolist(), scene.count(), scene.collides(), len(scene.contacts())]
            nearest, gap = scene.distance(0)
            found += [nearest, np.array(gap.interval).view(np.uint64).tolist()]
            found.append(floor.with_vertices(arrays[1]).vertices.view(np.uint32).tolist())
        grid = (meshes or {}).get("grid") or pf.Mesh(GRID, np.arange(900).reshape(-1, 3))
        chip, chips = (meshes or {}).get("chips") or [pf.Mesh(points, SIDES) for points in CHIPS]
        for pose in (TINY, LOW, TINY64, np.stack([TINY64, np.eye(4)])):
            found += [np.asarray(pf.relation(chip, chips, pose, within=1e-45)).tolist(), np.asarray(pf.overlap_volume(chip, chips, pose)).view(np.uint64).tolist()]
        found.append(str(pf.check({"a": chip, "b": chips}, within=1e-45)))
        found.append(str(pf.check({"a": chip, "b": chips, "c": floor}).pairs))
        found += [pf.count(grid), pf.pairs(grid, grid, THIRD).tolist(), pf.count(grid, grid, np.stack([THIRD] * 40)).tolist()]
        found.append(pf.contacts(grid, grid, THIRD).segments.view(np.uint32).sum().tolist())
        try:
            found.append(pf.count(grid, grid, BAD))
        except pf.PoseError as refused:
            found.append(str(refused))
    return found
'''


@pytest.mark.parametrize("threads", [1, 2])
@pytest.mark.parametrize("setting", SETTINGS)
def test_every_question_under_every_setting(setting, threads):
    """Of meshes made before and under it, by pools made before and under it, and afterwards by a pool made under it."""
    code = SETUP + f"""
setting, threads = {SETTINGS[setting]}, {threads}
truth = answers(threads=3)
before = {{kind: [pf.Mesh(points, FACES) for points in arrays] for kind, arrays in ARRAYS.items()}}
before["grid"] = pf.Mesh(GRID, np.arange(900).reshape(-1, 3))
before["chips"] = [pf.Mesh(points, SIDES) for points in CHIPS]
set(setting)
if setting:
    found = [answers(threads=3), answers(threads=threads), answers(before, threads)]
else:
    # NumPy traps by itself, so only what asks nothing of it is called.
    floor, *blades = before["f32"]
    with pf.using(threads=threads):
        found = [pf.count(floor, blade) for blade in blades] + [pf.collides(floor, blades[0], TINY), pf.count(before["grid"])]
is_left_alone = mxcsr() == setting & 0xffc0
set(0x1f80)
after = answers(threads=threads)
if not setting:
    floor, *blades = before["f32"]
    assert found == [pf.count(floor, blade) for blade in blades] + [pf.collides(floor, blades[0], TINY), pf.count(before["grid"])]
    found = []
for name, one in zip(("old pool", "new pool", "old meshes", "afterwards"), [*found, after]):
    for i, (x, y) in enumerate(zip(one, truth)):
        assert x == y, (name, i, x, y)
assert is_left_alone, "the caller's setting is not what it was"
print("ok", len(truth))
"""
    ended = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, timeout=120)
    assert ended.returncode == 0 and ended.stdout.startswith("ok"), (ended.returncode, ended.stdout, ended.stderr[-900:])


