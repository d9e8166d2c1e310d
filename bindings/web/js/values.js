// Checks what comes in, and makes what goes out: called from the compiled half. A view into its memory is copied at once.

import { error } from "./errors.js";

const kind = (value) => Object.prototype.toString.call(value).slice(8, -1);

function check(ok, message) {
  if (!ok) throw new TypeError(message);
}

export function isF64(positions) {
  const is = kind(positions);
  check(is === "Float32Array" || is === "Float64Array", "positions are a Float32Array or a Float64Array");
  check(positions.length % 3 === 0, `positions are three numbers for each vertex, not ${positions.length} in all`);
  return is === "Float64Array";
}

export function indices(triangles) {
  const is = kind(triangles);
  check(/^Uint(32|16|8)Array$/.test(is), "triangles are a Uint32Array, a Uint16Array or a Uint8Array");
  check(triangles.length % 3 === 0, `triangles are three indices each, not ${triangles.length} in all`);
  return is === "Uint32Array" ? triangles : Uint32Array.from(triangles);
}

export function bytes(given) {
  const is = kind(given);
  check(is === "Uint8Array" || is === "ArrayBuffer", "bytes are a Uint8Array or an ArrayBuffer");
  return is === "ArrayBuffer" ? new Uint8Array(given) : given;
}

export function numbers(matrix) {
  const is = kind(matrix);
  const ok = is === "Array" || is === "Float32Array" || is === "Float64Array";
  check(ok && matrix.length === 16, "a matrix is 16 numbers by columns, as the elements of a Matrix4");
  for (let column = 0; column < 4; column++) {
    if (matrix[4 * column + 3] !== (column === 3 ? 1 : 0)) {
      throw error("PoseError", "row 3 of the matrix is not 0 0 0 1: it is not affine", "row column", [3, column]);
    }
  }
  return Float64Array.from(matrix);
}

export const copyU32 = (list) => list.slice();
export const copyF32 = copyU32;
export const copyF64 = copyU32;
export const copyU8 = copyU32;

export function contacts(pairs, segments, normals, flat, bodies) {
  const found = { pairs: pairs.slice(), segments: segments.slice(), normals: normals.slice(), flat: flat.slice() };
  return bodies === undefined ? found : { ...found, bodies: bodies.slice() };
}

export function gap(pair, interval, points, body) {
  const found = { interval: interval.slice(), pair: pair.slice(), points: points.slice() };
  return body === undefined ? found : { ...found, body };
}
