"""pfront beside other Python packages that are installed: times, and answers compared.

    python benches/peers.py mesh.obj [--poses 200] [--seed 1]

A mesh with itself in random poses in which it touches itself about every second time. Every peer gets the same float64 numbers;
its answers are counted against pfront's, whose own are set for set those of CGAL in the tests. Peers that are not installed are
listed as such.
"""

import argparse
import statistics
import time

import numpy as np

import pfront as pf


def random_poses(mesh, count, seed):
    rng = np.random.default_rng(seed)
    turns, _ = np.linalg.qr(rng.normal(size=(count, 3, 3)))
    turns[np.linalg.det(turns) < 0] *= -1
    middle = (mesh.vertices.min(0) + mesh.vertices.max(0)) / 2
    extent = float(np.ptp(mesh.vertices, axis=0).max())
    poses = np.tile(np.eye(4), (count, 1, 1))
    poses[:, :3, :3] = turns
    poses[:, :3, 3] = middle - turns @ middle + rng.uniform(-0.6, 0.6, (count, 3)) * extent
    # Exactly float32, so that peers in float64 move it by the same numbers.
    return poses.astype(np.float32).astype(np.float64)


def fcl_any(mesh):
    import fcl

    model = fcl.BVHModel()
    model.beginModel(len(mesh.vertices), len(mesh.faces))
    model.addSubModel(mesh.vertices.astype(float), mesh.faces.astype(int))
    model.endModel()
    fixed, moving = fcl.CollisionObject(model), fcl.CollisionObject(model)

    def ask(pose):
        moving.setTransform(fcl.Transform(pose[:3, :3], pose[:3, 3]))
        return fcl.collide(fixed, moving, fcl.CollisionRequest(), fcl.CollisionResult()) > 0

    return ask


def coal_any(mesh):
    import coal

    model = coal.BVHModelOBBRSS()
    model.beginModel(len(mesh.faces), len(mesh.vertices))
    model.addVertices(mesh.vertices.astype(float))
    model.addTriangles(mesh.faces.astype(np.int64))
    model.endModel()

    def ask(pose):
        result = coal.CollisionResult()
        moved = coal.Transform3s(pose[:3, :3].copy(), pose[:3, 3].copy())
        return coal.collide(model, coal.Transform3s.Identity(), model, moved, coal.CollisionRequest(), result) > 0

    return ask


def trimesh_any(mesh):
    import trimesh

    body = trimesh.Trimesh(mesh.vertices, mesh.faces, process=False)
    manager = trimesh.collision.CollisionManager()
    manager.add_object("a", body)
    manager.add_object("b", body)

    def ask(pose):
        manager.set_transform("b", pose)
        return manager.in_collision_internal()

    return ask


def trueform_any(mesh):
    import trueform as tf

    make = lambda: tf.Mesh(mesh.faces.astype(np.int32), mesh.vertices.astype(np.float32))  # noqa: E731
    fixed, moving = make(), make()
    for body in (fixed, moving):
        body.build_tree()

    def ask(pose):
        moving.transformation = pose.astype(np.float32)
        return bool(tf.intersects(fixed, moving))

    return ask


def meshlib_any(mesh):
    import meshlib.mrmeshnumpy as convert
    import meshlib.mrmeshpy as mr

    body = convert.meshFromFacesVerts(mesh.faces.astype(np.int32), mesh.vertices.astype(np.float32))

    def ask(pose):
        rows = [mr.Vector3f(*(float(x) for x in row)) for row in pose[:3, :3]]
        moved = mr.AffineXf3f(mr.Matrix3f(*rows), mr.Vector3f(*(float(x) for x in pose[:3, 3])))
        return len(mr.findCollidingTriangles(mr.MeshPart(body), mr.MeshPart(body), moved, True)) > 0

    return ask


PEERS = {
    "python-fcl": fcl_any,
    "coal": coal_any,
    "trimesh's manager": trimesh_any,
    "trueform": trueform_any,
    "MeshLib": meshlib_any,
}


def timed(ask, poses):
    times, answers = [], []
    for pose in poses:
        began = time.perf_counter()
        answers.append(bool(ask(pose)))
        times.append(time.perf_counter() - began)
    return 1e6 * np.array([statistics.median(times), statistics.mean(times)]), np.array(answers)


def line(name, spent, others):
    print(f"| {name} | {spent[0]:.1f} | {spent[1]:.1f} | {others} |", flush=True)


def main():
    arguments = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    arguments.add_argument("mesh")
    arguments.add_argument("--poses", type=int, default=200)
    arguments.add_argument("--seed", type=int, default=1)
    given = arguments.parse_args()
    exact = pf.Mesh(given.mesh)
    # Some peers know float32 only: all get the same mesh.
    mesh = pf.Mesh(exact.vertices.astype(np.float32), exact.faces)
    poses = random_poses(mesh, given.poses, given.seed)
    narrow = poses.astype(np.float32)
    print(f"{mesh!r}, {len(poses)} poses\n\n| any | median, us | mean, us | other answers |\n|---|---|---|---|")
    with pf.using(threads=1):
        own, truth = timed(lambda pose: pf.collides(mesh, mesh, pose), poses)
        short, same = timed(lambda pose: pf.collides(mesh, mesh, pose), narrow)
        line("pfront, float64 poses", own, 0)
        line("pfront, float32 poses", short, (same != truth).sum())
        both, as_given = timed(lambda pose: pf.collides(exact, exact, pose), poses)
        line(f"pfront, the mesh as in the file, {exact.dtype}", both, (as_given != truth).sum())
        for threads in (1, 2):
            with pf.using(threads=threads):
                many = np.tile(narrow, (1 + 1000 // len(narrow), 1, 1))[:1000]
                spent = []
                for _ in range(9):
                    began = time.perf_counter()
                    pf.collides(mesh, mesh, many)
                    spent.append((time.perf_counter() - began) / len(many))
                print(f"| pfront, a batch of 1,000, {threads} threads | | {1e6 * statistics.median(spent):.1f} | |")
        spent, pairs = [], 0
        for pose in narrow:
            began = time.perf_counter()
            pairs += len(pf.pairs(mesh, mesh, pose))
            spent.append(time.perf_counter() - began)
        print(f"| pfront, all pairs ({pairs / len(narrow):.0f} a pose) | {1e6 * statistics.median(spent):.0f} | {1e6 * statistics.mean(spent):.0f} | |")
    for name, make in PEERS.items():
        try:
            ask = make(mesh)
        except ImportError:
            print(f"| {name} | not installed | | |")
            continue
        spent, found = timed(ask, poses)
        line(name, spent, (found != truth).sum())
    print(f"\n{truth.sum()} of {len(truth)} poses meet")


if __name__ == "__main__":
    main()
