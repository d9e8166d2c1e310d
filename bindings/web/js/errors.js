// Errors that name what is at fault by its number.

/** What all errors of this package are. */
export class PfrontError extends Error {}
/** No mesh: `vertex` or `triangle`. */
export class MeshError extends PfrontError {}
/** A pose that is not finite, not affine, or goes too far: `row`, `column`. */
export class PoseError extends PfrontError {}
/** A distance that is NaN, infinite or negative. */
export class DistanceError extends PfrontError {}
/** A mesh, `mesh`, that is no solid: the `triangle` with its open `edge`, or triangles `a` and `b` that meet. */
export class NotSolid extends PfrontError {}
/** A `body` that is not in the scene. */
export class StaleBody extends PfrontError {}
/** Bytes that are no `.pfb`. */
export class BlobError extends PfrontError {}
/** Bytes that are no mesh file. */
export class FileError extends PfrontError {}
/** There is no GPU, or it could not answer. */
export class GpuError extends PfrontError {}
/** `needed` bytes that are not to be had; all is as it was. */
export class MemoryError extends PfrontError {}

const classes = { PfrontError, MeshError, PoseError, DistanceError, NotSolid, StaleBody, BlobError, FileError, GpuError, MemoryError };
for (const [name, { prototype }] of Object.entries(classes)) prototype.name = name;

/** An error of the class of this name; numbers of what is at fault, if there are any, become properties by their keys. */
export function error(name, message, keys, values) {
  const made = new classes[name](message);
  if (keys) keys.split(" ").forEach((key, i) => (made[key] = values[i]));
  return made;
}

/** What becomes of an error that goes to another thread, and back. */
export const toPlain = (thrown) => ({ ...thrown, name: thrown?.name, message: thrown?.message ?? String(thrown) });
export function fromPlain({ name, message, ...place }) {
  const made = name in classes ? error(name, message) : new ({ TypeError, RangeError }[name] ?? Error)(message);
  return Object.assign(made, place);
}
