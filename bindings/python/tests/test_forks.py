"""A child of fork answers or is told what to do; it never waits for a thread of its parent."""

import os
import signal
import subprocess
import sys
import threading
import time

import numpy as np
import pytest
from conftest import ball, heap, placed, poses

import pfront as pf

pytestmark = [pytest.mark.skipif(not hasattr(os, "fork"), reason="there is no fork"), pytest.mark.filterwarnings("ignore::DeprecationWarning")]
BALL, CHIP = pf.Mesh(*ball(16)), pf.Mesh(*pf._box())
ROUNDS = int(os.environ.get("PFRONT_ROUNDS", "20"))


def in_child(call, limit=20):
    """What a call gives in a child: "done", or the text of its exception; None if it hangs."""
    reading, writing = os.pipe()
    child = os.fork()
    if child == 0:
        try:
            call()
            told = "done"
        except BaseException as error:
            told = f"{type(error).__name__}: {error}"
        os.write(writing, told.encode()[:4000])
        os._exit(0)
    os.close(writing)
    until = time.monotonic() + limit
    while not os.waitpid(child, os.WNOHANG)[0]:
        if time.monotonic() > until:
            os.kill(child, signal.SIGKILL)
            os.waitpid(child, 0)
            os.close(reading)
            return None
        time.sleep(0.001)
    with os.fdopen(reading) as pipe:
        return pipe.read()


MANY = poses(6)
ASKED = {
    "many": lambda scene: (pf.count(BALL, BALL, MANY[:2]), pf.distance(BALL, BALL, MANY[:2]), pf.relation(CHIP, CHIP, MANY)),
    "one": lambda scene: (pf.pairs(BALL, BALL, MANY[0]), pf.contacts(BALL, BALL, MANY[0].astype(float)), pf.distance(BALL, BALL, MANY[1]), pf.overlap_volume(CHIP, pf._box(), MANY[1])),
    "scene": lambda scene: (scene.set_poses([0], MANY[1:2]), scene.count(), scene.set_poses([0], MANY[:1]), scene.intersecting_bodies(), scene.distance(0), scene.check()),
    "mesh": lambda scene: pf.Mesh(*ball(8)).with_vertices(ball(8)[0] * 2).faces,
}


@pytest.mark.parametrize("what", ASKED)
def test_a_fork_while_other_threads_ask(what):
    def scene():
        made = pf.Scene()
        made.add(BALL, MANY)
        return made

    stop, ask = threading.Event(), ASKED[what]
    threads = [threading.Thread(target=lambda own: [ask(own) for _ in iter(stop.is_set, True)], args=(scene(),)) for _ in range(2)]
    [thread.start() for thread in threads]
    try:
        assert [in_child(lambda: ask(scene())) for _ in range(ROUNDS)] == ["done"] * ROUNDS
    finally:
        stop.set()
        [thread.join() for thread in threads]


@pytest.mark.parametrize("threads", [1, 2])
def test_a_scene_in_use_when_the_process_is_forked_says_so(threads):
    soup, scene = pf.Mesh(*heap(12000)), pf.Scene()
    ids = scene.add(soup, np.stack([placed(), placed(1e-3)]))
    done = []

    def ask():
        with pf.using(threads=threads):
            done.append(scene.count())

    thread = threading.Thread(target=ask)
    thread.start()
    time.sleep(0.2)
    for call in (scene.count, scene.contacts, lambda: len(scene), lambda: scene.add(soup), lambda: scene.remove(0), lambda: scene.user_ids([0]),
                 lambda: scene.set_poses(ids, np.stack([placed(), placed()]))):  # fmt: skip
        assert not done, "the question was too short"
        told = in_child(call)
        assert told is not None and told.startswith("RuntimeError: another thread was using this scene") and "spawn" in told, told
    thread.join()
    # In the parent nothing has happened to it.
    assert done == [scene.count()] and in_child(scene.count) == "done"


def test_a_child_uses_the_scenes_and_threads_that_were_not_in_use():
    scene = pf.Scene()
    scene.add(BALL, MANY)
    with pf.using(threads=2):
        truth = scene.count(), pf.count(BALL, BALL, MANY).tolist()

        def ask():
            assert (scene.count(), pf.count(BALL, BALL, MANY).tolist()) == truth
            assert len(scene.pairs()) == truth[0]

        assert in_child(ask) == "done" and in_child(lambda: in_child(ask) == "done" or sys.exit("a grandchild does not")) == "done"


@pytest.mark.parametrize("ask", ["", "scene.count()", "del scene"])
def test_a_child_ends_as_any_process_does(ask):
    """By the whole end of the interpreter, with all that the parent has made."""
    code = f"""
import os, numpy as np, pfront as pf
box, scene = pf.Mesh(*pf._box()), pf.Scene()
scene.add(box, np.tile(np.eye(4), (9, 1, 1)))
with pf.using(threads=2):
    scene.count(), pf.count(box, box, np.tile(np.eye(4), (9, 1, 1)))
    child = os.fork()
    if child == 0:
        {ask or "pass"}
    else:
        os._exit(os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]))
"""
    ended = subprocess.run([sys.executable, "-W", "ignore", "-c", code], capture_output=True, text=True, timeout=60)
    assert ended.returncode == 0, ended.stderr


def test_a_child_is_told_that_its_parent_had_a_gpu():
    if not pf.devices():
        pytest.fail("no adapter: apt-get install mesa-vulkan-drivers libvulkan1")
    scene = pf.Scene()
    scene.add(BALL, MANY)
    with pf.using(device="gpu"):
        scene.count()

        def ask():
            pf.count(BALL, BALL, MANY[0])

        told = in_child(ask)
        assert told is not None and told.startswith("DeviceError: no GPU can be used here") and "spawn" in told, told
        assert in_child(scene.count) == told and in_child(pf.devices) == told
    # Threads answer in the child, also about a scene that was on the GPU.
    assert in_child(scene.count) == "done" == in_child(lambda: pf.count(BALL, BALL, MANY[0]))


def test_a_fork_inside_a_question_says_so():
    told = []

    def progress(done, total):
        if not told:
            told.append(in_child(lambda: None))

    assert len(pf.collides(BALL, BALL, poses(20_000), progress=progress)) == 20_000 and told == ["done"]

    parent = os.getpid()
    children = []

    def fork(done, total):
        if os.getpid() == parent and not children:
            children.append(os.fork())

    try:
        pf.collides(BALL, BALL, poses(20_000), progress=fork)
    except RuntimeError as error:
        if os.getpid() != parent:
            os._exit(7 if "forked inside a question" in str(error) else 8)
    if os.getpid() != parent:
        os._exit(9)
    assert os.waitstatus_to_exitcode(os.waitpid(children[0], 0)[1]) == 7
