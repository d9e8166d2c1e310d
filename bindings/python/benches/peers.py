"""pfront beside other Python packages that are installed: times, and answers compared.

    python benches/peers.py mesh.obj [--poses 200] [--seed 1] [--seconds 5]

A mesh with itself in random poses in most of which it meets itself. Every peer gets the same numbers, its answers are compared with
pfront's, whose own are set for set those of CGAL in the tests, and slow peers get fewer poses. Those that take no pose get
vertices that are posed as pfront poses them. Some list a pair more than once, which is not held against them. Peers that are not
installed are listed as such.
"""

import argparse
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


def posed(mesh, pose):
    """The vertices in a pose, rounded as pfront rounds them."""
    x, y, z = mesh.vertices.T
    r = pose[:3].astype(np.float32)
    return np.stack([((r[k, 0] * x + r[k, 1] * y) + r[k, 2] * z) + r[k, 3] for k in range(3)], -1)


def distinct(contacts):
    """The number of pairs of faces of contacts of fcl."""
    return len({(contact.b1, contact.b2) for contact in contacts})


# Each peer: a question for any hit, one for all pairs or None, and what counts the pairs, which takes no part in the time.


def fcl(mesh):
    import fcl

    model = fcl.BVHModel()
    model.beginModel(len(mesh.vertices), len(mesh.faces))
    model.addSubModel(mesh.vertices.astype(float), mesh.faces.astype(int))
    model.endModel()
    fixed, moving = fcl.CollisionObject(model), fcl.CollisionObject(model)

    def ask(pose, most):
        moving.setTransform(fcl.Transform(pose[:3, :3], pose[:3, 3]))
        request = fcl.CollisionRequest(num_max_contacts=most, enable_contact=most > 1)
        result = fcl.CollisionResult()
        hits = fcl.collide(fixed, moving, request, result)
        return hits > 0 if most == 1 else result.contacts

    return lambda pose: ask(pose, 1), lambda pose: ask(pose, 10**6), distinct


def coal(mesh):
    import coal

    model = coal.BVHModelOBBRSS()
    model.beginModel(len(mesh.faces), len(mesh.vertices))
    model.addVertices(mesh.vertices.astype(float))
    model.addTriangles(mesh.faces.astype(np.int64))
    model.endModel()

    def ask(pose, most):
        result, request = coal.CollisionResult(), coal.CollisionRequest()
        request.num_max_contacts = most
        moved = coal.Transform3s(pose[:3, :3].copy(), pose[:3, 3].copy())
        coal.collide(model, coal.Transform3s.Identity(), model, moved, request, result)
        return result

    return lambda pose: ask(pose, 1).numContacts() > 0, lambda pose: ask(pose, 10**6), lambda found: distinct(found.getContacts())


def manager_of(module, mesh):
    import trimesh

    body = trimesh.Trimesh(mesh.vertices, mesh.faces, process=False)
    manager = module.CollisionManager()
    manager.add_object("a", body)
    manager.add_object("b", body)

    def ask(pose, **wanted):
        manager.set_transform("b", pose)
        return manager.in_collision_internal(**wanted)

    indices = lambda found: len({(data.index("a"), data.index("b")) for data in found[1]})  # noqa: E731
    return ask, lambda pose: ask(pose, return_data=True), indices


def pfront_manager(mesh):
    return manager_of(pf.compat, mesh)


def trimesh(mesh):
    import trimesh

    return manager_of(trimesh.collision, mesh)


def trueform(mesh):
    import trueform as tf

    make = lambda: tf.Mesh(mesh.faces.astype(np.int32), mesh.vertices.astype(np.float32))  # noqa: E731
    fixed, moving = make(), make()
    for body in (fixed, moving):
        body.build_tree()

    def ask(pose, verb):
        moving.transformation = pose.astype(np.float32)
        return verb(fixed, moving)

    return lambda pose: bool(ask(pose, tf.intersects)), lambda pose: ask(pose, tf.gather_intersecting_ids), len


def meshlib(mesh):
    import meshlib.mrmeshnumpy as convert
    import meshlib.mrmeshpy as mr

    body = convert.meshFromFacesVerts(mesh.faces.astype(np.int32), mesh.vertices.astype(np.float32))

    def ask(pose, first_only):
        rows = [mr.Vector3f(*(float(x) for x in row)) for row in pose[:3, :3]]
        moved = mr.AffineXf3f(mr.Matrix3f(*rows), mr.Vector3f(*(float(x) for x in pose[:3, 3])))
        return mr.findCollidingTriangles(mr.MeshPart(body), mr.MeshPart(body), moved, first_only)

    return lambda pose: len(ask(pose, True)) > 0, lambda pose: ask(pose, False), len


def libigl(mesh):
    import igl.predicates

    vertices, faces = mesh.vertices.astype(float), mesh.faces.astype(np.int64)

    def ask(pose, first_only):
        return igl.predicates.find_intersections(vertices, faces, posed(mesh, pose).astype(float), faces, first_only)

    return lambda pose: bool(ask(pose, True)[0]), lambda pose: ask(pose, False)[1], len


def open3d(mesh):
    import open3d

    faces = open3d.utility.Vector3iVector(mesh.faces.astype(np.int32))
    make = lambda points: open3d.geometry.TriangleMesh(open3d.utility.Vector3dVector(points.astype(float)), faces)  # noqa: E731
    fixed = make(mesh.vertices)
    return lambda pose: bool(fixed.is_intersecting(make(posed(mesh, pose)))), None, len


PEERS = {
    "pfront, in place of trimesh's manager": pfront_manager,
    "trimesh's manager": trimesh,
    "coal": coal,
    "python-fcl": fcl,
    "trueform": trueform,
    "MeshLib": meshlib,
    "libigl (predicates)": libigl,
    "Open3D": open3d,
}


def timed(ask, read, poses, seconds, unit):
    """Median and mean time, and what is read of the answers to as many poses as there was time for."""
    times, answers = [], []
    for pose in poses:
        began = time.perf_counter()
        answer = ask(pose)
        times.append(time.perf_counter() - began)
        answers.append(read(answer))
        if sum(times) > seconds:
            break
    return [unit * np.median(times), unit * np.mean(times)], np.array(answers)


def row(name, peer, poses, seconds, truth, counts):
    """A line of the table."""
    any_in, pairs_in, count = peer
    cells = [name]
    for ask, read, unit, own in ((any_in, bool, 1e6, truth), (pairs_in, count, 1e3, counts)):
        if ask is None:
            cells += ["none", "", ""]
            continue
        (median, mean), found = timed(ask, read, poses, seconds, unit)
        wrong = int((found != own[: len(found)]).sum())
        cells += [f"{median:.3g}", f"{mean:.3g}", f"{wrong} of {len(found)}"]
    print(f"| {' | '.join(cells)} |", flush=True)


def main():
    arguments = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    arguments.add_argument("mesh")
    arguments.add_argument("--poses", type=int, default=200)
    arguments.add_argument("--seed", type=int, default=1)
    arguments.add_argument("--seconds", type=float, default=5.0, help="the most that one question about all poses may take")
    given = arguments.parse_args()
    exact = pf.Mesh(given.mesh)
    # Some peers know float32 only: all get the same mesh.
    mesh = pf.Mesh(exact.vertices.astype(np.float32), exact.faces)
    poses = random_poses(mesh, given.poses, given.seed)
    narrow = poses.astype(np.float32)
    with pf.using(threads=1):
        truth, counts = pf.collides(mesh, mesh, narrow), pf.count(mesh, mesh, narrow)
        print(f"{mesh!r}, {len(poses)} poses, of which {truth.sum()} meet; {counts.mean():.0f} pairs a pose\n")
        print("| | any: median, µs | mean | other answers | all pairs: median, ms | mean | other counts |\n|---|---|---|---|---|---|---|")
        for name, a, asked in (
            ("pfront, float32 poses", mesh, narrow),
            ("pfront, float64 poses", mesh, poses),
            (f"pfront, vertices as in the file ({exact.dtype}), float64 poses", exact, poses),
        ):
            own = lambda pose: pf.collides(a, a, pose), lambda pose: pf.pairs(a, a, pose), len
            row(name, own, asked, given.seconds, truth, counts)
    for name, make in PEERS.items():
        try:
            peer = make(mesh)
        except ImportError:
            print(f"| {name} | not installed | | | | | |")
            continue
        row(name, peer, poses, given.seconds, truth, counts)
    many, spent = np.tile(narrow, (1 + 1000 // len(narrow), 1, 1))[:1000], {1: [], 2: []}
    for _ in range(15):
        for threads, times in spent.items():
            with pf.using(threads=threads):
                began = time.perf_counter()
                pf.collides(mesh, mesh, many)
                times.append(1e3 * (time.perf_counter() - began))
    one, two = (np.median(times) for times in spent.values())
    print(f"\n1,000 poses in one call: {one:.2f} µs a pose on one thread, {two:.2f} on two, {one / two:.2f} times as fast")


if __name__ == "__main__":
    main()
