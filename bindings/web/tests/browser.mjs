// Opens Chromium: the example of a fresh project; recorded pairs on the page's thread and in a Worker; the page, a drag, pixels, modes,
// files that are opened. Arguments: the project, the folder of the data, if there is one, and one for a screenshot.
import assert from "node:assert/strict";
import { chromium } from "playwright-core";
import { serve } from "./serve.mjs";

const [fresh, data, pictures] = process.argv.slice(2);
const { server, url } = await serve({ "": "site", tests: "tests", fresh, data: data || "tests" });
const args = ["--no-sandbox", "--use-angle=swiftshader", "--enable-unsafe-swiftshader"];
// WebGPU without a GPU.
args.push("--enable-unsafe-webgpu", "--use-webgpu-adapter=swiftshader");
const browser = await chromium.launch({ executablePath: process.env.CHROMIUM ?? "/usr/bin/chromium", args });
const page = await browser.newPage({ viewport: { width: 1200, height: 640 } });
await page.goto(`${url}/tests/blank.html`);
const said = [];
page.on("console", (message) => said.push(message.text()));
await page.evaluate(() => import("/fresh/pairs.mjs"));
assert.deepEqual(said, [1, 1, 1, 0].map((pairs, frame) => `frame ${frame}: ${pairs} pairs`));
console.log("the example in a browser:", said.join("; "));

const faults = [];
page.on("pageerror", (fault) => faults.push(fault.message));
page.on("request", (request) => request.url().startsWith(url) || /^(blob|data):/.test(request.url()) || faults.push(request.url()));

const told = (of, counts) => {
  const all = Object.values(counts).reduce((sum, count) => sum + count, 0);
  console.log(`${of}: the recorded ${all} pairs of ${Object.keys(counts).length} cases`);
};
if (data) {
  for (const of of ["all", "small", "worker"]) {
    const counts = await page.evaluate(async (of) => (await import("/tests/cases.js")).check(of), of);
    told(of, counts);
  }
  const least = { budget: 65536, most: 2000 };
  told("gpu", await page.evaluate(async () => (await import("/tests/cases.js")).checkGpu()));
  told("gpu, least budget", await page.evaluate(async (least) => (await import("/tests/cases.js")).checkGpu(least), least));
  const counts = await page.evaluate(
    (question) =>
      new Promise((resolve, reject) => {
        const worker = new Worker("/tests/worker.js", { type: "module" });
        worker.onmessage = ({ data: { counts, fault } }) => (fault ? reject(new Error(fault)) : resolve(counts));
        worker.onerror = ({ message }) => reject(new Error(message));
        worker.postMessage(question);
      }),
    { most: 500 },
  );
  told("gpu, in a Worker", counts);
}

page.on("console", (message) => message.type() === "error" && faults.push(message.text()));
await page.goto(url);
await page.waitForFunction(() => window.page?.ready, { timeout: 120_000 });
/** What the page shows when nothing is under way: its words, its answer, and how many pixels are red and yellow. */
async function look() {
  await page.waitForFunction(() => (window.page.state.answers === window.seen ? true : ((window.seen = window.page.state.answers), false)), null, { polling: 400 });
  return page.evaluate(() => ({
    ...window.page.probe(),
    word: document.getElementById("word").textContent,
    measure: document.getElementById("measure").textContent,
    notes: document.getElementById("notes").textContent,
    pairs: window.page.state.answer.contacts.pairs.length / 2,
  }));
}
async function drag(x, y) {
  await page.mouse.move(900, 190);
  await page.mouse.down();
  for (let i = 1; i <= 10; i++) await page.mouse.move(900 + (x * i) / 10, 190 + (y * i) / 10);
  await page.mouse.up();
}
const crossing = await look();
console.log("two knots:", JSON.stringify(crossing));
assert.equal(crossing.word, "crossing");
assert.match(crossing.measure, /^overlap 0\.58/);
assert.equal(crossing.pairs, 5576);
assert.ok(crossing.red > 100 && crossing.yellow > 300);
await page.waitForFunction(() => window.page.state.beside, { timeout: 60_000 });
assert.equal(await page.evaluate(() => window.page.state.beside.missed), 0);
if (pictures) await page.screenshot({ path: `${pictures}/page.png` });

// The GPU answers from now on as well.
const sameOnGpu = () => page.waitForFunction(() => window.page.state.same === window.page.state.answer, null, { timeout: 120_000 });
await page.click("#gpu");
await sameOnGpu();

await drag(60, 20);
const moved = await look();
console.log("dragged:", JSON.stringify(moved));
assert.ok(moved.word === "crossing" && moved.pairs > 0 && moved.pairs !== crossing.pairs);
await page.evaluate(() => (window.page.state.bodies[1].object.position.set(9, 0, 0), window.page.ask()));
const apart = await look();
assert.deepEqual([apart.word, apart.pairs, apart.red, apart.yellow], ["apart", 0, 0, 0]);
assert.match(apart.measure, /^gap \d/);
await sameOnGpu();

for (const mode of ["self", "cloth"]) {
  await page.click(`[data-mode=${mode}]`);
  await page.waitForFunction((mode) => window.page.state.mode === mode && window.page.state.answer.at === window.page.state.asked, mode);
  // The cloth moves: what is seen of it depends on when it is looked at.
  const isSeen = () => {
    const { red, yellow } = window.page.probe();
    return window.page.state.answer.contacts.pairs.length > 200 && red > 100 && yellow > 100;
  };
  await page.waitForTimeout(500);
  await page.waitForFunction(isSeen, null, { polling: 200, timeout: 60_000 });
  const { pairs, work } = await page.evaluate(() => ({ pairs: window.page.state.answer.contacts.pairs.length / 2, work: window.page.state.work.slice(-20).sort((a, b) => a - b) }));
  console.log(`${mode}: ${pairs} pairs, a frame ${work[work.length >> 1].toFixed(1)} ms`);
}

// Two tetrahedra that touch, one of them turned inside out, are opened; and a file that is none.
const obj = (x) => `v ${x} 0 0\nv ${x + 1} 0 0\nv ${x} 1 0\nv ${x} 0 1\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n`;
const files = [obj(0), obj(1)].map((text, i) => ({ name: `${i}.obj`, mimeType: "", buffer: Buffer.from(text) }));
await page.setInputFiles("#files", files);
await page.waitForFunction(() => window.page.state.mode === "pair" && window.page.state.bodies[1]?.count === 4);
assert.equal((await look()).word, "touching");
await page.setInputFiles("#files", { name: "x.stl", mimeType: "", buffer: Buffer.from("no mesh") });
await page.waitForFunction(() => /bytes/.test(document.getElementById("notes").textContent));

assert.deepEqual(faults, []);
await browser.close();
server.close();
