// three-mesh-bvh, asked the same.

import { BufferAttribute, BufferGeometry, Matrix4 } from "three";
import { MeshBVH, SAH } from "three-mesh-bvh";

export function geometryOf(positions, triangles) {
  const geometry = new BufferGeometry().setAttribute("position", new BufferAttribute(positions, 3));
  return geometry.setIndex(new BufferAttribute(triangles, 1));
}

/** Positions in a pose, rounded as pfront rounds them. */
export function posed(positions, m) {
  const [f, out] = [Math.fround, new Float32Array(positions.length)];
  const r = m.map(f);
  for (let i = 0; i < positions.length; i += 3) {
    const [x, y, z] = [positions[i], positions[i + 1], positions[i + 2]];
    for (let c = 0; c < 3; c++) out[i + c] = f(f(f(f(r[c] * x) + f(r[4 + c] * y)) + f(r[8 + c] * z)) + r[12 + c]);
  }
  return out;
}

/** The BVH of its own kind: indirect, so that triangles keep their numbers. */
export const bvhOf = (geometry, targetLeafSize = 10) => new MeshBVH(geometry, { strategy: SAH, indirect: true, targetLeafSize });

/** All pairs that it finds, and the milliseconds that takes. */
export function cast(a, b, matrix = new Matrix4()) {
  const pairs = [];
  const start = performance.now();
  a.bvhcast(b, matrix, {
    intersectsTriangles(s, t, i, j) {
      if (s.intersectsTriangle(t)) pairs.push(i, j);
      return false;
    },
  });
  const ms = performance.now() - start;
  for (let k = 0; k < pairs.length; k += 2) {
    pairs[k] = a.resolveTriangleIndex(pairs[k]);
    pairs[k + 1] = b.resolveTriangleIndex(pairs[k + 1]);
  }
  return { pairs, ms };
}

/** How many of the true pairs are not among those that were found, and how many of these are not true. */
export function compare(truth, found) {
  const key = (list, k) => list[k] * 2 ** 26 + list[k + 1];
  const keys = (list) => new Set(Array.from({ length: list.length / 2 }, (_, k) => key(list, 2 * k)));
  const [real, own] = [keys(truth), keys(found)];
  let common = 0;
  for (const k of own) common += real.has(k);
  return { missed: real.size - common, invented: own.size - common };
}
