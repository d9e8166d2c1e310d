"""explain() names those who have worked: the threads whose processor time grew."""

import collections
import os
import sys

import numpy as np
import pytest
from conftest import ball, heap, poses

import pfront as pf

pytestmark = pytest.mark.skipif(sys.platform != "linux", reason="reads /proc")
BALL = pf.Mesh(*ball(16))


def worked():
    """Nanoseconds by who worked: the threads of the pool, those of a software device, and all others."""
    times = collections.Counter()
    for task in os.listdir("/proc/self/task"):
        with open(f"/proc/self/task/{task}/comm") as file, open(f"/proc/self/task/{task}/schedstat") as counted:
            name, time = file.read().strip(), int(counted.read().split()[0])
        # The threads on which lavapipe runs shaders have the name of the one that opened it.
        is_device = name == "pfront device"
        kind = "pool" if name.startswith("pfront ") and name[7:].isdigit() else "device" if is_device else "others"
        times[kind] += time
    return times


def who(call):
    """What grew by most of the time that a call took, and what explain() says."""
    before = worked()
    call()
    grown = worked() - before
    return {kind for kind, time in grown.items() if time >= 0.2 * grown.total()}, pf.explain()


SOUP = pf.Mesh(*heap(2500))
WIDE = pf.Mesh(SOUP.vertices.astype(float) + np.pi * 1e-9, SOUP.faces)


@pytest.mark.parametrize("mesh", [SOUP, WIDE], ids=["float32", "float64"])
def test_threads(mesh):
    with pf.using(threads=1):
        for call in (lambda: pf.count(mesh, mesh), lambda: pf.pairs(mesh), lambda: pf.count(mesh, mesh, np.tile(np.eye(4), (3, 1, 1)))):
            kinds, told = who(call)
            assert kinds == {"others"} and told.startswith("one thread"), (kinds, told)
    with pf.using(threads=2):
        for call in (lambda: pf.count(mesh, mesh), lambda: pf.pairs(mesh), lambda: pf.count(mesh, mesh, np.tile(np.eye(4), (3, 1, 1)))):
            kinds, told = who(call)
            assert "pool" in kinds and told == "2 threads", (kinds, told)
        assert (pf.collides(BALL, pf.Mesh(*ball(5, 0.1))), pf.explain()[:10]) == (False, "one thread")
        # Where they meet is found after the batch has told who answered.
        pf.count(SOUP, SOUP, np.tile(np.eye(4), (3, 1, 1)))
        told = pf.explain()
        pf.contacts(BALL, BALL, np.tile(np.eye(4), (3, 1, 1)))
        assert pf.explain() == told == "2 threads"


@pytest.mark.parametrize("kind", [np.float32, np.float64])
@pytest.mark.parametrize("count", [1, 30])
def test_a_device(kind, count):
    assert pf.devices(), "no adapter: install the package mesa-vulkan-drivers"
    if pf.devices()[0]["kind"] != "Cpu":
        pytest.skip("only the work of a software device can be counted")
    many = poses(count, spread=1e-4, kind=kind)
    asked = many[0] if count == 1 else many
    soup = pf.Mesh(*heap(400 if count == 1 else 100))
    truth = np.asarray(pf.count(soup, soup, asked))
    with pf.using(threads=2, device="gpu"):
        assert np.array_equal(pf.count(soup, soup, asked), truth)
        before = worked()
        assert all(np.array_equal(pf.count(soup, soup, asked), truth) for _ in range(3))
        told, grown = pf.explain(), worked() - before
        assert told == "GPU" and grown["device"] > 0, (told, grown)


def test_what_a_device_is_not_asked():
    """About one mesh in float64 threads answer, and explain() says why."""
    assert pf.devices(), "no adapter: install the package mesa-vulkan-drivers"
    if pf.devices()[0]["kind"] != "Cpu":
        pytest.skip("only the work of a software device can be counted")
    with pf.using(threads=2, device="gpu"):
        before = worked()
        found, told, grown = pf.count(WIDE), pf.explain(), worked() - before
        assert told.startswith("2 threads") and "float64" in told and grown["device"] < 0.2 * grown["pool"], (told, grown)
    with pf.using(threads=1):
        assert pf.count(WIDE) == found


def test_what_fails_or_is_interrupted_is_not_noted():
    with pf.using(threads=2):
        pf.count(SOUP, SOUP)
        assert pf.explain() == "2 threads"
        with pytest.raises(pf.PoseError):
            pf.count(SOUP, SOUP, np.full((4, 4), np.nan))
        with pytest.raises(TypeError):
            pf.count(SOUP, SOUP, "x")
        assert pf.explain() == "2 threads"
