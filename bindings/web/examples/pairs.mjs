// Two meshes, one of which moves: in Node, or in a browser after `pfront` has a URL in an import map.
import { init, Mesh, PairQuery } from "pfront";

await init();
const floor = new Mesh(new Float32Array([0, 0, 0, 4, 0, 0, 0, 4, 0]), new Uint32Array([0, 1, 2]));
const blade = new Mesh(new Float32Array([1, 1, -1, 1, 2, -1, 1, 1, 1]), new Uint32Array([0, 1, 2]));
const query = new PairQuery();
for (let frame = 0; frame < 4; frame++) {
  const matrix = [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0.5 * frame, 1]; // as the elements of a Matrix4
  console.log(`frame ${frame}: ${query.count(floor, blade, matrix)} pairs`);
}
