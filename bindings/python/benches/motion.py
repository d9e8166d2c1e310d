"""A mesh that deforms, beside ipctk if it is installed: how far each step may go, and which triangles meet, on one thread.

    python benches/motion.py start.ply positions.f32le [--steps 12] [--rounds 3]

The faces are those of `start.ply`; `positions` holds frames of its vertices in float32, without a header, of which `--steps` at like
distances are the beginnings of steps. ipctk finds candidates with its LBVH, and the step by Tight-Inclusion; of pfront there are
`first_impact`, which tells the same, and `impacts`, which tells all pairs and their times. Each begins with arrays of positions.
"""

import argparse
import time

import numpy as np

import pfront as pf


def pfront(mesh):
    def motion(start, end):
        return {"a": mesh.with_vertices(start), "a_end": mesh.with_vertices(end)}

    def step(start, end):
        first = pf.first_impact(**motion(start, end))
        return 1.0 if first is None else first.start

    return {"pfront, step": step, "pfront, all": lambda start, end: len(pf.impacts(**motion(start, end)).pairs)}


def ipctk(mesh):
    import ipctk

    ipctk.set_num_threads(1)
    ipctk.set_logger_level(ipctk.LoggerLevel.error)
    faces = mesh.faces.astype(np.int32)
    body = ipctk.CollisionMesh(mesh.vertices.astype(float), ipctk.edges(faces), faces)

    def step(start, end):
        candidates, ends = ipctk.Candidates(), [np.asfortranarray(at, float) for at in (start, end)]
        candidates.build(body, *ends, broad_phase=ipctk.LBVH())
        return candidates.compute_collision_free_stepsize(body, *ends)

    return {"ipctk, step": step}


def main():
    asked = argparse.ArgumentParser()
    asked.add_argument("start")
    asked.add_argument("positions")
    asked.add_argument("--steps", type=int, default=12)
    asked.add_argument("--rounds", type=int, default=3)
    asked = asked.parse_args()
    mesh = pf.Mesh(asked.start)
    positions = np.fromfile(asked.positions, np.float32).reshape(-1, len(mesh.vertices), 3)
    players = {}
    for player in (pfront, ipctk):
        try:
            players |= player(mesh)
        except ImportError as error:
            print(f"{player.__name__} is not installed: {error}")
    print("step", *players, "answers", sep=" | ")
    sums = dict.fromkeys(players, 0.0)
    for first in np.linspace(0, len(positions) - 2, asked.steps).astype(int):
        best, answers = dict.fromkeys(players, np.inf), []
        for _ in range(asked.rounds):
            answers = []
            for name, ask in players.items():
                begin = time.perf_counter()
                answers.append(ask(positions[first], positions[first + 1]))
                best[name] = min(best[name], 1e3 * (time.perf_counter() - begin))
        for name, took in best.items():
            sums[name] += took
        print(first, *(f"{took:.2f} ms" for took in best.values()), *answers, sep=" | ")
    print("sum", *(f"{took:.1f} ms" for took in sums.values()), sep=" | ")


if __name__ == "__main__":
    with pf.using(threads=1):
        main()
