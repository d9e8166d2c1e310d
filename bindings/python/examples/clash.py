"""Which parts of an assembly clash, where, and a picture: python clash.py assembly.3mf clash.png"""

import sys

import numpy as np

import pfront as pf

scene = pf.Scene.from_file(sys.argv[1])
# What touches by design is left out: scene.ignore("bolt", "nut").
contacts = scene.show(off_screen=True, screenshot=sys.argv[2])
bodies, row, counts = np.unique(contacts.bodies, axis=0, return_inverse=True, return_counts=True)
for i, (names, count) in enumerate(zip(scene.names(bodies), counts)):
    points = contacts.segments[row.ravel() == i].reshape(-1, 3)
    middle = ", ".join(f"{x:.2f}" for x in (points.min(0) + points.max(0)) / 2)
    print(f"{names[0]:16} {names[1]:16} {count:6} pairs of triangles about ({middle})")
print(f"{len(scene)} parts, {len(bodies)} clashes")
sys.exit(len(bodies) > 0)
