"""A sweep on Ray, whose actors hold both meshes while tasks carry poses only; and the same on the threads of this process.

    pip install ray; python examples/on_ray.py mesh.obj [poses]
"""

import sys
import time

import numpy as np
import ray

import pfront as pf


@ray.remote
class Holder:
    """Meshes that were sent once."""

    def __init__(self, a, b):
        self.two = a, b

    def ask(self, what, poses, options):
        return getattr(pf, what)(*self.two, poses, **options)


class OnRay:
    """What `pf.sweep` takes as an executor: `submit`, over a ring of actors."""

    def __init__(self, a, b, actors):
        self.actors = [Holder.remote(a, b) for _ in range(actors)]
        self.next = 0

    def submit(self, _task, what, _a, _b, poses, options):
        actor = self.actors[self.next % len(self.actors)]
        self.next += 1
        return actor.ask.remote(what, poses, options).future()


if __name__ == "__main__":
    ray.init(num_cpus=2, include_dashboard=False)
    mesh, count = pf.Mesh(sys.argv[1]), int((sys.argv[2:] or [100_000])[0])
    poses = np.tile(np.eye(4, dtype=np.float32), (count, 1, 1))
    poses[:, 0, 3] = np.linspace(0, 2, count) * np.ptp(mesh.vertices[:, 0])
    for name, executor in (("Ray", OnRay(mesh, mesh, 2)), ("threads", None)):
        began = time.perf_counter()
        hits = sum(hit for _, hit in pf.sweep(mesh, mesh, poses, executor=executor))
        print(f"{name}: {hits} of {count} poses meet; {time.perf_counter() - began:.2f} s")
