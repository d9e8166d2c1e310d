// Conclusions from signs, whichever arithmetic decided them.

const MISS = 0u;
const HIT = 1u;
const UNSURE = 2u;

// All three strictly on one side.
fn one_sided(sides: vec3i) -> bool {
    return sides.x != 0 && sides.x == sides.y && sides.x == sides.z;
}
