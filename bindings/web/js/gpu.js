// `pfront/gpu`: which triangles of two meshes, or of one and itself, intersect, by WebGPU. The answers are those of the CPU.

import * as webgpu from "./webgpu.js";
import { arraysOf, once, start } from "./load.js";

export const { Gpu, Mesh, PairQuery, SelfQuery } = webgpu;
export * from "./errors.js";
export { Latest } from "./latest.js";
export { readFile } from "./load.js";

/** Loads and compiles the module, once, before anything else is called. */
export const init = once(() => start(new URL("./webgpu_bg.wasm", import.meta.url), webgpu));

Mesh.fromGeometry = (gpu, geometry) => Mesh.upload(gpu, ...arraysOf(geometry));

// The lists of a query serve one question at a time: the next waits for its answer.
for (const { prototype } of [PairQuery, SelfQuery]) {
  for (const verb of ["all", "any", "count"]) {
    const ask = prototype[verb];
    prototype[verb] = function (...question) {
      const answer = Promise.resolve(this.last).then(() => ask.apply(this, question));
      this.last = answer.catch(() => {});
      return answer;
    };
  }
}
