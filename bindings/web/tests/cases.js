// In a page: recorded cases, asked on this thread or in a Worker. `/data` is the folder with `oracle`.

import * as all from "/pfront/index.js";
import * as small from "/pfront/small.js";

const { openWorker, readFile } = all;

export const bytes = async (path) => new Uint8Array(await (await fetch(`/data/${path}`)).arrayBuffer());
export const cases = async () => (await fetch("/data/oracle/cases.json")).json();

/** Two meshes, the matrix of the second, and the true pairs. A second mesh that was recorded as it was posed has no matrix. */
export async function load({ name, a, b, rotation_row_major: r, translation: t }) {
  const read = async (path) => readFile(await bytes(path), { format: path.split(".").pop() });
  const first = await read(a);
  const second = a === b ? { ...first } : await read(b);
  const world = await fetch(`/data/oracle/${name}.b_world.f32le`, { method: "HEAD" });
  let matrix = [r[0], r[3], r[6], 0, r[1], r[4], r[7], 0, r[2], r[5], r[8], 0, ...t, 1];
  if (world.ok) [second.positions, matrix] = [new Float32Array((await bytes(`oracle/${name}.b_world.f32le`)).buffer), undefined];
  const truth = new Uint32Array((await bytes(`oracle/${name}.pairs.u32le`)).buffer);
  return { meshes: [first, second], matrix, truth };
}

/** Asks every case of a module, "all" or "small", or of "all" in a Worker, and returns the number of pairs of each; throws where they are not the true ones. */
export async function check(of) {
  const { init, Mesh, PairQuery } = of === "small" ? small : all;
  await init();
  const worker = of === "worker" && (await openWorker());
  const make = (mesh) => (worker ? worker.make("Mesh", mesh.positions, mesh.triangles) : new Mesh(mesh.positions, mesh.triangles));
  const query = worker ? await worker.make("PairQuery") : new PairQuery();
  const counts = {};
  for (const one of await cases()) {
    const { meshes, matrix, truth } = await load(one);
    const [a, b] = [await make(meshes[0]), await make(meshes[1])];
    const pairs = await query.all(a, b, matrix);
    const same = pairs.length === truth.length && pairs.every((x, i) => x === truth[i]);
    if (!same) throw new Error(`${one.name}: ${pairs.length / 2} pairs, not the ${truth.length / 2} that are recorded`);
    const any = await query.any(a, b, matrix);
    if ((any === undefined) !== (truth.length === 0)) throw new Error(`${one.name}: any`);
    if ((await query.contacts(a, b, matrix)).pairs.length !== truth.length) throw new Error(`${one.name}: contacts`);
    counts[one.name] = truth.length / 2;
    for (const mesh of [a, b]) await mesh.free();
  }
  if (worker) {
    const refused = await worker.make("Mesh", new Float32Array([NaN, 0, 0]), new Uint32Array(0)).catch((fault) => fault);
    if (refused.constructor.name !== "MeshError" || refused.vertex !== 0) throw new Error(`in a Worker: ${refused}`);
    worker.close();
  }
  return counts;
}
