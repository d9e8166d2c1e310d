import { Mesh, PairQuery, SelfQuery, SceneQuery } from "./cpu.js";
export { Mesh, PairQuery, SelfQuery, SceneQuery };
export type { Contacts, Gap } from "./cpu.js";

/** Loads and compiles the module, once, before anything else is called. */
export function init(): Promise<unknown>;

/** A mesh as a file has it. */
export interface MeshFile<P = Float32Array> {
  positions: P;
  triangles: Uint32Array;
  /** Names of bodies, no two the same, with the triangles of each. */
  bodies: { name: string; triangles: Uint32Array }[];
  /** Lines about what was passed over or rounded. */
  notes: string[];
}
/** The triangles of a file: OBJ, STL, PLY, OFF, GLB, 3MF or `.pfb`. How it begins tells the format, or else `format` does. Coordinates are
 * rounded to f32 if they are not wanted in f64. Throws a `FileError` that names the line or the byte. */
export function readFile(bytes: Uint8Array | ArrayBuffer, options?: { format?: string; f64?: false }): Promise<MeshFile>;
export function readFile(bytes: Uint8Array | ArrayBuffer, options: { format?: string; f64: true }): Promise<MeshFile<Float64Array>>;

/** What an object in a Worker has in place of its methods and properties. */
export type Remote<T> = {
  [K in keyof T]: T[K] extends (...args: infer A) => infer R
    ? (...args: { [I in keyof A]: A[I] extends Mesh ? Remote<Mesh> : A[I] }) => Promise<R>
    : () => Promise<T[K]>;
};
/** A Worker with meshes and queries. */
export interface PfrontWorker {
  make(name: "Mesh", ...args: ConstructorParameters<typeof Mesh>): Promise<Remote<Mesh>>;
  make(name: "Mesh.fromBlob", bytes: Uint8Array): Promise<Remote<Mesh>>;
  make(name: "readFile", bytes: Uint8Array, options?: { format?: string; f64?: boolean }): Promise<MeshFile>;
  make(name: "PairQuery"): Promise<Remote<PairQuery>>;
  make(name: "SelfQuery", skipNeighbours?: boolean): Promise<Remote<SelfQuery>>;
  make(name: "SceneQuery"): Promise<Remote<SceneQuery>>;
  /** The milliseconds that the last answer took there. */
  ms: number;
  /** Ends the Worker; questions under way are refused. */
  close(): void;
}
/** Starts a Worker that makes meshes and queries, and answers them. */
export function openWorker(worker?: Worker): Promise<PfrontWorker>;

/** Asks an asynchronous function one question at a time. Of those that come meanwhile the latest waits. */
export class Latest<A extends unknown[], R> {
  constructor(ask: (...question: A) => Promise<R>);
  /** The answer, or `undefined` if a later question took its place before it was asked. */
  ask(...question: A): Promise<R | undefined>;
}

/** What all errors of this package are. */
export class PfrontError extends Error {}
/** No mesh. */
export class MeshError extends PfrontError { vertex?: number; triangle?: number }
/** A pose that is not finite, not affine, or goes too far. */
export class PoseError extends PfrontError { row?: number; column?: number }
/** A distance that is NaN, infinite or negative. */
export class DistanceError extends PfrontError {}
/** A mesh that is no solid: a triangle has an open edge, or triangles `a` and `b` meet. */
export class NotSolid extends PfrontError { mesh?: string; triangle?: number; edge?: number; a?: number; b?: number }
/** A body that is not in the scene. */
export class StaleBody extends PfrontError { body: number }
/** Bytes that are no `.pfb`. */
export class BlobError extends PfrontError {}
/** Bytes that are no mesh file. */
export class FileError extends PfrontError {}
/** There is no GPU, or it could not answer. */
export class GpuError extends PfrontError {}
/** So many bytes are not to be had; all is as it was. */
export class MemoryError extends PfrontError { needed: number }
