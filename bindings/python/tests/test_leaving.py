"""A process that has opened everything ends by each way, without an abort and without waiting. PFRONT_ROUNDS: times each."""

import os
import signal
import subprocess
import sys
import time

import pytest

ROUNDS = int(os.environ.get("PFRONT_ROUNDS", "1"))
# After the way out was taken; others may compile on the machine that runs this.
LIMIT = float(os.environ.get("PFRONT_LEAVES", "10"))

SETUP = """
import atexit, os, signal, sys, threading, time, numpy as np, pfront as pf
DEVICE = {device!r}
box = pf.Mesh(*pf._box())
V = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0]], np.float32)
soup = pf.Mesh(np.tile(V, (6000, 1)), np.arange(18000).reshape(-1, 3))
poses = np.tile(np.eye(4, dtype=np.float32), (50, 1, 1))
def ask():
    "Everything, on one thread, on several and on a device."
    for settings in (dict(threads=1), dict(threads=2), dict(device=DEVICE)):
        with pf.using(**settings):
            scene = pf.Scene()
            scene.add(box, poses)
            kept = scene, pf.count(box, box, poses), pf.pairs(box, box), scene.count(), pf.contacts(box, box), pf.sweep(box, box, poses, chunk=9)
            next(kept[-1])
            everything.append(kept)
everything = []
ask()
def long():
    "Longer than this process."
    with pf.using(threads=2):
        scene = pf.Scene()
        scene.add(soup, poses[:2])
        while True:
            scene.count(), pf.pairs(soup, soup), pf.count(soup, soup, poses)
def long_on_device():
    with pf.using(device=DEVICE):
        scene = pf.Scene()
        scene.add(box, poses)
        while True:
            scene.set_poses([0], poses[:1] * 1.0), scene.count(), pf.count(box, box, poses)
def at_work(*calls):
    for call in calls:
        threading.Thread(target=call, daemon=True).start()
    time.sleep(0.3)
def leave():
    print("leaves", flush=True)
"""
WAYS = {
    "return": ("leave()", 0),
    "exception": ("leave(); raise ValueError", 1),
    "sys.exit": ("leave(); sys.exit(3)", 3),
    "os._exit": ("at_work(long); leave(); os._exit(4)", 4),
    "drop in order": ("leave()\nwhile everything: everything.pop(0)\ndel box, soup", 0),
    "drop in reverse": ("leave()\ndel box, soup\nwhile everything: everything.pop()", 0),
    "threads at work": ("at_work(long, long); leave()", 0),
    "a device at work": ("at_work(long_on_device); leave()", 0),
    "threads at work, exception": ("at_work(long, long_on_device); leave(); raise ValueError", 1),
    "atexit": ("atexit.register(lambda: (ask(), leave()))", 0),
    "atexit before": ("", 0),
    "Ctrl-C": ("leave(); long()", -signal.SIGINT),
    "Ctrl-C, caught": ("leave()\ntry: long()\nexcept KeyboardInterrupt: sys.exit(5)", 5),
    "Ctrl-C on a device": ("leave()\ntry: long_on_device()\nexcept KeyboardInterrupt: sys.exit(5)", 5),
    "a thread that ends late": ("threading.Thread(target=lambda: (time.sleep(0.2), ask())).start(); leave()", 0),
    "a progress function at work": ("at_work(lambda: [pf.count(box, box, poses, progress=lambda *_: time.sleep(0.001)) for _ in iter(int, 1)]); leave()", 0),
}


@pytest.mark.parametrize("way", WAYS)
def test_a_process_leaves(way):
    import pfront as pf

    code, expected = WAYS[way]
    setup = SETUP.format(device="gpu" if pf.devices() else None)
    if way == "atexit before":
        setup = "import atexit\natexit.register(lambda: (ask(), leave()))\n" + setup
    for _ in range(ROUNDS):
        command = [sys.executable, "-c", "import signal\nsignal.signal(signal.SIGINT, signal.default_int_handler)\n" + setup + code]
        with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True) as process:
            told = process.stdout.readline()
            began = time.monotonic()
            if way.startswith("Ctrl-C"):
                time.sleep(0.3)
                process.send_signal(signal.SIGINT)
            try:
                _, errors = process.communicate(timeout=60)
            except subprocess.TimeoutExpired:
                process.kill()
                pytest.fail(f"{way}: hangs")
        took = time.monotonic() - began
        assert told == "leaves\n" and process.returncode == expected, (way, process.returncode, errors[-900:])
        assert took < LIMIT, (way, took)
