// pfront.wasm asked from JavaScript: the two rings of engine.c. Prints how many pairs meet in each frame.
// usage: node wasm.mjs pfront.wasm

import { readFile } from "node:fs/promises";

const { instance } = await WebAssembly.instantiate(await readFile(process.argv[2]));
const pfront = instance.exports;
const fround = Math.fround;
const [COLUMNS, ROWS, FRAMES, PAGE] = [40, 24, 8, 64];
const [VERTICES, TRIANGLES] = [COLUMNS * ROWS, 2 * COLUMNS * ROWS];

// All memory is ours: behind what the library has for itself, piece by piece.
let free = pfront.__heap_base.value;
function memory(bytes) {
  const at = (free + 15) & ~15;
  free = at + bytes;
  const missing = free - pfront.memory.buffer.byteLength;
  if (missing > 0) pfront.memory.grow(Math.ceil(missing / 65536));
  return at;
}
const words = (at, count) => new Uint32Array(pfront.memory.buffer, at, count);
const floats = (at, count) => new Float32Array(pfront.memory.buffer, at, count);

function check(status) {
  if (status === 0) return;
  const bytes = new Uint8Array(pfront.memory.buffer, pfront.pfront_error_text(status));
  throw new Error(new TextDecoder().decode(bytes.subarray(0, bytes.indexOf(0))));
}

// The point a share of the way around the unit circle, rounded as in C.
function onCircle(step, of) {
  const quarter = Math.floor((4 * (step % of)) / of);
  const t = fround(((4 * (step % of)) % of) / of);
  const square = fround(t * t);
  const x = fround(fround(1 - square) / fround(1 + square));
  const y = fround(fround(2 * t) / fround(1 + square));
  return [[x, y], [-y, x], [-x, -y], [y, -x]][quarter];
}

function ring(bump) {
  const positions = memory(12 * VERTICES);
  const out = floats(positions, 3 * VERTICES);
  for (let i = 0, k = 0; i < COLUMNS; i++) {
    for (let j = 0; j < ROWS; j++) {
      const [around, across] = [onCircle(i, COLUMNS), onCircle(j, ROWS)];
      const tube = fround(fround(0.4) + fround(fround(bump) * onCircle(5 * i, COLUMNS)[0]));
      const fromAxis = fround(1 + fround(tube * across[0]));
      out[k++] = around[0] * fromAxis;
      out[k++] = around[1] * fromAxis;
      out[k++] = tube * across[1];
    }
  }
  return positions;
}

function grid() {
  const triangles = memory(12 * TRIANGLES);
  const out = words(triangles, 3 * TRIANGLES);
  for (let i = 0, k = 0; i < COLUMNS; i++) {
    for (let j = 0; j < ROWS; j++) {
      const [next, up] = [((i + 1) % COLUMNS) * ROWS, (j + 1) % ROWS];
      const [p, q, r, s] = [i * ROWS + j, i * ROWS + up, next + j, next + up];
      out.set([p, r, s, p, s, q], k);
      k += 6;
    }
  }
  return triangles;
}

// Structures are larger in C for 64 bits; where a member is wanted, its offset is that of 32.
function model(positions, triangles) {
  const [mesh, bvh, room] = [memory(64), memory(64), memory(24)];
  check(pfront.pfront_mesh_check(positions, VERTICES, triangles, TRIANGLES, mesh, 0));
  const nodes = pfront.pfront_node_bound(TRIANGLES);
  const scratch = pfront.pfront_sah_scratch_bytes(TRIANGLES);
  const members = [memory(32 * nodes), nodes, memory(4 * TRIANGLES), TRIANGLES, memory(scratch), scratch];
  words(room, 6).set(members);
  check(pfront.pfront_bvh_build_sah(mesh, 0, room, bvh, 0));
  return bvh;
}

const triangles = grid();
const [a, b] = [model(ring(0), triangles), model(ring(0.3), triangles)];
const [pose, query, cursor] = [memory(48), memory(256), memory(3936)];
const [page, count] = [memory(8 * PAGE), memory(4)];
for (let frame = 0; frame < FRAMES; frame++) {
  const [x, y] = onCircle(frame, 4 * FRAMES);
  floats(pose, 12).set([x, 0, y, 0.5, 0, 1, 0, 0.25, -y, 0, x, 1 - 0.125 * frame]);
  check(pfront.pfront_query_pair(a, b, pose, query, 0));
  check(pfront.pfront_cursor_start(query, cursor, 0));
  let pairs = 0;
  while (words(cursor, 2)[1] === 0) {
    check(pfront.pfront_query_page(query, cursor, page, PAGE, count, 0));
    pairs += words(count, 1)[0];
  }
  console.log(`frame ${frame}: ${pairs} pairs`);
}
