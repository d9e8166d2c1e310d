// A Worker that asks a GPU every case.
import { checkGpu } from "./cases.js";

onmessage = async ({ data }) => {
  try {
    postMessage({ counts: await checkGpu(data) });
  } catch (fault) {
    postMessage({ fault: String(fault) });
  }
};
