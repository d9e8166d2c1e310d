"""Which relation, beside other Python packages that are installed: times, and answers that are wrong.

    python benches/relation.py [--pairs 200] [--cells 20] [--seed 1]

Boxes of whole numbers, each side a grid of triangles, of which the numbers tell the relation, whether the surfaces meet, and the common
volume. A package that has no words is asked whether they meet; one that is not installed is listed as such.
"""

import argparse
import collections
import time

import numpy as np

import pfront as pf


def box(low, high, cells):
    """A box as a mesh, its sides grids of so many cells along each edge; corners on edges are one vertex."""
    grid = np.arange(cells + 1)
    positions, triangles, known = [], [], {}

    def vertex(place):
        if place not in known:
            known[place] = len(positions)
            positions.append([low[k] + (high[k] - low[k]) * place[k] / cells for k in range(3)])
        return known[place]

    for axis in range(3):
        for side in (0, cells):
            for i in grid[:-1]:
                for j in grid[:-1]:
                    quad = []
                    for u, v in ((i, j), (i + 1, j), (i + 1, j + 1), (i, j + 1)):
                        place = [0, 0, 0]
                        place[axis], place[(axis + 1) % 3], place[(axis + 2) % 3] = side, int(u), int(v)
                        quad.append(vertex(tuple(place)))
                    a, b, c, d = quad if side else quad[::-1]
                    triangles += [[a, b, c], [a, c, d]]
    return np.array(positions, np.float32), np.array(triangles, np.uint32)


def truth(a, b):
    """The relation of two boxes, whether their surfaces meet, and the volume of what they have in common."""
    low, high = np.maximum(a[0], b[0]), np.minimum(a[1], b[1])
    if (low > high).any():
        return "apart", False, 0
    volume = int(np.prod(high - low))
    is_in = lambda p, q: (p[0] >= q[0]).all() and (p[1] <= q[1]).all()  # noqa: E731
    is_deep = lambda p, q: (p[0] > q[0]).all() and (p[1] < q[1]).all()  # noqa: E731
    meets = not is_deep(a, b) and not is_deep(b, a)
    if volume == 0:
        return "touching", True, 0
    word = {(True, True): "equal", (True, False): "a_in_b", (False, True): "b_in_a", (False, False): "crossing"}
    return word[is_in(a, b), is_in(b, a)], meets, volume


def own(a, b):
    a, b = pf.Mesh(*a), pf.Mesh(*b)
    return lambda: pf.relation(a, b)


def meshlib(a, b):
    import meshlib.mrmeshnumpy as convert
    import meshlib.mrmeshpy as mr

    a, b = (convert.meshFromFacesVerts(mesh[1].astype(np.int32), mesh[0]) for mesh in (a, b))
    status = mr.MeshMeshCollisionStatus
    words = {
        status.BothOutside: "apart",
        status.Touching: "touching",
        status.Colliding: "crossing",
        status.AInside: "a_in_b",
        status.BInside: "b_in_a",
    }
    return lambda: words[mr.findSignedDistance(mr.MeshPart(a), mr.MeshPart(b)).status]


def coal(a, b):
    import coal

    def model(mesh):
        model = coal.BVHModelOBBRSS()
        model.beginModel(len(mesh[1]), len(mesh[0]))
        model.addVertices(mesh[0].astype(float))
        model.addTriangles(mesh[1].astype(np.int64))
        model.endModel()
        return model

    a, b, at = model(a), model(b), coal.Transform3s.Identity()
    return lambda: coal.collide(a, at, b, at, coal.CollisionRequest(), coal.CollisionResult()) > 0


def fcl(a, b):
    import fcl

    def model(mesh):
        model = fcl.BVHModel()
        model.beginModel(len(mesh[0]), len(mesh[1]))
        model.addSubModel(mesh[0].astype(float), mesh[1].astype(int))
        model.endModel()
        return fcl.CollisionObject(model)

    a, b = model(a), model(b)
    return lambda: fcl.collide(a, b, fcl.CollisionRequest(), fcl.CollisionResult()) > 0


def trimesh(a, b):
    import trimesh

    both = trimesh.collision.CollisionManager()
    for name, mesh in (("a", a), ("b", b)):
        both.add_object(name, trimesh.Trimesh(*mesh, process=False))
    return lambda: both.in_collision_internal()


def own_volume(a, b):
    a, b = pf.Mesh(*a), pf.Mesh(*b)
    return lambda: sum(pf.overlap_volume(a, b)) / 2


def meshlib_volume(a, b):
    import meshlib.mrmeshnumpy as convert
    import meshlib.mrmeshpy as mr

    a, b = (convert.meshFromFacesVerts(mesh[1].astype(np.int32), mesh[0]) for mesh in (a, b))
    return lambda: mr.boolean(a, b, mr.BooleanOperation.Intersection).mesh.volume()


RELATIONS = {"pfront": own, "MeshLib": meshlib, "coal: do they meet": coal, "python-fcl: do they meet": fcl, "trimesh: do they meet": trimesh}
VOLUMES = {"pfront": own_volume, "MeshLib's boolean": meshlib_volume}


def table(peers, pairs, is_right):
    print("| | median, ms | worst | wrong | of these |\n|---|---|---|---|---|")
    for name, make in peers.items():
        times, wrong = [], collections.Counter()
        try:
            for a, b, known in pairs:
                ask = make(a, b)
                ask()
                began = time.perf_counter()
                found = ask()
                times.append(1e3 * (time.perf_counter() - began))
                if not is_right(found, known):
                    wrong[known[0]] += 1
        except ImportError:
            print(f"| {name} | not installed | | | |")
            continue
        of = ", ".join(f"{word} {number}" for word, number in sorted(wrong.items()))
        print(f"| {name} | {np.median(times):.3f} | {max(times):.3f} | {sum(wrong.values())} | {of} |")


def main():
    arguments = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    arguments.add_argument("--pairs", type=int, default=200)
    arguments.add_argument("--cells", type=int, default=20)
    arguments.add_argument("--seed", type=int, default=1)
    given = arguments.parse_args()
    rng, pairs = np.random.default_rng(given.seed), []
    for number in range(given.pairs):
        ends = np.sort(rng.choice(5, (2, 2, 3)), axis=1)
        while (ends[:, 0] == ends[:, 1]).any():
            ends = np.sort(rng.choice(5, (2, 2, 3)), axis=1)
        if number % 10 == 0:
            ends[1] = ends[0]
        elif number % 10 == 1:
            ends = np.array([[[0, 0, 0], [4, 4, 4]], [[1, 1, 1], [2, 3, 3]]])
        a, b = ends
        pairs.append((box(*a, given.cells), box(*b, given.cells), truth(a, b)))
    kinds = collections.Counter(known[0] for *_, known in pairs)
    print(f"{len(pairs)} pairs of boxes of {12 * given.cells**2} triangles: " + ", ".join(f"{n} {k}" for k, n in sorted(kinds.items())) + "\n")
    with pf.using(threads=1):
        table(RELATIONS, pairs, lambda found, known: found == known[0] if isinstance(found, str) else found == known[1])
        print("\nThe volume in common, wrong if it is off by a millionth of the unit:\n")
        table(VOLUMES, pairs, lambda found, known: abs(found - known[2]) < 1e-6)


if __name__ == "__main__":
    main()
