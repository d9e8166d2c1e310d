"""An answer or a mesh that does not fit into memory is a MemoryError, and the interpreter goes on."""

import subprocess
import sys

import pytest

SETUP = """
import pickle, resource, numpy as np, pfront as pf
def limit(megabytes):
    "So much more than what is there."
    pages = int(open("/proc/self/statm").read().split()[0])
    size = pages * resource.getpagesize() + (megabytes << 20)
    resource.setrlimit(resource.RLIMIT_AS, (size, size))
V = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0]], np.float32)
def soup(n):
    return pf.Mesh(np.tile(V, (n, 1)), np.arange(3 * n).reshape(-1, 3))
def random(n, kind):
    return np.random.default_rng(0).random((3 * n, 3)).astype(kind), np.arange(3 * n).reshape(-1, 3)
def spread(n):
    poses = np.tile(np.eye(4, dtype=np.float32), (n, 1, 1))
    poses[:, 2, 3] = 5
    return poses
small = soup(10)
with pf.using(threads=THREADS):
    pf.pairs(soup(300), soup(300), np.tile(np.eye(4, dtype=np.float32), (3, 1, 1)))
"""
CASES = {
    "pairs": "m = soup(5000); ask = lambda: pf.pairs(m, m); limit(150)",
    "pairs within": "m = soup(7000); ask = lambda: pf.pairs(m); limit(150)",
    "pairs of a part": "m = soup(5000); ask = lambda: pf.part(0, 1).pairs(m, m); limit(150)",
    "pairs of many poses": "m = soup(2000); P = np.stack([np.eye(4)] * 10); ask = lambda: pf.pairs(m, m, P); limit(250)",
    "contacts": "m = soup(2500); ask = lambda: pf.contacts(m, m); limit(250)",
    "contacts of many poses": "m = soup(1000); P = np.stack([np.eye(4)] * 10); ask = lambda: pf.contacts(m, m, P); limit(300)",
    "distances of many poses": "P = spread(1_000_000); ask = lambda: pf.distance(small, small, P); limit(150)",
    "a solid": "m = pf.Mesh(*random(1_000_000, np.float64)); ask = lambda: pf.relation(m, m); limit(20)",
    "solids of a scene": "m = pf.Mesh(*random(1_000_000, np.float64)); s = pf.Scene(); s.add(m); s.add(m); ask = s.check; limit(20)",
    "scene pairs": "m = soup(4000); s = pf.Scene(); s.add(m); s.add(m); ask = s.pairs; limit(250)",
    "scene contacts": "m = soup(2000); s = pf.Scene(); s.add(m); s.add(m); ask = s.contacts; limit(300)",
    "mesh": "V, F = random(2_000_000, np.float32); ask = lambda: pf.Mesh(V, F); limit(200)",
    "mesh in float64": "V, F = random(2_000_000, np.float64); ask = lambda: pf.Mesh(V, F); limit(300)",
    "poses": "P = np.broadcast_to(spread(1), (4_000_000, 4, 4)); ask = lambda: pf.collides(small, small, P); limit(500)",
    "bodies": "P = np.broadcast_to(spread(1), (4_000_000, 4, 4)); s = pf.Scene(); ask = lambda: s.add(small, P); limit(500)",
    "blob": "m = pf.Mesh(*random(500_000, np.float64)); ask = lambda: pickle.dumps(m); limit(50)",
    "vertices": "m = pf.Mesh(*random(1_500_000, np.float64)); ask = lambda: m.vertices; limit(20)",
    "with_vertices": "V, F = random(1_000_000, np.float64); m = pf.Mesh(V, F); V *= 2; ask = lambda: m.with_vertices(V); limit(20)",
}


@pytest.mark.parametrize("kind, threads", [(kind, threads) for kind in CASES for threads in ((1, 2) if kind.startswith("pairs") else (2,))])
def test_what_does_not_fit_is_a_memory_error(kind, threads):
    code = SETUP.replace("THREADS", str(threads)) + CASES[kind] + f"""
with pf.using(threads={threads}):
    try:
        ask()
        print("it did fit")
    except MemoryError as error:
        resource.setrlimit(resource.RLIMIT_AS, (resource.getrlimit(resource.RLIMIT_AS)[1],) * 2)
        del ask
        print("MemoryError", pf.count(small, small))
"""
    ended = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, timeout=120)
    assert ended.returncode == 0 and ended.stdout.strip() == "MemoryError 100", (ended.returncode, ended.stdout, ended.stderr[-600:])
