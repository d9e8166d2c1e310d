// What is drawn: a mesh with its intersecting triangles in red, and the curve in which surfaces meet.

import * as THREE from "three";
import { LineMaterial } from "three/addons/lines/LineMaterial.js";
import { LineSegments2 } from "three/addons/lines/LineSegments2.js";
import { LineSegmentsGeometry } from "three/addons/lines/LineSegmentsGeometry.js";

/** Fewer triangles than these are meant to be seen. */
const FEW = 5000;

/** A mesh; a second one on the same positions has the triangles that intersect. */
export class Body {
  constructor(geometry, color) {
    this.geometry = geometry;
    this.count = geometry.index.count / 3;
    geometry.computeVertexNormals();
    const surface = new THREE.MeshStandardMaterial({ color, roughness: 0.62, metalness: 0.05, side: THREE.DoubleSide });
    surface.flatShading = this.count < FEW;
    this.object = new THREE.Mesh(geometry, surface);
    this.marked = new THREE.BufferGeometry().setAttribute("position", geometry.attributes.position);
    this.marked.setIndex(new THREE.BufferAttribute(new Uint32Array(geometry.index.count), 1).setUsage(THREE.DynamicDrawUsage));
    this.marked.setDrawRange(0, 0);
    const red = new THREE.MeshBasicMaterial({ color: "#ff4d4d", side: THREE.DoubleSide });
    Object.assign(red, { polygonOffset: true, polygonOffsetFactor: -1, polygonOffsetUnits: -1 });
    const overlay = new THREE.Mesh(this.marked, red);
    overlay.frustumCulled = false;
    this.object.add(overlay);
    this.seen = new Uint32Array(this.count);
    this.turn = 0;
  }

  /** Shows the triangles of one side of pairs, or of both. */
  mark(pairs, side) {
    const [own, all] = [this.marked.index, this.geometry.index.array];
    const [first, step] = side === undefined ? [0, 1] : [side, 2];
    let n = 0;
    this.turn++;
    for (let k = first; k < pairs.length; k += step) {
      const triangle = pairs[k];
      if (this.seen[triangle] === this.turn) continue;
      this.seen[triangle] = this.turn;
      for (let c = 0; c < 3; c++) own.array[n++] = all[3 * triangle + c];
    }
    this.marked.setDrawRange(0, n);
    own.clearUpdateRanges();
    own.addUpdateRange(0, n);
    own.needsUpdate = n > 0;
  }

  move(positions) {
    const { position } = this.geometry.attributes;
    position.array.set(positions);
    position.needsUpdate = true;
    this.geometry.computeVertexNormals();
  }

  dispose(scene) {
    scene.remove(this.object);
    for (const object of [this.object, ...this.object.children]) {
      object.geometry.dispose();
      object.material.dispose();
    }
  }
}

/** Segments that are drawn some pixels wide, in buffers that grow. */
export class Curve {
  #material = new LineMaterial({ color: "#ffd84a", linewidth: 2.5 });
  #faint = new LineMaterial({ color: "#ffd84a", linewidth: 2, transparent: true, opacity: 0.25, depthTest: false, depthWrite: false });

  constructor() {
    Object.assign(this.#material, { polygonOffset: true, polygonOffsetFactor: -6, polygonOffsetUnits: -6 });
    this.lines = new LineSegments2(this.#room(1024), this.#material);
    // Behind surfaces it shines through.
    this.hidden = new LineSegments2(this.lines.geometry, this.#faint);
    this.lines.frustumCulled = this.hidden.frustumCulled = false;
  }

  #room(segments) {
    const geometry = new LineSegmentsGeometry().setPositions(new Float32Array(6 * segments));
    geometry.attributes.instanceStart.data.setUsage(THREE.DynamicDrawUsage);
    return geometry;
  }

  set(segments) {
    let { data } = this.lines.geometry.attributes.instanceStart;
    if (data.array.length < segments.length) {
      this.lines.geometry.dispose();
      this.lines.geometry = this.hidden.geometry = this.#room(segments.length / 3);
      ({ data } = this.lines.geometry.attributes.instanceStart);
    }
    data.array.set(segments);
    data.clearUpdateRanges();
    data.addUpdateRange(0, segments.length);
    data.needsUpdate = segments.length > 0;
    this.lines.geometry.instanceCount = segments.length / 6;
    this.lines.visible = this.hidden.visible = segments.length > 0;
  }

  resize(width, height) {
    for (const material of [this.#material, this.#faint]) material.resolution.set(width, height);
  }
}
