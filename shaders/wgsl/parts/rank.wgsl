// Some hits in workgroup memory.

const RANKED = max(BUCKET, BUCKETS);

// No hit is there twice.
var<workgroup> ranked: array<vec2u, RANKED>;
