// The npm package `pfront`: what the compiled half has, and what is easier in JavaScript.

import start, { initSync, Mesh, PairQuery, SelfQuery, SceneQuery } from "./cpu.js";
import { error } from "./errors.js";
import { bytes } from "./values.js";

export { Mesh, PairQuery, SelfQuery, SceneQuery };
export * from "./errors.js";
export { Latest } from "./latest.js";
export { openWorker } from "./remote.js";

let started;

/** Loads and compiles the module, once, before anything else is called. */
export function init() {
  return (started ??= load(new URL("./cpu_bg.wasm", import.meta.url), start, initSync).catch((fault) => {
    started = undefined;
    throw fault;
  }));
}

let files;

/** The triangles of a file: OBJ, STL, PLY, OFF, GLB, 3MF or `.pfb`. Readers are loaded when a file is first read. */
export async function readFile(given, { format, f64 = false } = {}) {
  files ??= import("./files.js").then(async (module) => {
    await load(new URL("./files_bg.wasm", import.meta.url), module.default, module.initSync);
    return module;
  });
  const { Contents } = await files.catch((fault) => {
    files = undefined;
    throw fault;
  });
  const contents = new Contents(bytes(given), format, f64);
  const bodies = contents.names().map((name, i) => ({ name, triangles: contents.body(i) }));
  const read = { positions: contents.positions(), triangles: contents.triangles(), bodies, notes: contents.notes() };
  contents.free();
  return read;
}

/** The mesh of a BufferGeometry of three.js, with its index or without; its draw range and groups are not looked at. */
Mesh.fromGeometry = (geometry) => {
  const { position } = geometry.attributes;
  if (position?.itemSize !== 3) throw error("MeshError", "the geometry has no positions of three coordinates");
  let positions = position.array;
  if (position.isInterleavedBufferAttribute || position.normalized || !(positions instanceof Float32Array)) {
    positions = new Float32Array(3 * position.count);
    for (let i = 0; i < position.count; i++) positions.set([position.getX(i), position.getY(i), position.getZ(i)], 3 * i);
  }
  const triangles = geometry.index?.array ?? Uint32Array.from({ length: position.count }, (_, i) => i);
  return new Mesh(positions.subarray(0, 3 * position.count), triangles);
};

async function load(url, start, startSync) {
  // Node's fetch reads no files.
  if (url.protocol === "file:" && globalThis.process?.versions?.node) {
    const { readFile } = await import(/* webpackIgnore: true */ /* @vite-ignore */ "node:fs/promises");
    startSync({ module: await readFile(url) });
  } else {
    await start({ module_or_path: url });
  }
}
