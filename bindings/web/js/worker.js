// The Worker behind `openWorker`: keeps objects by number, and calls their methods.

import { init, readFile, Mesh, PairQuery, SelfQuery, SceneQuery, toPlain } from "./index.js";

const objects = new Map();
let made = 0;

const makers = {
  init,
  readFile,
  Mesh: (...args) => new Mesh(...args),
  "Mesh.fromBlob": (bytes) => Mesh.fromBlob(bytes),
  PairQuery: () => new PairQuery(),
  SelfQuery: (skip) => new SelfQuery(skip),
  SceneQuery: () => new SceneQuery(),
};

function act(object, method, args) {
  const given = args.map((arg) => (arg?.remote === undefined ? arg : objects.get(arg.remote)));
  if (object === undefined) return makers[method](...given);
  const target = objects.get(object);
  // A property, or a method.
  const answer = typeof target[method] === "function" ? target[method](...given) : target[method];
  if (method === "free") objects.delete(object);
  return answer;
}

onmessage = async ({ data: { call, object, method, args } }) => {
  const start = performance.now();
  try {
    const value = await act(object, method, args);
    const ms = performance.now() - start;
    if ([Mesh, PairQuery, SelfQuery, SceneQuery].some((of) => value instanceof of)) {
      objects.set(++made, value);
      postMessage({ call, made, ms });
    } else {
      const arrays = ArrayBuffer.isView(value) ? [value] : Object.values(value ?? {}).filter(ArrayBuffer.isView);
      postMessage({ call, value, ms }, { transfer: arrays.map((array) => array.buffer) });
    }
  } catch (fault) {
    postMessage({ call, fault: toPlain(fault) });
  }
};
