// The GPU, asked the same.

import { Gpu, init, Latest, Mesh, PairQuery, SelfQuery } from "pfront/gpu";

await init();
const gpu = await Gpu.open();
const [pair, itself] = [new PairQuery(gpu), new SelfQuery(gpu)];

/** All pairs of bodies of the page, and the milliseconds that takes; or `undefined`, if more is asked meanwhile. */
export const gpuPairs = new Latest(async (bodies, matrix) => {
  for (const body of bodies) body.onGpu ??= await Mesh.upload(gpu, body.geometry.attributes.position.array, body.geometry.index.array);
  const [a, b] = bodies.map((body) => body.onGpu);
  const start = performance.now();
  const pairs = await (b ? pair.all(a, b, matrix) : itself.all(a));
  return { pairs, ms: performance.now() - start };
});
