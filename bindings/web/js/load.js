// What all modules need: loading, files, geometries of three.js.

import { error } from "./errors.js";
import { bytes } from "./values.js";

/** A function that loads and compiles a module once; one that failed is tried again. */
export function once(load) {
  let loading;
  return () =>
    (loading ??= load().catch((fault) => {
      loading = undefined;
      throw fault;
    }));
}

/** Compiles the module at a URL by the functions that wasm-bindgen has made for it. */
export async function start(url, { default: init, initSync }) {
  // Node's fetch reads no files.
  if (url.protocol === "file:" && globalThis.process?.versions?.node) {
    const { readFile } = await import(/* webpackIgnore: true */ /* @vite-ignore */ "node:fs/promises");
    initSync({ module: await readFile(url) });
  } else {
    await init({ module_or_path: url });
  }
}

const files = once(async () => {
  const module = await import("./files.js");
  await start(new URL("./files_bg.wasm", import.meta.url), module);
  return module;
});

/** The triangles of a file: OBJ, STL, PLY, OFF, GLB, 3MF or `.pfb`. Readers are loaded when a file is first read. */
export async function readFile(given, { format, f64 = false } = {}) {
  const { Contents } = await files();
  const contents = new Contents(bytes(given), format, f64);
  const bodies = contents.names().map((name, i) => ({ name, triangles: contents.body(i) }));
  const read = { positions: contents.positions(), triangles: contents.triangles(), bodies, notes: contents.notes() };
  contents.free();
  return read;
}

/** Makes a mesh of a BufferGeometry of three.js, with its index or without; its draw range and groups are not looked at. */
export const fromGeometry = (Mesh) => (geometry) => new Mesh(...arraysOf(geometry));

/** The positions and triangles of a BufferGeometry. */
export function arraysOf(geometry) {
  const { position } = geometry.attributes;
  if (position?.itemSize !== 3) throw error("MeshError", "the geometry has no positions of three coordinates");
  let positions = position.array;
  if (position.isInterleavedBufferAttribute || position.normalized || !(positions instanceof Float32Array)) {
    positions = new Float32Array(3 * position.count);
    for (let i = 0; i < position.count; i++) positions.set([position.getX(i), position.getY(i), position.getZ(i)], 3 * i);
  }
  const triangles = geometry.index?.array ?? Uint32Array.from({ length: position.count }, (_, i) => i);
  return [positions.subarray(0, 3 * position.count), triangles];
}
