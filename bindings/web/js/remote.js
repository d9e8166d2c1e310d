// Meshes and queries in a Worker: the same methods, each of which returns a promise.

import { fromPlain } from "./errors.js";

const ID = Symbol("id");
const gone = globalThis.FinalizationRegistry && new FinalizationRegistry((free) => free());

/** Starts a Worker that makes meshes and queries, and answers them. */
export async function openWorker(worker = new Worker(new URL("./worker.js", import.meta.url), { type: "module" })) {
  const pending = new Map();
  let next = 0;
  const fail = (fault) => {
    pending.forEach(({ reject }) => reject(fault));
    pending.clear();
  };
  worker.onerror = (event) => fail(new Error(`the worker failed: ${event.message ?? "it did not load"}`));
  worker.onmessage = ({ data: { call, value, made, fault, ms } }) => {
    const { resolve, reject } = pending.get(call) ?? {};
    pending.delete(call);
    self.ms = ms ?? self.ms;
    if (fault) reject?.(fromPlain(fault));
    else resolve?.(made === undefined ? value : remote(made));
  };
  const send = (object, method, args) =>
    new Promise((resolve, reject) => {
      const plain = args.map((arg) => (arg?.[ID] === undefined ? arg : { remote: arg[ID] }));
      worker.postMessage({ call: ++next, object, method, args: plain });
      pending.set(next, { resolve, reject });
    });
  // A promise asks whether what it resolves to has a method `then`.
  const get = (target, method) => (method in target || method === "then" ? target[method] : (...args) => send(target[ID], method, args));
  const remote = (id) => {
    const proxy = new Proxy({ [ID]: id }, { get });
    gone?.register(proxy, () => worker.postMessage({ object: id, method: "free", args: [] }));
    return proxy;
  };
  const self = {
    ms: 0,
    make: (name, ...args) => send(undefined, name, args),
    close() {
      worker.terminate();
      fail(new Error("the worker is closed"));
    },
  };
  await send(undefined, "init", []);
  return self;
}
