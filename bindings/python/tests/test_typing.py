"""What a type checker finds, and what `help` and the README list."""

import re
import subprocess
import sys

from conftest import TOP

import pfront as pf

GOOD = """\
import numpy as np
import pfront as pf

a = pf.Mesh([[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 1, 2]])
pose, poses = np.eye(4, dtype=np.float32), np.zeros((3, 4, 4))
hit: bool = pf.collides(a, "b.stl", pose)
hits = pf.pairs(a, a, [[1, 0, 0], [0, 1, 0], [0, 0, 1]])
one: tuple[int, int] | None = pf.first(a)
contacts = pf.contacts(a, (a.vertices, a.faces), pose)
normals = contacts[~contacts.flat][:3].normals
many = pf.contacts(a, a, poses)
lengths = [len(found.segments) for found in many[1:]]
unknown = pf.count(a, a, np.tile(pose, (3, 1, 1))).sum()  # whose shape no type tells
counts: list[int] = [count for _, count in pf.sweep(a, a, poses, "count", chunk=2)]
near: bool = pf.collides(a, a, pose, within=0.5)
gap = pf.distance(a, a, pose, limit=2.0)
low: float = 0.0 if gap is None else gap.interval[0]
gaps = pf.distance(a, a, poses)
below = [found.pair for found in gaps[gaps.distances < 1] if found is not None]
reached = [found.distance for _, found in pf.sweep(a, a, poses, "distance", limit=1) if found]
word: str | None = pf.relation(a, a, pose, within=0.5)
words = pf.relation(a, a, poses) == "crossing"
low, high = pf.overlap_volume(a, a, pose)
volumes = pf.overlap_volume(a, a, poses)[:, 1].max()
inside = [word == "a_in_b" for _, word in pf.sweep(a, a, poses, "relation", within=1)]
common = [high - low for _, (low, high) in pf.sweep(a, a, poses, "overlap_volume")]
areas: list[float] = [patch.area[1] for patch in pf.patches(a, a, pose) if patch.closed]
report = pf.check({"lid": a, "jar": "jar.stl"}, ignore=[("bolt*", "nut*")], allow=["near"], allow_overlap=0.1)
clashes = [(pair.names, pair.overlap_volume) for pair in report.pairs if not pair.allowed]
openings = [(body, error.face, error.edge) for body, error in report.refused.items()]
scene = pf.Scene.from_file("assembly.3mf", within=0.1)
body: int = scene.add(a, pose, name="arm", itself=True)
scene.ignore("bolt*", body)
right: bool = scene.check(allow=["a_in_b", "b_in_a"]).allowed
scene.set_poses(["arm"], poses[:1])
neighbour = scene.distance("arm")
nearest: int = -1 if neighbour is None else neighbour[0]
table = scene.pairs()[:2].to_dict()["face_a"]
with pf.using(threads=2, device="auto"):
    print(pf.devices()[0]["name"], pf.explain(), scene.contacts().polylines()[0].shape)
"""
MISTAKES = {
    "the name of an option": "pf.collides(a, a, poze=pose)",
    "a distance that is none": 'pf.count(a, a, within="near")',
    "a distance of contacts": "pf.contacts(a, a, within=0.5)",
    "a distance of one mesh": "pf.distance(a)",
    "a distance that may be none": "pf.distance(a, a, pose).distance",
    "a distance of a count": 'pf.sweep(a, a, poses, "count", limit=1)',
    "a body that may be none": 'scene.distance("arm")[0]',
    "a word that is none": 'pf.relation(a, a, pose) == "inside"',
    "a relation of one mesh": "pf.relation(a)",
    "a word that is no relation": 'scene.check(allow=["inside"])',
    "a distance of a volume": 'pf.overlap_volume(a, a, within=1)',
    "a volume that may be none": "report.pairs[0].overlap_volume[1]",
    "a verb": 'pf.sweep(a, a, poses, "contact")',
    "hits taken for contacts": "scene.pairs().segments",
    "pairs taken for contacts": "hits.normals",
    "contacts of many poses taken for those of one": "many.segments",
    "a missing argument": "pf.Mesh(a.vertices)",
    "a pose that is none": 'pf.count(a, a, "identity")',
    "meshes in the place of a pose": "pf.pairs(a, a, a)",
    "a typo in an attribute": "a.vertexes",
    "a typo in a method": "scene.intersecting_body()",
    "a device that is none": 'pf.using(device="cuda")',
    "a key that is none": 'pf.devices()[0]["nam"]',
    "an answer of another kind": "number: str = pf.count(a, a, pose)",
    "an answer that may be none": "pf.first(a)[0]",
    "a scene in the place of a mesh": "pf.collides(scene, a)",
    "a contact by its number": "contacts[3]",
}


def test_mypy_finds_each_mistake_and_nothing_else(tmp_path):
    # A file for each, and all of them in one run.
    files = {tmp_path / "good.py": None}
    (tmp_path / "good.py").write_text(GOOD)
    for i, mistake in enumerate(MISTAKES.values()):
        files[path := tmp_path / f"mistake_{i}.py"] = mistake
        path.write_text(f"{GOOD}{mistake}\n")
    command = [sys.executable, "-m", "mypy", "--strict", "--hide-error-context", "--no-error-summary", *map(str, files)]
    told = subprocess.run(command, capture_output=True, text=True, cwd=tmp_path)
    found = re.findall(r"^(\S+):(\d+): error", told.stdout, re.M)
    last = GOOD.count("\n") + 1
    wrong = [(path.name, str(last)) for path, mistake in files.items() if mistake]
    assert sorted(set(found)) == sorted(wrong), told.stdout + told.stderr


def test_help_and_the_readme_list_everything_that_is_public():
    table = pf.__doc__[pf.__doc__.index("    Meshes\n") : pf.__doc__.index("\n\n>>>")]
    listed, rows = [], re.findall(r"^      (\S+(?:, \S+)*)  ", table, re.M)
    for name in ", ".join(rows).split(", "):
        listed.append(listed[-1].partition(".")[0] + name if name.startswith(".") else name)
    kinds = [pf.Mesh, pf.Scene, pf.Hits, pf.Contacts, pf.Ragged, pf.Gap, pf.Gaps, pf.ContactPatch, pf.Impact, pf.Impacts, pf.CheckReport, pf.CheckedPair, pf.ContactSize]
    members = {f"{kind.__name__}.{name}" for kind in kinds for name in {*vars(kind), *vars(kind).get("__annotations__", ())}}
    assert sorted(listed) == sorted({*pf.__all__, *(name for name in members if "._" not in name)})
    indented = "\n".join(line[4:] for line in table.splitlines())
    assert f"```text\n{indented}\n```" in (TOP / "bindings/python/README.md").read_text()
