// The npm package `pfront`, with all questions.

import * as cpu from "./cpu.js";
import { fromGeometry, once, start } from "./load.js";

export const { Mesh, PairQuery, SelfQuery, SceneQuery } = cpu;
export * from "./errors.js";
export { Latest } from "./latest.js";
export { readFile } from "./load.js";
export { openWorker } from "./remote.js";

/** Loads and compiles the module, once, before anything else is called. */
export const init = once(() => start(new URL("./cpu_bg.wasm", import.meta.url), cpu));

Mesh.fromGeometry = fromGeometry(Mesh);
