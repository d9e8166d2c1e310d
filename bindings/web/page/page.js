// The page: two meshes, one of which is dragged; a mesh with itself; a cloth. All questions are answered in a Worker.

import * as THREE from "three";
import { OrbitControls } from "three/addons/controls/OrbitControls.js";
import { Latest, openWorker } from "pfront";
import { bvhOf, cast, compare, geometryOf, posed } from "./beside.js";
import { Body, Curve } from "./body.js";
import { cloth, grid, knot } from "./shapes.js";

const $ = (id) => document.getElementById(id);
const COLOURS = ["#8ea4bd", "#d3bd9a"];
const SHEET = 120;
/** Above so many triangles three-mesh-bvh is asked when one clicks. */
const MANY = 400_000;
const WORDS = { a_in_b: "enclosing", b_in_a: "inside" };
const HOW = {
  pair: "Drag the sand-coloured mesh, with Shift to turn it.",
  self: "A mesh that intersects itself.",
  cloth: "A sheet that moves and intersects itself in every frame.",
};

const renderer = new THREE.WebGLRenderer({ canvas: $("canvas"), antialias: true, alpha: true });
const scene = new THREE.Scene();
const camera = new THREE.PerspectiveCamera(32, 1, 0.01, 1000);
const controls = new OrbitControls(camera, renderer.domElement);
const key = new THREE.DirectionalLight("#fff4e6", 2.8);
camera.add(key, new THREE.HemisphereLight("#dfe8f5", "#2c2722", 1.1));
key.position.set(-2, 3, 2);
const curve = new Curve();
scene.add(camera, curve.lines, curve.hidden);

const worker = await openWorker();
const queries = { pair: await worker.make("PairQuery"), self: await worker.make("SelfQuery") };
/** What is on the page, and what is known of it; tests read it. */
const state = { mode: "pair", asked: 0, work: [], bodies: [] };
let [dropped, dirty, idle, areSolid, haveVolume] = [undefined, true, 0, true, true];

/** Shows meshes in place of those that there are. */
async function show(mode) {
  state.asked++;
  state.mode = mode;
  for (const body of state.bodies.splice(0)) body.dispose(scene);
  curve.set([]);
  [areSolid, haveVolume] = [true, true];
  for (const button of document.querySelectorAll("nav button")) button.setAttribute("aria-pressed", button.dataset.mode === mode);
  $("how").textContent = HOW[mode];
  for (const row of [$("other"), $("beside")]) row.hidden = mode !== "pair";
  for (const row of [$("ongpu"), $("gpu")]) row.hidden = mode === "cloth";
  const meshes = meshesFor(mode);
  for (const [i, { positions, triangles }] of meshes.entries()) {
    const body = new Body(geometryOf(positions, triangles), COLOURS[(i + (mode === "cloth")) % 2]);
    state.bodies.push(body);
    scene.add(body.object);
    // The same mesh twice is one in the Worker.
    body.mesh = i && meshes[0].positions === positions ? state.bodies[0].mesh : worker.make("Mesh", positions, triangles);
  }
  const moved = state.bodies[1];
  if (moved && meshes[1].by) moved.object.position.fromArray(meshes[1].by);
  $("triangles").textContent = state.bodies.reduce((sum, body) => sum + body.count, 0).toLocaleString("en");
  look();
  await Promise.all(state.bodies.map(async (body) => (body.mesh = await body.mesh)));
  if (mode === "cloth") return;
  await ask();
  // Compiled by now.
  await queries[mode].forget();
  await ask();
}

function meshesFor(mode) {
  if (mode === "cloth") return [{ positions: cloth(0, new Float32Array(3 * SHEET * SHEET), SHEET), triangles: grid(SHEET, SHEET, false) }];
  if (mode === "self") return dropped?.slice(0, 1) ?? [knot({ p: 2, q: 5, tube: 0.43 })];
  if (!dropped) return [knot({ p: 2, q: 3, tube: 0.3 }), { ...knot({ p: 3, q: 2, tube: 0.22 }), by: [0.9, 0.25, 0.3] }];
  if (dropped.length > 1) return dropped;
  // One mesh, against itself beside it.
  const size = new THREE.Box3().setFromArray(dropped[0].positions).getSize(new THREE.Vector3());
  return [dropped[0], { ...dropped[0], by: [0.37 * size.x, 0.04 * size.y, 0.21 * size.z] }];
}

/** Turns the camera to all that there is. */
function look() {
  const box = state.bodies.reduce((box, body) => box.expandByObject(body.object), new THREE.Box3());
  const { center, radius } = box.getBoundingSphere(new THREE.Sphere());
  const distance = (0.9 * radius) / Math.sin((camera.fov * Math.PI) / 360);
  camera.position.copy(center).add(new THREE.Vector3(0.35, 0.3, 1).setLength(distance));
  [camera.near, camera.far] = [distance / 100, 10 * distance];
  camera.updateProjectionMatrix();
  controls.target.copy(center);
  controls.update();
}

const matrixOf = ([a, b]) => {
  b.object.updateMatrixWorld();
  return a.object.matrixWorld.clone().invert().multiply(b.object.matrixWorld).elements.map(Math.fround);
};

/** Pairs, curve and time of two meshes; then the relation, and how far apart they are or what they have in common. */
const askPair = new Latest(async (at) => {
  const [[a, b], matrix] = [state.bodies, matrixOf(state.bodies)];
  const [query, given] = [queries.pair, [a.mesh, b.mesh, matrix]];
  const timed = query.contacts(...given).then((contacts) => ({ at, matrix, contacts, ms: worker.ms }));
  const word = areSolid ? query.relation(...given).catch(notSolid) : undefined;
  const answer = await timed;
  answer.word = (await word) ?? (answer.contacts.pairs.length ? "intersecting" : "apart");
  if (answer.word === "apart") answer.gap = await query.distance(...given);
  else if (areSolid && haveVolume) answer.volume = await query.overlapVolume(...given).catch(noVolume);
  return answer;
});

const askSelf = new Latest(async (at, positions) => {
  const [{ mesh }] = state.bodies;
  if (positions) await mesh.setPositions(positions);
  const refit = positions ? worker.ms : 0;
  const contacts = await queries.self.contacts(mesh);
  return { at, positions, contacts, ms: worker.ms, refit, word: contacts.pairs.length ? "intersecting" : "clear" };
});

/** A mesh that is open has no inside: the page goes on with its surface. */
function notSolid(fault) {
  if (fault.name !== "NotSolid") throw fault;
  areSolid = false;
  note(`No solid, so that nothing is inside: ${fault.message}.`);
}
function noVolume(fault) {
  if (fault.name !== "NotSolid") throw fault;
  haveVolume = false;
  note(`No volume: ${fault.message}.`);
}

async function ask(positions) {
  clearTimeout(idle);
  try {
    const answer = await (state.mode === "pair" ? askPair : askSelf).ask(state.asked, positions);
    if (!answer || answer.at !== state.asked) return;
    draw(answer);
    compareGpu(answer).catch((fault) => note(fault.message));
    if (state.mode === "pair") idle = setTimeout(beside, 600);
  } catch (fault) {
    note(fault.message);
  }
}

/** Puts an answer on the page. */
function draw(answer) {
  const start = performance.now();
  const { pairs, segments } = answer.contacts;
  const [a, b] = state.bodies;
  if (answer.positions) a.move(answer.positions);
  a.mark(pairs, b ? 0 : undefined);
  b?.mark(pairs, 1);
  curve.set(segments);
  const number = (x) => x.toLocaleString("en", { maximumSignificantDigits: 4 });
  $("word").textContent = WORDS[answer.word] ?? answer.word;
  $("measure").textContent = answer.gap
    ? `gap ${number(answer.gap.interval[1])}`
    : answer.volume
      ? `overlap ${number(answer.volume[1])}`
      : "";
  $("pairs").textContent = (pairs.length / 2).toLocaleString("en");
  $("time").textContent = `${answer.ms.toFixed(2)} ms${answer.refit ? `, refit ${answer.refit.toFixed(1)} ms` : ""}`;
  $("backend").textContent = "CPU, wasm, in a Worker";
  Object.assign(state, { answer, answers: (state.answers ?? 0) + 1, update: performance.now() - start });
  dirty = true;
}

/** Has the GPU answer as well from now on, and compares. */
async function onGpu() {
  const row = $("gpu");
  try {
    Object.assign(row, { textContent: "…", className: "" });
    ({ gpuPairs: state.gpu } = await import("./gpu.js"));
    await compareGpu(state.answer);
  } catch (fault) {
    row.textContent = "none";
    note(fault.message);
  }
}
async function compareGpu(answer) {
  const { at, matrix, contacts } = answer;
  // Meshes of the GPU stay as they were uploaded.
  if (!state.gpu || state.mode === "cloth") return;
  const found = await state.gpu.ask(state.bodies, matrix);
  if (!found || at !== state.asked) return;
  const same = found.pairs.length === contacts.pairs.length && found.pairs.every((x, i) => x === contacts.pairs[i]);
  $("gpu").textContent = `${found.ms.toFixed(1)} ms, ${same ? "same pairs ✓" : "other pairs"}`;
  $("gpu").className = same ? "" : "wrong";
  if (same) state.same = answer;
}

/** Asks three-mesh-bvh the same, when nothing else is to be done. Its misses are counted on positions posed as ours are. */
function beside(anyway) {
  const [a, b] = state.bodies;
  const [row, { matrix, contacts }] = [$("beside"), state.answer];
  row.className = "";
  if (!anyway && a.count + b.count > MANY) {
    Object.assign(row, { textContent: "ask it", className: "ask" });
    return;
  }
  a.bvh ??= bvhOf(a.geometry);
  b.bvh ??= b.geometry === a.geometry ? a.bvh : bvhOf(b.geometry);
  // It is compiled while it runs, too: the best of some.
  const times = Array.from({ length: 5 }, () => cast(a.bvh, b.bvh, new THREE.Matrix4().fromArray(matrix)).ms);
  const ms = Math.min(...times);
  const there = bvhOf(geometryOf(posed(b.geometry.attributes.position.array, matrix), b.geometry.index.array));
  const { missed, invented } = compare(contacts.pairs, cast(a.bvh, there).pairs);
  row.textContent = `${ms.toFixed(1)} ms, ${missed} missed${invented ? `, ${invented} wrong` : ""}`;
  row.className = missed + invented ? "wrong" : "";
  state.beside = { ms, missed, invented };
}

function note(text) {
  $("notes").textContent = text;
}

// Files, dropped or chosen.
async function open(list) {
  try {
    note("");
    const read = await Promise.all([...list].slice(0, 2).map(async (file) => {
      const format = file.name.split(".").pop().toLowerCase();
      return worker.make("readFile", new Uint8Array(await file.arrayBuffer()), { format });
    }));
    note(read.flatMap((file) => file.notes).join("; "));
    dropped = read;
    await show(state.mode === "self" && read.length === 1 ? "self" : "pair");
  } catch (fault) {
    note(fault.message);
  }
}
addEventListener("dragover", (event) => (event.preventDefault(), document.body.classList.add("drop")));
addEventListener("dragleave", (event) => event.relatedTarget ?? document.body.classList.remove("drop"));
addEventListener("drop", (event) => {
  event.preventDefault();
  document.body.classList.remove("drop");
  open(event.dataTransfer.files);
});
$("files").onchange = ({ target }) => open(target.files);
$("gpu").onclick = () => state.gpu || onGpu();
$("beside").onclick = () => state.mode === "pair" && beside(true);
document.querySelector("nav").onclick = ({ target }) => target.dataset.mode && (note(""), show(target.dataset.mode));

// The second mesh is dragged in the plane of the screen, or turned.
const ray = new THREE.Raycaster();
let grip;
function aim({ clientX, clientY }) {
  ray.setFromCamera(new THREE.Vector2((2 * clientX) / innerWidth - 1, 1 - (2 * clientY) / innerHeight), camera);
  return ray;
}
renderer.domElement.addEventListener("pointerdown", (event) => {
  const [a, b] = state.bodies;
  const hit = b && event.button === 0 && aim(event).intersectObjects([a.object, b.object], false)[0];
  if (!hit || hit.object !== b.object) return;
  const plane = new THREE.Plane().setFromNormalAndCoplanarPoint(camera.getWorldDirection(new THREE.Vector3()), hit.point);
  grip = { plane, last: hit.point, x: event.clientX, y: event.clientY };
  controls.enabled = false;
  renderer.domElement.setPointerCapture(event.pointerId);
}, { capture: true });
renderer.domElement.addEventListener("pointermove", (event) => {
  if (!grip) return;
  const { object } = state.bodies[1];
  if (event.shiftKey) {
    const turn = new THREE.Euler((event.clientY - grip.y) / 150, (event.clientX - grip.x) / 150, 0);
    const view = camera.quaternion;
    object.quaternion.premultiply(view.clone().multiply(new THREE.Quaternion().setFromEuler(turn)).multiply(view.clone().invert()));
  }
  const point = aim(event).ray.intersectPlane(grip.plane, new THREE.Vector3());
  if (point && !event.shiftKey) object.position.add(point).sub(grip.last);
  Object.assign(grip, { last: point ?? grip.last, x: event.clientX, y: event.clientY });
  ask();
});
addEventListener("pointerup", () => ([grip, controls.enabled] = [undefined, true]));
controls.addEventListener("change", () => (dirty = true));
addEventListener("resize", resize);

function resize() {
  renderer.setPixelRatio(Math.min(devicePixelRatio, 2));
  renderer.setSize(innerWidth, innerHeight, false);
  camera.aspect = innerWidth / innerHeight;
  // The panel is on the left.
  const shift = innerWidth > 900 ? 150 : 0;
  camera.setViewOffset(innerWidth, innerHeight, -shift, 0, innerWidth, innerHeight);
  curve.resize(innerWidth, innerHeight);
  dirty = true;
}

function frame(now) {
  requestAnimationFrame(frame);
  if (state.mode === "cloth" && state.bodies[0].mesh.setPositions && !state.pending) {
    state.pending = true;
    const positions = cloth(now / 900, new Float32Array(3 * SHEET * SHEET), SHEET);
    ask(positions).finally(() => (state.pending = false));
  }
  if (!dirty) return;
  dirty = false;
  const start = performance.now();
  renderer.render(scene, camera);
  state.work.push(performance.now() - start + (state.update ?? 0));
  state.work.splice(0, state.work.length - 200);
}

/** Counts the pixels that are red and yellow. */
function probe() {
  const gl = renderer.getContext();
  renderer.render(scene, camera);
  const [w, h] = [gl.drawingBufferWidth, gl.drawingBufferHeight];
  const pixels = new Uint8Array(4 * w * h);
  gl.readPixels(0, 0, w, h, gl.RGBA, gl.UNSIGNED_BYTE, pixels);
  let [red, yellow] = [0, 0];
  for (let i = 0; i < pixels.length; i += 4) {
    const [r, g, b] = [pixels[i], pixels[i + 1], pixels[i + 2]];
    red += r > 200 && g < 110 && b < 110;
    yellow += r > 220 && g > 180 && b < 120;
  }
  return { red, yellow };
}

resize();
requestAnimationFrame(frame);
window.page = { state, probe, ask, look };
await show("pair");
window.page.ready = true;
