"""Relations of solids and the volumes in common: against boxes whose corners tell both, in each form of the question."""

import pickle
from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest
from conftest import placed, poses

import pfront as pf

CORNERS, FACES = (np.array(part) for part in pf._box())
WORDS = {"apart", "near", "touching", "crossing", "a_in_b", "b_in_a", "equal"}


def solid(low, high, kind=float):
    """The box of two corners."""
    return pf.Mesh((np.where(CORNERS < 0, low, high)).astype(kind), FACES)


def joined(*meshes):
    """One mesh of several."""
    offsets = np.cumsum([0, *(len(mesh.vertices) for mesh in meshes)])
    return pf.Mesh(np.concatenate([mesh.vertices for mesh in meshes]), np.concatenate([mesh.faces + k for mesh, k in zip(meshes, offsets)]))


def truth(a, b):
    """The relation of two boxes of integers, each a low and a high corner, and the volume in common."""
    common = np.minimum(a[1], b[1]) - np.maximum(a[0], b[0])
    if (common < 0).any():
        return "apart", 0
    if (common == 0).any():
        return "touching", 0
    sizes = [(box[1] - box[0]).prod() for box in (a, b)]
    words = {(True, True): "equal", (True, False): "a_in_b", (False, True): "b_in_a", (False, False): "crossing"}
    return words[common.prod() == sizes[0], common.prod() == sizes[1]], common.prod()


def ball(count=12, radius=1.0):
    """A closed sphere of rings."""
    u, v = np.meshgrid(np.linspace(0, 2 * np.pi, count, endpoint=False), np.linspace(0, np.pi, count)[1:-1])
    points = radius * np.stack([np.cos(u) * np.sin(v), np.sin(u) * np.sin(v), np.cos(v)], -1).reshape(-1, 3)
    points = np.concatenate([points, [[0, 0, radius], [0, 0, -radius]]]).astype(np.float32)
    rows, columns = np.meshgrid(np.arange(count - 3), np.arange(count), indexing="ij")
    a, b = rows * count + columns, rows * count + (columns + 1) % count
    sides = np.concatenate([np.stack([a, a + count, b], -1).reshape(-1, 3), np.stack([b, a + count, b + count], -1).reshape(-1, 3)])
    ring, top = np.arange(count), count * (count - 2)
    caps = [np.stack([ring, np.roll(ring, -1), np.full(count, top)], -1), np.stack([np.roll(ring, -1), ring, np.full(count, 2 * top + 1)], -1)]
    caps[1][:, :2] += top - count
    caps[1][:, 2] = top + 1
    return points, np.concatenate([sides, *caps])


@pytest.mark.parametrize("kind", [np.float32, np.float64])
@pytest.mark.parametrize("threads", [1, 2])
def test_boxes_in_every_place(kind, threads):
    rng, found = np.random.default_rng(5), set()
    with pf.using(threads=threads):
        for size in (1, 2, 3, 4) * 3:
            boxes = [np.sort(rng.choice(most, (3, 2)), -1).T + [[0] * 3, [1] * 3] for most in (4, size)]
            boxes[1] = boxes[0] if size == 4 else boxes[1]
            # The second is moved where it lies; the first is turned inside out, and so are its faces.
            a, b = (solid(*box, kind) for box in boxes)
            a = pf.Mesh(a.vertices, a.faces[:, ::-1])
            shifts = np.concatenate([rng.integers(-4, 5, (39, 3)), [[0] * 3]])
            many = np.stack([placed(*shift, kind=kind) for shift in shifts])
            told = []
            words = pf.relation(a, b, many, progress=lambda *x: told.append(x))
            volumes = pf.overlap_volume(a, b, many)
            assert pf.explain() == ("one thread" if threads == 1 else "2 threads")
            assert told == [(40, 40)] and words.shape == (40,) and volumes.shape == (40, 2)
            for shift, pose, word, volume in zip(shifts, many, words, volumes):
                expected, common = truth(boxes[0], boxes[1] + shift)
                assert word == expected == pf.relation(a, b, pose)
                low, high = pf.overlap_volume(a, b, pose)
                assert (low, high) == tuple(volume) and low <= common <= high < common + 1e-10
                swapped = {"a_in_b": "b_in_a", "b_in_a": "a_in_b"}.get(expected, expected)
                assert pf.relation(b, a, np.linalg.inv(pose).astype(kind)) == swapped
            found.update(words.tolist())
    assert found == WORDS - {"near"}


def test_what_is_turned():
    """A box of a random turn is in a ball, around one, or crosses it; in float32 positions are rounded, which moves no such word."""
    box, small, large = pf.Mesh(*pf._box()), pf.Mesh(*ball(radius=0.4)), pf.Mesh(*ball(radius=0.95))
    middle = pf.Mesh(*ball(radius=0.6))
    for kind in (np.float32, np.float64):
        many = poses(25, spread=0, kind=kind)
        for mesh, word in ((small, "a_in_b"), (middle, "crossing"), (large, "b_in_a")):
            assert pf.relation(mesh, box, many).tolist() == [word] * 25
            assert pf.relation(mesh, joined(box), many[0]) == word
    low, high = pf.overlap_volume(large, box, many[0])
    assert low <= 1 <= high < low + 1e-12


def test_near_is_exact():
    box = pf.Mesh(*pf._box())
    pose = placed(1.02, kind=np.float64)
    gap = pose[0, 3] - 1
    assert float(np.float32(0.02)) < gap
    for within, word in ((0, "apart"), (np.float32(0.02), "apart"), (gap, "near"), (0.25, "near")):
        assert pf.relation(box, box, pose, within=within) == word
        assert pf.relation(box, box, np.stack([pose, np.eye(4)]), within=within).tolist() == [word, "equal"]
    for within in (float("nan"), -1, float("inf"), 1e300):
        with pytest.raises(ValueError, match="must be finite and not negative"):
            pf.relation(box, box, within=within)
    with pytest.raises(TypeError):
        pf.relation(box, box, within="near")


def test_what_is_no_solid_is_told():
    box = pf.Mesh(*pf._box())
    open_box = pf.Mesh(box.vertices, np.delete(box.faces, 5, 0))
    with pytest.warns(UserWarning):
        none = pf.Mesh(np.empty((0, 3)), np.empty((0, 3), int))
    thin = pf.Mesh(box.vertices, [[0, 1, 2], [2, 1, 0]])
    crossing = joined(box, pf.Mesh(box.vertices + [0.5, 0.25, 0.125], box.faces))
    for ask in (pf.relation, pf.overlap_volume):
        for pose in (None, np.stack([np.eye(4)] * 3), np.empty((0, 4, 4))):
            for mesh, attributes, text in ((open_box, "edge", "is open"), (none, None, "no volume"), (thin, None, None)):
                for two, name in (((mesh, box), "a"), ((box, mesh), "b")):
                    with pytest.raises(pf.NotSolid, match=f"^{name} is no solid: .*{text or ''}") as caught:
                        ask(*two, pose)
                    error = pickle.loads(pickle.dumps(caught.value))
                    assert isinstance(error, pf.MeshError) and error.mesh == name and error.vertex is None
                    assert (error.edge is not None) == (error.face is not None) == (attributes == "edge")
                    if attributes == "edge":
                        edge = set(mesh.faces[error.face][[error.edge, (error.edge + 1) % 3]].tolist())
                        assert sum(edge <= set(face) for face in mesh.faces.tolist()) == 1
        with pytest.raises(TypeError):
            ask(box)
        with pytest.raises(pf.PoseError) as caught:
            ask(box, box, np.stack([np.eye(4)] * 1500 + [np.full((4, 4), np.inf)]))
        assert caught.value.pose == 1500 or caught.value.row == 3
        bad = np.stack([np.eye(4)] * 1500)
        bad[1201, 0, 3] = 1e300
        with pytest.raises(pf.PoseError, match="^pose 1201: ") as caught:
            ask(box, box, bad)
        assert caught.value.pose == 1201
    with pytest.raises(pf.NotSolid, match="^b is no solid") as caught:
        pf.overlap_volume(box, crossing)
    assert caught.value.pair == tuple(pf.pairs(crossing)[0]) and caught.value.face is None
    with pytest.raises(pf.NotSolid, match="^a is no solid"):
        pf.overlap_volume(crossing, crossing, np.stack([np.eye(4)] * 2))
    # What meets itself elsewhere does not matter.
    apart = joined(box, pf.Mesh(crossing.vertices + 9, crossing.faces))
    low, high = pf.overlap_volume(apart, box)
    assert high - low < 1e-9 and (low, high) == pytest.approx(pf.overlap_volume(box, box))


def test_what_hangs_on_faces_that_meet_their_own_mesh_is_undetermined():
    box = pf.Mesh(*pf._box())
    crossing = joined(box, pf.Mesh(box.vertices + [0.5, 0.25, 0.125], box.faces))
    many = np.stack([placed(x) for x in (0, 9)])
    assert pf.relation(crossing, box) is None and pf.relation(crossing, box, many).tolist() == [None, "apart"]
    assert [word for _, word in pf.sweep(crossing, box, many, "relation")] == [None, "apart"]


def test_threads_of_the_caller_share_a_mesh():
    many = poses(30, spread=1.5)
    expected = pf.relation(pf._box(), pf._box(), many).tolist()
    assert len(set(expected)) > 1
    box = pf.Mesh(*pf._box())
    with ThreadPoolExecutor(8) as pool:
        assert all(words.tolist() == expected for words in pool.map(lambda _: pf.relation(box, box, many), range(16)))
    copied = pickle.loads(pickle.dumps(box))
    assert pf.relation(copied, box, many).tolist() == expected


def test_a_sweep_elsewhere():
    box, many = pf.Mesh(*pf._box()), np.stack([placed(x) for x in (0.5, 1, 1.25, 3)])
    volumes = pf.overlap_volume(box, box, many)
    for executor in (None, ThreadPoolExecutor(2)):
        words = list(pf.sweep(box, box, many, "relation", within=0.25, chunk=3, executor=executor))
        assert words == list(enumerate(["crossing", "touching", "near", "apart"]))
        found = list(pf.sweep(box, box, many, "overlap_volume", chunk=3, executor=executor))
        assert found == [(i, tuple(volume)) for i, volume in enumerate(volumes.tolist())]
    with pytest.raises(ValueError, match="leave out within"):
        pf.sweep(box, box, many, "overlap_volume", within=1)
    with pytest.raises(ValueError, match="has no limit"):
        pf.sweep(box, box, many, "relation", limit=1)


def turned(x=0.0, y=0.0, z=0.0):
    """A place in an assembly that is turned by 37 degrees about an axis of no name."""
    axis, angle = np.array([1, 2, 3]) / 14**0.5, np.radians(37)
    across = np.cross(np.eye(3), axis)
    pose = np.eye(4)
    pose[:3, :3] = np.eye(3) + np.sin(angle) * across + (1 - np.cos(angle)) * across @ across
    pose[:3, 3] = pose[:3, :3] @ [x, y, z]
    return pose


@pytest.mark.parametrize("threads", [1, 2])
def test_an_assembly(threads):
    box, inner, lid = solid([0] * 3, [1] * 3), solid([0.25] * 3, [0.625] * 3), pf.Mesh(CORNERS + 0.5, FACES[:-1])
    scene = pf.Scene(within=0.25)
    parts = [("plate", box, (0, 0, 0)), ("washer 1", box, (0, 0, 1)), ("washer 2", box, (0, 0, 2)), ("peg", inner, (0, 0, 0)),
             ("twin", box, (8, 0, 0)), ("twin's twin", box, (8, 0, 0)), ("clash", box, (0.5, 0.5, 2.75)), ("near", box, (1.125, 0, 0)),
             ("lid", lid, (0.875, 0.875, -0.5)), ("far", box, (50, 0, 0))]  # fmt: skip
    ids = {name: scene.add(mesh, turned(*at), name=name) for name, mesh, at in parts}
    scene.set_poses([ids["far"]], turned(60)[None])
    expected = {("plate", "washer 1"): "touching", ("washer 1", "washer 2"): "touching", ("plate", "peg"): "b_in_a",
                ("twin", "twin's twin"): "equal", ("washer 2", "clash"): "crossing", ("plate", "near"): "near",
                ("washer 1", "near"): "near"}  # fmt: skip
    with pf.using(threads=threads):
        report = scene.check(allow_overlap=1e-9)
        assert ("thread" in pf.explain()) and not report.allowed
        # Boxes of what is turned overlap where bodies do not.
        told = {pair.names: pair for pair in report.pairs if pair.relation not in (None, "apart")}
        assert {names: pair.relation for names, pair in told.items()} == expected
        open_ones = {pair.names: pair for pair in report.pairs if pair.relation is None}
        assert all("lid" in names for names in open_ones) and {("plate", "lid"), ("near", "lid")} <= set(open_ones)
        clean = {"touching", "apart"}
        assert all(pair.allowed == (pair.relation in clean) for pair in report.pairs)
        clash = told["washer 2", "clash"]
        low, high = clash.overlap_volume
        assert low - 1e-12 <= 0.25 * 0.25 <= high + 1e-12 and high - low < 1e-9 and clash.gap is None and len(clash.place) == 3
        low, high = told["plate", "near"].gap
        assert low <= 0.125 + 1e-9 and 0.125 - 1e-9 <= high and told["plate", "near"].overlap_volume is None
        assert clash.bodies == (ids["washer 2"], ids["clash"]) and list(clash.pair) in pf.pairs(box, box, np.linalg.inv(turned(0, 0, 2)) @ turned(0.5, 0.5, 2.75)).tolist()
        assert report.refused.keys() == {ids["lid"]} and report.refused[ids["lid"]].face is not None and report.refused[ids["lid"]].mesh is None
        assert sum(report.counts.values()) == len(report.pairs) and report.counts["equal"] == report.counts["crossing"] == 1
        assert report.counts["undetermined"] == sum(pair.relation is None for pair in report.pairs)
        # All is allowed that is meant.
        for two in (("peg", "plate"), ("twin*", "twin?s twin"), ("lid", "*"), ("washer ?", "clash")):
            scene.ignore(*two)
        report = scene.check(allow=iter(["near"]))
        assert report.allowed and report.refused == {} and "undetermined" not in report.counts and report.counts["near"] == 2
        assert not scene.check().allowed
        scene.ignore("washer*", "clash", False)
        assert not scene.check(allow=["near"], allow_overlap=0.06).allowed and scene.check(allow=["near"], allow_overlap=0.0626).allowed
        assert scene.check(allow=["near", "crossing"]).allowed
    assert scene.check() == pickle.loads(pickle.dumps(scene.check())) and repr(pf.Scene().check()) == "CheckReport(0 pairs, 0 not allowed)"
    assert pf.Scene().check().allowed and pf.Scene().check().counts == {}


def test_patterns_and_what_is_refused():
    scene, box = pf.Scene(), pf.Mesh(*pf._box())
    for name in ("a*", "ab", "a.", "b", "ab", ("no", "text")):
        scene.add(box, name=name)
    scene.ignore("a*", "b")  # a name, and no pattern
    scene.ignore("?.", "b")
    assert sorted(map(tuple, scene.intersecting_bodies().tolist())) == sorted(
        (i, j) for i in range(6) for j in range(i + 1, 6) if (i, j) not in ((0, 3), (2, 3))
    )
    for pattern in ("z*", "", "A?", "*c"):
        with pytest.raises(pf.StaleBody, match="no body of the scene has"):
            scene.ignore(pattern, "b")
    with pytest.raises(ValueError, match="2 bodies have the name"):
        scene.ignore("ab", "b")
    with pytest.raises(ValueError, match="'wide' is no relation|\"wide\" is no relation"):
        scene.check(allow=["wide"])
    for volume in (-1, float("nan")):
        with pytest.raises(ValueError, match="cannot be allowed"):
            scene.check(allow_overlap=volume)
    for ignore in (["ab"], [("a", "b", "c")]):
        with pytest.raises(TypeError, match="no pair of names"):
            pf.check({"ab": box}, ignore=ignore)


def test_a_file_as_the_command_checks_it(tmp_path):
    lines = []
    for name, x in (("Bolt 1", 0), ("Plate", 0.75), ("Nut", 2)):
        lines += [f"o {name}", *(f"v {px + x} {py} {pz}" for px, py, pz in CORNERS)]
        lines += [f"f {' '.join(str(k - 8) for k in face)}" for face in FACES.tolist()]
    path = tmp_path / "assembly.obj"
    path.write_text("\n".join(lines) + "\n")
    report = pf.check(path, within=0.25)
    assert [(pair.names, pair.relation, pair.allowed) for pair in report.pairs] == [
        (("Bolt 1", "Plate"), "crossing", False),
        (("Plate", "Nut"), "near", False),
    ]
    table = report.to_dict()
    assert len(table) == 20 and all(column.shape == (2,) for column in table.values())
    assert table["volume_low"][0] <= 0.25 <= table["volume_high"][0] and table["gap_low"][1] <= 0.25 <= table["gap_high"][1]
    assert np.isnan(table["volume_low"]).tolist() == np.isnan(table["x"]).tolist() == [False, True] and np.isnan(table["gap_high"]).tolist() == [True, False]
    assert table["face_a"].dtype == table["body_b"].dtype == np.int64 and table["name_b"].tolist() == ["Plate", "Nut"]
    assert len(pf.Scene().check().to_dict()["face_a"]) == 0
    assert pf.check(path, within=0.25, ignore=[("Bolt*", "Plate")], allow=["near"]).allowed
    assert pf.check(path, allow_overlap=0.26).allowed and pf.check(path).to_dict()["relation"].tolist() == ["crossing"]


def test_the_accessor_of_pyvista():
    import pyvista

    pf.register()
    mesh = pyvista.PolyData.from_regular_faces(*ball())
    assert mesh.pfront.relation(mesh, placed(3), within=2) == "near" and mesh.pfront.relation(mesh) == "equal"
    assert mesh.pfront.overlap_volume(mesh) == pf.overlap_volume(ball(), ball())
