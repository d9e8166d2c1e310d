"""How far apart, beside other Python packages that are installed: times, and answers compared.

    python benches/distance.py mesh.obj [--poses 200] [--seed 1] [--seconds 20]

A mesh and itself in random poses, in some of which they intersect. An answer is wrong if it is farther from the interval that pfront
proves than 1e-5 of the distance and 1e-6 of the extent of the mesh, or is not 0, or less, where triangles intersect. Peers that are not
installed are listed as such.
"""

import argparse
import time

import numpy as np
from peers import random_poses

import pfront as pf


def fcl(mesh):
    import fcl

    model = fcl.BVHModel()
    model.beginModel(len(mesh.vertices), len(mesh.faces))
    model.addSubModel(mesh.vertices.astype(float), mesh.faces.astype(int))
    model.endModel()
    fixed, moving = fcl.CollisionObject(model), fcl.CollisionObject(model)

    def ask(pose):
        moving.setTransform(fcl.Transform(pose[:3, :3], pose[:3, 3]))
        return fcl.distance(fixed, moving, fcl.DistanceRequest(), fcl.DistanceResult())

    return ask


def coal(mesh):
    import coal

    model = coal.BVHModelOBBRSS()
    model.beginModel(len(mesh.faces), len(mesh.vertices))
    model.addVertices(mesh.vertices.astype(float))
    model.addTriangles(mesh.faces.astype(np.int64))
    model.endModel()

    def ask(pose):
        moved = coal.Transform3s(pose[:3, :3].copy(), pose[:3, 3].copy())
        return coal.distance(model, coal.Transform3s.Identity(), model, moved, coal.DistanceRequest(), coal.DistanceResult())

    return ask


def manager(mesh, module):
    import trimesh

    body = trimesh.Trimesh(mesh.vertices, mesh.faces, process=False)
    both = module.CollisionManager()
    both.add_object("a", body)
    both.add_object("b", body)

    def ask(pose):
        both.set_transform("b", pose)
        return both.min_distance_internal()

    return ask


def trimesh(mesh):
    import trimesh

    return manager(mesh, trimesh.collision)


def meshlib(mesh):
    import meshlib.mrmeshnumpy as convert
    import meshlib.mrmeshpy as mr

    body = convert.meshFromFacesVerts(mesh.faces.astype(np.int32), mesh.vertices.astype(np.float32))

    def ask(pose):
        rows = [mr.Vector3f(*(float(x) for x in row)) for row in pose[:3, :3]]
        moved = mr.AffineXf3f(mr.Matrix3f(*rows), mr.Vector3f(*(float(x) for x in pose[:3, 3])))
        return mr.findDistance(mr.MeshPart(body), mr.MeshPart(body), moved).distSq ** 0.5

    return ask


PEERS = {
    "coal": coal,
    "python-fcl": fcl,
    "trimesh's manager": trimesh,
    "pfront, in place of trimesh's manager": lambda mesh: manager(mesh, pf.compat),
    "MeshLib": meshlib,
}


def main():
    arguments = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    arguments.add_argument("mesh")
    arguments.add_argument("--poses", type=int, default=200)
    arguments.add_argument("--seed", type=int, default=1)
    arguments.add_argument("--seconds", type=float, default=20.0, help="the most that one peer may take for all poses")
    given = arguments.parse_args()
    exact = pf.Mesh(given.mesh)
    mesh = pf.Mesh(exact.vertices.astype(np.float32), exact.faces)
    poses = random_poses(mesh, given.poses, given.seed)
    poses[:, :3, 3] *= 1.5
    narrow, extent = poses.astype(np.float32), float(np.ptp(mesh.vertices, axis=0).max())
    with pf.using(threads=1):
        truth = np.array([pf.distance(mesh, mesh, pose).interval for pose in narrow])
        print(f"{mesh!r}, {len(poses)} poses, of which {(truth[:, 1] == 0).sum()} meet\n")
        print("| | median, ms | mean | worst | wrong |\n|---|---|---|---|---|")
        own = {"pfront, one pose after the other": lambda _: lambda pose: pf.distance(mesh, mesh, pose.astype(np.float32)).interval[1]}
        for name, make in (own | PEERS).items():
            try:
                ask = make(mesh)
            except ImportError:
                print(f"| {name} | not installed | | | |")
                continue
            times, wrong = [], 0
            for pose, (low, high) in zip(poses, truth):
                began = time.perf_counter()
                found = ask(pose)
                times.append(1e3 * (time.perf_counter() - began))
                slack = 1e-5 * high + 1e-6 * extent if high > 0 else 0
                wrong += found > 0 if high == 0 else not low - slack <= found <= high + slack
                if sum(times) > 1e3 * given.seconds:
                    break
            cells = [f"{cell:.3g}" for cell in (np.median(times), np.mean(times), max(times))]
            print(f"| {name} | {' | '.join(cells)} | {wrong} of {len(times)} |", flush=True)
    for threads in (1, 2):
        with pf.using(threads=threads):
            began = time.perf_counter()
            pf.distance(mesh, mesh, narrow)
            took = 1e3 * (time.perf_counter() - began) / len(narrow)
            met = time.perf_counter()
            pf.collides(mesh, mesh, narrow)
            print(f"all poses in one call, {threads} threads: {took:.3f} ms a pose, any {1e3 * (time.perf_counter() - met) / len(narrow):.3f}")


if __name__ == "__main__":
    main()
