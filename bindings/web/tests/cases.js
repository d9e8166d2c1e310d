// In a page: recorded cases, asked on this thread or in a Worker. `/data` is the folder with `oracle`.

import * as all from "/pfront/index.js";
import * as gpus from "/pfront/gpu.js";
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

function compare(name, pairs, truth) {
  const same = pairs.length === truth.length && pairs.every((x, i) => x === truth[i]);
  if (!same) throw new Error(`${name}: ${pairs.length / 2} pairs, not the ${truth.length / 2} that are recorded`);
}

/** Asks a GPU every case of at most so many pairs, in lists of a budget of bytes, and returns the number of pairs of each. */
export async function checkGpu({ budget, most = Infinity } = {}) {
  const { Gpu, GpuError, Mesh, PairQuery, SelfQuery, init } = gpus;
  await Promise.all([init(), all.init()]);
  const gpu = await Gpu.open();
  const query = new PairQuery(gpu, budget);
  const counts = {};
  for (const one of await cases()) {
    const { meshes, matrix, truth } = await load(one);
    if (truth.length > 2 * most) continue;
    const [a, b] = await Promise.all(meshes.map((mesh) => Mesh.upload(gpu, mesh.positions, mesh.triangles)));
    // All at once: a query answers one after the other.
    const [pairs, any, count] = await Promise.all([query.all(a, b, matrix), query.any(a, b, matrix), query.count(a, b, matrix)]);
    compare(one.name, pairs, truth);
    if (count !== truth.length / 2) throw new Error(`${one.name}: ${count} pairs are counted`);
    const has = (pair) => truth.some((x, i) => i % 2 === 0 && x === pair[0] && truth[i + 1] === pair[1]);
    if (any ? !has(any) : truth.length) throw new Error(`${one.name}: any is ${any}`);
    counts[one.name] = truth.length / 2;
    for (const mesh of [a, b]) mesh.free();
  }
  // A mesh with itself: a torus that a second one, in the same mesh, goes through.
  const mesh = tori();
  const truth = new all.SelfQuery().all(new all.Mesh(...mesh));
  const [own, itself] = [await Mesh.upload(gpu, ...mesh), new SelfQuery(gpu, false, budget)];
  compare("tori", await itself.all(own), truth);
  if ((await itself.count(own)) !== truth.length / 2 || !(await itself.any(own))) throw new Error("tori: count or any");
  counts.tori = truth.length / 2;
  const refused = await Mesh.upload(gpu, new Float32Array([NaN, 0, 0]), new Uint32Array(0)).catch((fault) => fault);
  if (refused.constructor.name !== "MeshError" || refused.vertex !== 0) throw new Error(`a mesh of NaN: ${refused}`);
  try {
    new PairQuery(gpu, 1000);
    throw new Error("a budget of 1,000 bytes is accepted");
  } catch (fault) {
    if (!(fault instanceof GpuError)) throw fault;
  }
  return counts;
}

/** Two tori of one mesh, linked so that they intersect. */
function tori(rings = 48, sides = 24) {
  const [positions, triangles] = [[], []];
  for (const turned of [0, 1]) {
    const first = positions.length / 3;
    for (let i = 0; i < rings; i++) {
      for (let j = 0; j < sides; j++) {
        const [u, v] = [(2 * Math.PI * i) / rings, (2 * Math.PI * j) / sides];
        const [x, y, z] = [(1 + 0.3 * Math.cos(v)) * Math.cos(u), (1 + 0.3 * Math.cos(v)) * Math.sin(u), 0.3 * Math.sin(v)];
        positions.push(...(turned ? [x + 0.55, z + 0.01, y + 0.02] : [x, y, z]));
        const at = (di, dj) => first + ((i + di) % rings) * sides + ((j + dj) % sides);
        triangles.push(at(0, 0), at(1, 0), at(1, 1), at(0, 0), at(1, 1), at(0, 1));
      }
    }
  }
  return [new Float32Array(positions), new Uint32Array(triangles)];
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
    compare(one.name, await query.all(a, b, matrix), truth);
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
