"""A sweep on Ray: actors hold both meshes, tasks carry poses only.

    pip install ray; python examples/on_ray.py mesh.obj
"""

import sys
from concurrent.futures import Future

import numpy as np
import ray

import pfront as pf


@ray.remote
class Holder:
    """Meshes that were sent once."""

    def __init__(self, a, b):
        self.two = a, b

    def ask(self, what, poses):
        return getattr(pf, what)(*self.two, poses)


class OnRay:
    """What `pf.sweep` takes as an executor: `submit`, over a ring of actors."""

    def __init__(self, a, b, actors):
        self.actors = [Holder.remote(a, b) for _ in range(actors)]
        self.next = 0

    def submit(self, _task, what, _a, _b, poses):
        actor = self.actors[self.next % len(self.actors)]
        self.next += 1
        future: Future = actor.ask.remote(what, poses).future()
        return future


if __name__ == "__main__":
    ray.init(num_cpus=2)
    mesh = pf.Mesh(sys.argv[1])
    poses = np.tile(np.eye(4, dtype=np.float32), (100_000, 1, 1))
    poses[:, 0, 3] = np.linspace(0, 1, len(poses))
    print(sum(hit for _, hit in pf.sweep(mesh, mesh, poses, executor=OnRay(mesh, mesh, 2))))
