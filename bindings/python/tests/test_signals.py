"""Ctrl-C is heard in whatever may take long, and ends the question of the thread that hears it, and no other."""

import os
import signal
import threading
import time

import numpy as np
import pytest
from conftest import ball, heap, placed

import pfront as pf

# 20 ms on a quiet machine; others may compile on the one that runs this.
LIMIT = float(os.environ.get("PFRONT_CTRL_C", "0.5"))


@pytest.fixture(autouse=True)
def signals():
    # A shell ignores it for what runs in the background, and Python leaves that so.
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    yield
    signal.signal(signal.SIGINT, before)


def delay(call, after=0.15):
    """The time from SIGINT to the end of a call that would take longer."""
    sent = []

    def send():
        sent.append(time.perf_counter())
        os.kill(os.getpid(), signal.SIGINT)

    timer = threading.Timer(after, send)
    timer.start()
    try:
        with pytest.raises(KeyboardInterrupt):
            call()
            pytest.fail("the call was too short")
        return time.perf_counter() - sent[0]
    finally:
        timer.join()


def soup(count):
    """Faces of which each meets each."""
    return pf.Mesh(np.tile(np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0]], np.float32), (count, 1)), np.arange(3 * count).reshape(-1, 3))


@pytest.mark.parametrize("threads", [1, 2])
def test_while_another_thread_uses_the_scene(threads):
    mesh, scene, found = soup(8_000), pf.Scene(), []
    ids = scene.add(mesh, np.stack([placed(), placed()]))
    stop = threading.Event()

    def ask():
        with pf.using(threads=threads):
            found.append(scene.count())
            while not stop.is_set():
                scene.set_poses(ids[:1], placed(z=0 if len(found) % 2 else 1e-30))
                found.append(scene.count())

    thread = threading.Thread(target=ask)
    thread.start()
    time.sleep(0.2)
    waited = {}
    other = pf.Scene()
    other.add(mesh)
    for name, call in [("add", lambda: scene.add(mesh)), ("len", lambda: len(scene)), ("set_poses", lambda: scene.set_poses(ids, np.stack([placed()] * 2))),
                       ("count", scene.count), ("contacts", scene.contacts), ("remove", lambda: scene.remove(0)), ("user_ids", lambda: scene.user_ids(ids)),
                       ("set_mesh", lambda: scene.set_mesh(0, mesh)), ("ignore", lambda: scene.ignore(0, 1)), ("across", lambda: other._across(scene, True))]:  # fmt: skip
        before = len(found)
        waited[name] = delay(call)
        if len(found) != before:
            waited[name] = 0  # the other question ended in the midst of it
    stop.set()
    thread.join()
    print({name: f"{1e3 * seconds:.0f} ms" for name, seconds in waited.items()})
    assert max(waited.values()) < LIMIT, waited
    # Nobody's flag has ended the other thread's questions, or taken anything from their answers.
    assert set(found) <= {8_000**2, 0} and found[0] == 8_000**2 and len(scene) == 2


def test_contacts_sorting_and_meshes():
    mesh, many = soup(7_000), ball(900)
    scene = pf.Scene()
    scene.add(mesh, np.stack([placed(), placed()]))
    large = pf.Mesh(*many)
    for name, call in [("contacts of a scene", scene.contacts), ("pairs of a scene", scene.pairs), ("pairs", lambda: pf.pairs(mesh, mesh)),
                       ("contacts", lambda: pf.contacts(mesh, mesh)), ("mesh", lambda: [pf.Mesh(*many) for _ in range(99)]),
                       ("vertices", lambda: [large.with_vertices(many[0]) for _ in range(999)])]:  # fmt: skip
        for threads in (1, 2):
            with pf.using(threads=threads):
                waited = delay(call, 0.2)
            print(f"{name}, {threads} threads: {1e3 * waited:.0f} ms")
            assert waited < LIMIT, name
    # What was interrupted leaves no trace.
    small = pf.Scene()
    small.add(soup(30), np.stack([placed(), placed()]))
    assert len(small.contacts()) == small.count() == 900


def test_distances():
    """Of surfaces all of whose triangles are about equally near."""
    a, b = pf.Mesh(*ball(600)), pf.Mesh(*ball(600, 1.001))
    scene, many = pf.Scene(), np.stack([placed(kind=np.float64)] * 40)
    scene.add(a), scene.add(b)
    for name, call in [("one", lambda: pf.distance(a, b)), ("many", lambda: pf.distance(a, b, many)), ("scene", lambda: scene.distance(0))]:
        for threads in (1, 2):
            with pf.using(threads=threads):
                waited = delay(call, 0.1)
            print(f"{name}, {threads} threads: {1e3 * waited:.0f} ms")
            assert waited < LIMIT, name
    scene.set_poses([1], placed(9))
    assert 6 < scene.distance(0)[1].distance < 8


def test_relations():
    """Of a solid with many flush faces, in each of whose pairs edges are looked at."""
    points, quads = np.stack(np.meshgrid(*[np.arange(301)] * 2, indexing="ij"), -1).reshape(-1, 2), np.arange(300 * 301).reshape(300, 301)[:, :300].ravel()
    corners = quads[:, None] + [0, 301, 1, 1, 301, 302]
    sheet = np.concatenate([np.c_[points, np.zeros(len(points))], np.c_[points, np.ones(len(points))]]).astype(np.float32)
    top, bottom = corners.reshape(-1, 3) + len(points), corners.reshape(-1, 3)[:, ::-1]
    edge = np.concatenate([np.arange(301), np.arange(1, 301) * 301 + 300, 300 * 301 + np.arange(299, -1, -1), np.arange(299, 0, -1) * 301])
    a, b = edge, np.roll(edge, -1)
    sides = np.concatenate([np.stack([b, a, a + len(points)], -1), np.stack([b, a + len(points), b + len(points)], -1)])
    mesh = pf.Mesh(sheet, np.concatenate([top, bottom, sides]))
    scene, many = pf.Scene(), np.stack([placed(0.25, 0.25)] * 40)
    scene.add(mesh, np.stack([placed(z=z) for z in range(12)]))
    for name, call in [("one", lambda: pf.relation(mesh, mesh, many[0])), ("many", lambda: pf.relation(mesh, mesh, many)),
                       ("volumes", lambda: pf.overlap_volume(mesh, mesh, many)), ("scene", scene.check)]:  # fmt: skip
        for threads in (1, 2):
            with pf.using(threads=threads):
                waited = delay(call, 0.1)
            print(f"{name}, {threads} threads: {1e3 * waited:.0f} ms")
            assert waited < LIMIT, name
    scene.remove(0)
    assert len(scene) == 11


def test_while_the_threads_are_at_work_for_others():
    """Also on what was left to itself by an interrupt."""
    mesh, scene, box = soup(7_000), pf.Scene(), pf.Mesh(*ball(8))
    scene.add(mesh, np.stack([placed(), placed()]))
    stop = threading.Event()

    def ask():
        with pf.using(threads=2):
            while not stop.is_set():
                pf.pairs(mesh, mesh)

    with pf.using(threads=2):
        assert delay(lambda: pf.pairs(mesh, mesh), 0.3) < LIMIT
        for call in (scene.count, scene.contacts, lambda: pf.contacts(mesh, mesh)):
            assert delay(call) < LIMIT
        thread = threading.Thread(target=ask)
        thread.start()
        time.sleep(0.1)
        for call in (scene.count, scene.contacts, lambda: pf.contacts(mesh, mesh)):
            assert delay(call) < LIMIT
        stop.set()
        thread.join()
        assert pf.count(box, box) > 0


def test_a_scene_answers_after_an_interrupt():
    mesh, scene = soup(7_000), pf.Scene()
    scene.add(mesh, np.stack([placed(), placed()]))
    for _ in range(3):
        assert delay(scene.count, 0.1) < LIMIT
        scene.set_poses([1], placed(z=3))
        assert scene.count() == 0
        scene.set_poses([1], placed())


def test_bodies_are_added_all_or_none():
    box, scene = pf.Mesh(*pf._box()), pf.Scene()
    many = np.tile(np.eye(4), (3_000_000, 1, 1))
    before = threading.active_count()
    sent = threading.Timer(0.6, lambda: os.kill(os.getpid(), signal.SIGINT))
    sent.start()
    try:
        scene.add(box, many)
    except KeyboardInterrupt:
        assert len(scene) == 0
    else:
        assert len(scene) == len(many)
    finally:
        try:
            sent.join()
            time.sleep(0.05)
        except KeyboardInterrupt:
            pass
    assert threading.active_count() == before
