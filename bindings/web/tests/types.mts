// What TypeScript is to accept, and what not.
import { init, Latest, Mesh, MeshError, openWorker, PairQuery, readFile, SceneQuery, type Contacts, type Gap } from "pfront";

import * as gpu from "pfront/gpu";
import * as small from "pfront/small";

await init();
await small.init();
const few: Uint32Array = new small.PairQuery().all(new small.Mesh(new Float32Array(0), new Uint32Array(0)), new small.Mesh(new Float32Array(0), new Uint16Array(0)));
const { positions, triangles } = await readFile(new Uint8Array(0));
await gpu.init();
const device = await gpu.Gpu.open();
const uploaded: gpu.Mesh = await gpu.Mesh.upload(device, positions, triangles);
const found: Uint32Array | undefined = await new gpu.PairQuery(device, 65536).any(uploaded, await gpu.Mesh.fromGeometry(device, { attributes: {}, index: null }), []);
const many: number = await new gpu.SelfQuery(device).count(uploaded);
const mesh = new Mesh(positions, triangles);
const contacts: Contacts = new PairQuery().contacts(mesh, Mesh.fromGeometry({ attributes: {}, index: null }), new Float32Array(16));
const gap: Gap | undefined = new SceneQuery().distance(0);
const word: "apart" | "near" | "touching" | "crossing" | "a_in_b" | "b_in_a" | "equal" | undefined = new PairQuery().relation(mesh, mesh);
const worker = await openWorker();
const [query, remote] = [await worker.make("PairQuery"), await worker.make("Mesh", positions, triangles)];
const latest = new Latest((matrix: number[]) => query.all(remote, remote, matrix));
const pairs: Uint32Array | undefined = await latest.ask([]);
const vertex: number | undefined = new MeshError().vertex;
// @ts-expect-error: numbers are no positions.
new Mesh([0, 0, 0], triangles);
// @ts-expect-error: a mesh in a Worker is none on this thread.
new PairQuery().any(remote, mesh);
export { few, found, many, contacts, gap, word, pairs, vertex };
