// What is asked in Node: every question once, every error, files. Fails by throwing.
import assert from "node:assert/strict";
import * as pf from "pfront";

await pf.init();
const corners = new Float32Array([0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1]);
const tetrahedron = new Uint16Array([0, 2, 1, 0, 1, 3, 0, 3, 2, 1, 2, 3]);
const solid = new pf.Mesh(corners, tetrahedron);
const at = (x, y = 0, z = 0) => [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, x, y, z, 1];

// Two meshes.
const query = new pf.PairQuery();
const crossing = query.all(solid, solid, at(0.25, 0.125, 0.0625));
assert.equal(query.count(solid, solid, at(0.25, 0.125, 0.0625)), crossing.length / 2);
assert.ok(crossing instanceof Uint32Array && crossing.length > 0);
assert.equal(query.any(solid, solid, at(2)), undefined);
assert.equal(query.any(solid, solid).length, 2);
const contacts = query.contacts(solid, solid, at(0.25, 0.125, 0.0625));
assert.deepEqual(contacts.pairs, crossing);
assert.equal(contacts.segments.length, 3 * crossing.length);
assert.equal(contacts.normals.length, 3 * crossing.length);
const gap = query.distance(solid, solid, at(1.5));
assert.ok(gap.interval[0] <= 0.5 && 0.5 <= gap.interval[1] && gap.points.length === 6 && gap.body === undefined);
assert.equal(query.distance(solid, solid, at(1.5), 0.25), undefined);
const words = [0, 0.25, 1, 1.5].map((x) => query.relation(solid, solid, at(x)));
assert.deepEqual(words, ["equal", "crossing", "touching", "apart"]);
const [low, high] = query.overlapVolume(solid, solid, at(0.5));
assert.ok(low <= 1 / 48 && 1 / 48 <= high && high - low < 1e-12);
query.within(0.6);
assert.equal(query.relation(solid, solid, at(1.5)), "near");
assert.ok(query.count(solid, solid, at(1.5)) > 0);

// One in f64: what f32 does not tell apart.
const far = (z) => new pf.Mesh(new Float64Array([5e5, 5e6, z, 5e5 + 1, 5e6, z, 5e5, 5e6 + 1, z]), new Uint32Array([0, 1, 2]));
assert.equal(new pf.PairQuery().count(far(1000), far(1000 + 1e-6)), 0);
assert.equal(new pf.PairQuery().count(far(1000), far(1000)), 1);
assert.equal(new pf.PairQuery().count(solid, solid, new Float64Array(at(1 + 1e-12))), 0);
assert.ok(far(1).positions instanceof Float64Array && solid.positions instanceof Float32Array);

// One with itself, as it moves; and as bytes.
const fold = new pf.Mesh(new Float32Array([0, 0, 0, 4, 0, 0, 0, 4, 0, 1, 1, 2, 1, 1, 3, 9, 9, 9]), new Uint32Array([0, 1, 2, 3, 4, 5]));
const itself = new pf.SelfQuery();
assert.equal(itself.any(fold), undefined);
fold.setPositions(new Float32Array([0, 0, 0, 4, 0, 0, 0, 4, 0, 1, 1, -1, 1, 1, 1, 9, 9, 9]));
assert.deepEqual(itself.all(fold), new Uint32Array([0, 1]));
assert.equal(itself.contacts(pf.Mesh.fromBlob(fold.toBlob())).pairs.length, 2);

// Many.
const scene = new pf.SceneQuery();
const [left, right] = [scene.add(solid), scene.add(solid, at(3))];
assert.equal(scene.count(), 0);
assert.equal(scene.distance(left).body, right);
scene.setPose(right, at(0.5));
assert.deepEqual(scene.intersectingBodies(), new Uint32Array([left, right]));
assert.deepEqual([...scene.contacts().bodies.subarray(0, 2)], [left, right]);
assert.equal(scene.all().length, 4 * scene.count());
assert.equal(scene.any().length, 4);
scene.ignore(left, right, true);
assert.equal(scene.count(), 0);
scene.remove(left);

// A geometry as three.js has it, without three.js.
const attribute = (array) => ({ array, itemSize: 3, count: array.length / 3 });
const geometry = { attributes: { position: attribute(corners) }, index: { array: tetrahedron } };
assert.equal(pf.Mesh.fromGeometry(geometry).triangleCount, 4);

// There is no GPU in Node.
const gpu = await import("pfront/gpu");
await gpu.init();
await assert.rejects(gpu.Gpu.open(), gpu.GpuError);

// Files.
const obj = new TextEncoder().encode("v 0 0 0\nv 1 0 0\nv 1 1 0.1\nv 0 1 0\nf 1 2 3 4\n");
const file = await pf.readFile(obj);
assert.deepEqual([file.triangles, file.positions[8]], [new Uint32Array([0, 1, 2, 0, 2, 3]), Math.fround(0.1)]);
assert.equal((await pf.readFile(obj, { f64: true })).positions[8], 0.1);
const text = (lines) => new TextEncoder().encode(lines.join("\n"));
const points = ["0 0 0", "1 0 0", "0 1 0"];
const header = ["ply", "format ascii 1.0", "element vertex 3", ...["x", "y", "z"].map((x) => `property float ${x}`)];
const ply = text([...header, "element face 1", "property list uchar int vertex_indices", "end_header", ...points, "3 0 1 2\n"]);
const stl = text(["solid a", "facet normal 0 0 1", "outer loop", ...points.map((p) => `vertex ${p}`), "endloop", "endfacet", "endsolid a"]);
const json = JSON.stringify({
  asset: { version: "2.0" }, scene: 0, scenes: [{ nodes: [0] }], nodes: [{ mesh: 0 }], buffers: [{ byteLength: 36 }],
  meshes: [{ primitives: [{ attributes: { POSITION: 0 } }] }], bufferViews: [{ buffer: 0, byteLength: 36 }],
  accessors: [{ bufferView: 0, componentType: 5126, count: 3, type: "VEC3", min: [0, 0, 0], max: [1, 1, 0] }],
});
const chunk = (kind, data) => [...new Uint8Array(new Uint32Array([data.length, kind]).buffer), ...data];
const chunks = [...chunk(0x4e4f534a, text([json.padEnd(Math.ceil(json.length / 4) * 4)])), ...chunk(0x4e4942, new Uint8Array(corners.slice(0, 9).buffer))];
const glb = new Uint8Array([...new Uint8Array(new Uint32Array([0x46546c67, 2, 12 + chunks.length]).buffer), ...chunks]);
const threemf = [
  "UEsDBBQAAAAIAD07fF2JB20t1QAAAIEBAAAQAAAAM0QvM2Rtb2RlbC5tb2RlbHVPW27DMAy7iuEDRHGK/Qy2e5bUURsNfhS2EqQ9/RxnQPOzH4EASZHU1y14sWIulKKRquvl1eqQJvRiicRGBvKeAj",
  "JmKao2FiNn5uc3QHEzhrF0gVxOJd25cynAZQpjXO6j4yVTfIBLGWHo1Rf0g7Q6Y0lLdlisTrcfdCxoqrlS8OuJNW1PrrKAZba69mJq2h3hJjYjeyle7b73C2dK/U8dLvWh4PObM43x4c9QrKp51qGZ",
  "1ouRQ3OdtHB0hGNGBadpt4X8ZDUxBnHwx8r9xR8Hbar9BVBLAwQUAAAACAA9O3xdiBPYBaEAAADuAAAACwAAAF9yZWxzLy5yZWxzZY9NCsIwEIWvEuYAmdSCC2najRu30gsMaZoGmx+SVPT2RkGwuB",
  "l48958j+mGh1vZXadsg5fQcAFD3131SqUu8mJjZjXhs4SllHhCzGrRjjIPUfvqzCE5KlUmg5HUjYzGgxBHTL8M2DPZSMnoIgHbM7aTC5Ne+WcCu0wSErDxGfVfp7MqhRzmwlVw70Py20yqbMl6U2ub",
  "FkXzBQL2He4+6V9QSwECFAMUAAAACAA9O3xdiQdtLdUAAACBAQAAEAAAAAAAAAAAAAAAgAEAAAAAM0QvM2Rtb2RlbC5tb2RlbFBLAQIUAxQAAAAIAD07fF2IE9gFoQAAAO4AAAALAAAAAAAAAAAAAA",
  "CAAQMBAABfcmVscy8ucmVsc1BLBQYAAAAAAgACAHcAAADNAQAAAAA=",
].join("");
const zipped = Uint8Array.from(atob(threemf), (c) => c.charCodeAt(0));
for (const [format, given] of Object.entries({ ply, stl, glb, "3mf": zipped })) {
  const read = await pf.readFile(given, { format });
  assert.deepEqual([read.positions, read.triangles], [corners.slice(0, 9), new Uint32Array([0, 1, 2])], format);
}
await assert.rejects(pf.readFile(new Uint8Array([1, 2, 3])), { name: "FileError" });

// Errors name what is at fault, and leave all as it was.
const fails = (ask, expected) => assert.throws(ask, (fault) => (assert.equal(typeof fault.message, "string"), Object.entries(expected).every(([key, value]) => (assert.equal(fault[key], value, fault.message), true))));
fails(() => new pf.Mesh(new Float32Array([0, 0, 0, NaN, 0, 0]), tetrahedron), { name: "MeshError", vertex: 1 });
fails(() => new pf.Mesh(corners, new Uint32Array([0, 1, 2, 0, 1, 4])), { name: "MeshError", triangle: 1 });
fails(() => new pf.Mesh([0, 0, 0], tetrahedron), { name: "TypeError" });
fails(() => new pf.Mesh(corners, new Int8Array(3)), { name: "TypeError" });
fails(() => new pf.Mesh(corners, new Uint32Array(4)), { name: "TypeError" });
fails(() => query.all(solid, solid, at(NaN)), { name: "PoseError", row: 0, column: 3 });
fails(() => query.all(solid, solid, [...at(1).slice(0, 3), 1, ...at(1).slice(4)]), { name: "PoseError", row: 3, column: 0 });
fails(() => query.all(solid, solid, [1n]), { name: "TypeError" });
fails(() => query.all(solid, {}), { name: "Error" });
fails(() => query.within(-1), { name: "DistanceError" });
fails(() => query.relation(solid, fold), { name: "NotSolid", mesh: "b", triangle: 0 });
fails(() => pf.Mesh.fromBlob(new Uint8Array(7)), { name: "BlobError" });
fails(() => scene.setPose(left, at(0)), { name: "StaleBody", body: left });
fails(() => fold.setPositions(new Float32Array(3)), { name: "MeshError" });
assert.ok(query.count(solid, solid, at(0)) > 0);
assert.ok(new pf.MeshError() instanceof pf.PfrontError);

// One question under way, and the latest that waits.
const latest = new pf.Latest(async (x) => x);
assert.deepEqual(await Promise.all([1, 2, 3].map((x) => latest.ask(x))), [1, undefined, 3]);
// The small module: the same, without what it lacks.
const small = await import("pfront/small");
await small.init();
const twin = new small.Mesh(corners, tetrahedron);
const few = new small.PairQuery();
const turned = at(0.25, 0.125, 0.0625);
assert.deepEqual(few.contacts(twin, twin, turned), new pf.PairQuery().contacts(solid, solid, turned));
assert.deepEqual(few.all(twin, twin, turned), crossing);
assert.equal(few.count(twin, twin, turned), crossing.length / 2);
assert.equal(few.any(twin, twin, at(2)), undefined);
const folded = small.Mesh.fromBlob(fold.toBlob());
assert.deepEqual(new small.SelfQuery().all(folded), itself.all(fold));
assert.equal(new small.SelfQuery(true).contacts(folded).pairs.length, 2);
assert.deepEqual(folded.toBlob(), fold.toBlob());
folded.setPositions(new Float32Array([0, 0, 0, 4, 0, 0, 0, 4, 0, 1, 1, 2, 1, 1, 3, 9, 9, 9]));
assert.equal(new small.SelfQuery().any(folded), undefined);
assert.equal(small.Mesh.fromGeometry(geometry).vertexCount, 4);
fails(() => new small.Mesh(new Float64Array(9), new Uint32Array([0, 1, 2])), { name: "PfrontError" });
fails(() => small.Mesh.fromBlob(far(1).toBlob()), { name: "PfrontError" });
fails(() => new small.Mesh(corners, new Uint32Array([0, 1, 4])), { name: "MeshError", triangle: 0 });
fails(() => folded.setPositions(new Float32Array([NaN, ...Array(17).fill(0)])), { name: "MeshError", vertex: 0 });
fails(() => few.count(twin, twin, at(Infinity)), { name: "PoseError", row: 0 });
fails(() => few.count(twin, twin, new Float64Array(at(1))), { name: "PfrontError" });
console.log("node: every question, error and file");
