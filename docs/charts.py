#!/usr/bin/env python3
"""Draws docs/pareto.svg out of benches/record/pareto.csv, which `pfront-lab chart` writes: time against wrong answers."""
import csv, math, pathlib
from html import escape
HERE = pathlib.Path(__file__).parent
COLOURS = "#0072b2 #d55e00 #009e73 #a0428a #000000 #b07a00 #3a86c8 #777777 #8b4513 #e377c2".split()
MARKS = ["M-5,0a5,5 0 1,0 10,0a5,5 0 1,0 -10,0z", "M-4.5,-4.5h9v9h-9z", "M0,-6L5.5,4.5h-11z", "M0,-6L6,0L0,6L-6,0z", "M0,6L5.5,-4.5h-11z"]
WIDTH, HEIGHT, LEFT, RIGHT, TOP, BOTTOM = 400, 270, 74, 12, 40, 46
SOURCES = {"family": "made to be hard", "contact": "from scenes in contact", "family in f64": "made to be hard, in f64"}


def text(x, y, size, anchor, words, more=""):
    return f'<text x="{x:.1f}" y="{y:.1f}" font-size="{size}" text-anchor="{anchor}" {more}>{escape(words)}</text>'


def panel(x0, y0, title, what, points, names):
    """Points are (test, ns, wrong per million); both axes have ticks at powers of ten, and 0 is a line of its own."""
    left, right, top, bottom = x0 + LEFT, x0 + WIDTH - RIGHT, y0 + TOP, y0 + HEIGHT - BOTTOM
    xs = [math.log10(ns) for _, ns, _ in points]
    ys = [math.log10(wrong) for _, _, wrong in points if wrong > 0] or [0]
    x_range, y_range = (math.floor(min(xs)), math.ceil(max(xs))), (math.floor(min(ys)), math.ceil(max(ys)) + (max(ys) == min(ys)))
    at_x = lambda x: left + (right - left) * (x - x_range[0]) / max(x_range[1] - x_range[0], 1)
    # The line of 0 lies below all powers of ten.
    at_y = lambda y: bottom - 26 - (bottom - 26 - top) * (y - y_range[0]) / max(y_range[1] - y_range[0], 1)
    zero = bottom - 8
    out = [text(left, top - 14, 14, "start", title), text(right, bottom + 38, 12, "end", "ns per triangle pair, one thread")]
    lines = [(left, zero, right, zero, "#888"), (left, bottom, right, bottom, "#000"), (left, top, left, bottom, "#000")]
    out.append(text(left - 6, zero + 4, 12, "end", "0"))
    for x in range(x_range[0], x_range[1] + 1):
        lines.append((at_x(x), bottom, at_x(x), top, "#ddd"))
        out.append(text(at_x(x), bottom + 16, 12, "middle", f"{10**x:,}"))
    for y in range(y_range[0], y_range[1] + 1):
        lines.append((left, at_y(y), right, at_y(y), "#ddd"))
        out.append(text(left - 6, at_y(y) + 4, 12, "end", f"{10**y:,}"))
    middle = (top + bottom) / 2
    out.append(text(x0 + 14, middle, 12, "middle", f"{what} per million", f'transform="rotate(-90 {x0 + 14} {middle})"'))
    out[:0] = [f'<line x1="{a:.1f}" y1="{b:.1f}" x2="{c:.1f}" y2="{d:.1f}" stroke="{colour}"/>' for a, b, c, d, colour in lines]
    return out + [mark(at_x(math.log10(ns)), at_y(math.log10(wrong)) if wrong else zero, names.index(test)) for test, ns, wrong in points]


def mark(x, y, number):
    colour, path = COLOURS[number % len(COLOURS)], MARKS[number % len(MARKS)]
    return f'<path d="{path}" transform="translate({x:.1f} {y:.1f})" fill="{colour}" stroke="black" stroke-width="0.7"/>'


rows = list(csv.DictReader(open(HERE.parent / "benches/record/pareto.csv")))
names, body = list(dict.fromkeys(row["test"] for row in rows)), []
for number, (source, kind) in enumerate(SOURCES.items()):
    own = [row for row in rows if row["source"] == source]
    for column, what in enumerate(("missed", "false_hits")):
        points = []
        for test in dict.fromkeys(row["test"] for row in own):
            pairs, time, wrong = (sum(int(r["pairs"]) * f(r) for r in own if r["test"] == test) for f in (lambda r: 1, lambda r: float(r["ns_per_pair"]), lambda r: int(r[what]) / int(r["pairs"])))
            points.append((test, time / pairs, 1e6 * wrong / pairs))
        title = f"{len({r['set'] for r in own})} sets {kind}"
        body += panel(WIDTH * column, HEIGHT * number, title, what.replace("_", " "), points, names)
for number, name in enumerate(names):
    body += [mark(2 * WIDTH + 20, 60 + 24 * number, number), text(2 * WIDTH + 34, 64 + 24 * number, 13, "start", name)]
size = f'width="{2 * WIDTH + 250}" height="{3 * HEIGHT}"'
(HERE / "pareto.svg").write_text(f'<svg xmlns="http://www.w3.org/2000/svg" {size} font-family="sans-serif">\n<rect width="100%" height="100%" fill="white"/>\n' + "\n".join(body) + "\n</svg>\n")
