export { Gpu, Mesh, PairQuery, SelfQuery } from "./webgpu.js";
export { init, readFile, Latest, PfrontError, MeshError, PoseError, FileError, GpuError, MemoryError } from "./index.js";
export type { MeshFile } from "./index.js";
