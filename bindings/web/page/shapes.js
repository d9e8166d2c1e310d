// Meshes that are computed: closed knots, and a cloth that overturns.

/** A tube around a torus knot, closed in both directions: every edge has two triangles. */
export function knot({ p, q, tube, along = 900, around = 40, radius = 1 }) {
  const positions = new Float32Array(3 * along * around);
  const centre = (t) => {
    const r = radius * (2 + Math.cos(q * t)) * 0.5;
    return [r * Math.cos(p * t), r * Math.sin(p * t), radius * Math.sin(q * t) * 0.5];
  };
  const cross = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
  const unit = (a) => a.map((x) => x / Math.hypot(...a));
  for (let i = 0, k = 0; i < along; i++) {
    const t = (2 * Math.PI * i) / along;
    const [at, next] = [centre(t), centre(t + 0.01)];
    const forward = next.map((x, j) => x - at[j]);
    const up = unit(cross(forward, next.map((x, j) => x + at[j])));
    const side = unit(cross(up, forward));
    for (let j = 0; j < around; j++) {
      const angle = (2 * Math.PI * j) / around;
      for (let c = 0; c < 3; c++) positions[k++] = at[c] + tube * (Math.cos(angle) * side[c] + Math.sin(angle) * up[c]);
    }
  }
  return { positions, triangles: grid(along, around, true) };
}

/** The sheet at some time: two trains of waves, so steep that the crests overturn and meet. */
export function cloth(time, out, n) {
  for (let i = 0, k = 0; i < n; i++) {
    for (let j = 0; j < n; j++) {
      const [u, v] = [(2 * i) / (n - 1) - 1, (2 * j) / (n - 1) - 1];
      const [first, second] = [7 * u + 2 * v + time, 3 * v - 5 * u - 0.7 * time];
      const steep = 0.19 + 0.07 * Math.sin(0.4 * time);
      out[k++] = 1.5 * (u - steep * Math.sin(first) + 0.09 * Math.sin(second));
      out[k++] = 1.5 * (steep * Math.cos(first) + 0.09 * Math.cos(second));
      out[k++] = 1.5 * (v - 0.25 * steep * Math.sin(first) - 0.06 * Math.sin(second));
    }
  }
  return out;
}

/** The triangles of a grid of vertices, which is closed in both directions or in none. */
export function grid(rows, columns, closed) {
  const [n, m] = closed ? [rows, columns] : [rows - 1, columns - 1];
  const triangles = new Uint32Array(6 * n * m);
  const vertex = (i, j) => (i % rows) * columns + (j % columns);
  for (let i = 0, k = 0; i < n; i++) {
    for (let j = 0; j < m; j++, k += 6) {
      const [a, b, c, d] = [vertex(i, j), vertex(i + 1, j), vertex(i, j + 1), vertex(i + 1, j + 1)];
      triangles.set([a, b, c, c, b, d], k);
    }
  }
  return triangles;
}
