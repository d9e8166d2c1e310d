// `pfront/small`: a third of the size. Which triangles of two meshes, or of one and itself, intersect, in f32.

import * as cpu from "./cpu-small.js";
import { fromGeometry, once, start } from "./load.js";

export const { Mesh, PairQuery, SelfQuery } = cpu;
export * from "./errors.js";
export { Latest } from "./latest.js";
export { readFile } from "./load.js";

/** Loads and compiles the module, once, before anything else is called. */
export const init = once(() => start(new URL("./cpu-small_bg.wasm", import.meta.url), cpu));

Mesh.fromGeometry = fromGeometry(Mesh);
