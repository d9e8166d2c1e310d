export { Mesh, PairQuery, SelfQuery } from "./cpu-small.js";
export type { Contacts } from "./cpu-small.js";
export { init, readFile, Latest, PfrontError, MeshError, PoseError, BlobError, FileError, MemoryError } from "./index.js";
export type { MeshFile } from "./index.js";
