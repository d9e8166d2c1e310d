//! Two closed surfaces of 1,000 triangles, computed by the compiler, so that they are the same to the bit
//! on every machine: for the firmware, and for the build script that bakes one of them.

/// Around and across a ring.
const AROUND: usize = 25;
const ACROSS: usize = 20;
pub(crate) const VERTICES: usize = AROUND * ACROSS;
pub(crate) const TRIANGLES: usize = 2 * VERTICES;

/// The positions of a torus whose tube swells and shrinks by `bump`, five times around.
pub(crate) const fn ring(bump: f32) -> [[f32; 3]; VERTICES] {
    let mut positions = [[0.0; 3]; VERTICES];
    let mut at = 0;
    while at < VERTICES {
        let [x, y] = on_circle(at / ACROSS, AROUND);
        let [across, up] = on_circle(at % ACROSS, ACROSS);
        let tube = 0.4 + bump * on_circle(5 * (at / ACROSS) % AROUND, AROUND)[0];
        let out = 1.0 + tube * across;
        positions[at] = [x * out, y * out, tube * up];
        at += 1;
    }
    positions
}

/// The triangles of either.
pub(crate) const fn grid() -> [[u32; 3]; TRIANGLES] {
    let mut triangles = [[0; 3]; TRIANGLES];
    let mut at = 0;
    while at < VERTICES {
        let (i, j) = (at / ACROSS, at % ACROSS);
        let (next_i, next_j) = ((i + 1) % AROUND, (j + 1) % ACROSS);
        let [p, q] = [at as u32, (i * ACROSS + next_j) as u32];
        let [r, s] = [(next_i * ACROSS + j) as u32, (next_i * ACROSS + next_j) as u32];
        triangles[2 * at] = [p, r, s];
        triangles[2 * at + 1] = [p, s, q];
        at += 1;
    }
    triangles
}

/// The point a share of the way around the unit circle, in four rational arcs.
pub(crate) const fn on_circle(step: usize, of: usize) -> [f32; 2] {
    let (quarter, t) = (4 * step / of, (4 * step % of) as f32 / of as f32);
    let (x, y) = ((1.0 - t * t) / (1.0 + t * t), 2.0 * t / (1.0 + t * t));
    match quarter {
        0 => [x, y],
        1 => [-y, x],
        2 => [-x, -y],
        _ => [y, -x],
    }
}
