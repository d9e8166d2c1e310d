// Recorded cases in one page of Chromium, asked by pfront and by three-mesh-bvh: a table of milliseconds, the best of many, and of pairs missed.
// Argument: the folder of the data. The site is built before: ./build-site.
import { chromium } from "playwright-core";
import { serve } from "../tests/serve.mjs";

const { server, url } = await serve({ "": "site", tests: "tests", data: process.argv[2] });
const browser = await chromium.launch({ executablePath: process.env.CHROMIUM ?? "/usr/bin/chromium", args: ["--no-sandbox", "--use-angle=swiftshader", "--enable-unsafe-swiftshader"] });
const page = await browser.newPage();
page.on("console", (message) => console.log(message.text()));
await page.goto(`${url}/tests/blank.html`);
await page.evaluate(async () => {
  const { init, Mesh, PairQuery } = await import("/pfront/index.js");
  const small = await import("/pfront/small.js");
  const { cases, load } = await import("/tests/cases.js");
  const { bvhOf, cast, compare, geometryOf, posed } = await import("/beside.js");
  await Promise.all([init(), small.init()]);
  const timed = (times, act) => {
    const all = Array.from({ length: times }, () => {
      const start = performance.now();
      act();
      return performance.now() - start;
    });
    return Math.min(...all);
  };
  const ms = (x) => (x < 10 ? x.toFixed(2) : x.toFixed(0));
  console.log("| case | pairs | `all` | `contacts` | `all`, small | build | bvhcast, leaves of 10 | of 4 | build | missed | wrong |");
  console.log("|---|---|---|---|---|---|---|---|---|---|---|");
  for (const one of await cases()) {
    const { meshes, matrix, truth } = await load(one);
    if (matrix) meshes[1].positions = posed(meshes[1].positions, matrix);
    const times = truth.length > 20_000 ? 5 : 15;
    const build = timed(3, () => new Mesh(meshes[0].positions, meshes[0].triangles).free());
    const [a, b] = meshes.map((mesh) => new Mesh(mesh.positions, mesh.triangles));
    const query = new PairQuery();
    const ask = (verb) => timed(2 * times, () => (query.forget(), query[verb](a, b)));
    const own = [ask("all"), ask("contacts")];
    const twins = meshes.map((mesh) => new small.Mesh(mesh.positions, mesh.triangles));
    const few = new small.PairQuery();
    own.push(timed(2 * times, () => few.all(...twins)));
    const geometries = meshes.map((mesh) => geometryOf(mesh.positions, mesh.triangles));
    const others = [10, 4].map((leaf) => {
      const start = performance.now();
      const [s, t] = geometries.map((geometry) => bvhOf(geometry, leaf));
      const built = (performance.now() - start) / 2;
      const all = Array.from({ length: times }, () => cast(s, t)).sort((x, y) => x.ms - y.ms);
      return { built, ms: all[0].ms, ...compare(truth, all[0].pairs) };
    });
    const row = [truth.length / 2, ...own.map(ms), ms(build), ms(others[0].ms), ms(others[1].ms), ms(others[0].built), others[0].missed, others[0].invented];
    console.log(`| ${one.name} | ${row.join(" | ")} |`);
    for (const mesh of [a, b, ...twins]) mesh.free();
  }
});

// The page, with two bunnies of which one is dragged: what its thread does for a frame, without the software that draws it.
await page.goto(url);
await page.waitForFunction(() => window.page?.ready);
await page.setInputFiles("#files", `${process.argv[2]}/classic/bunny_closed_69666.obj`);
await page.waitForFunction(() => window.page.state.bodies[1]?.count === 69_666 && window.page.state.answer.at === window.page.state.asked);
const frames = await page.evaluate(async () => {
  const { state, ask } = window.page;
  const updates = [];
  for (let i = 0; i < 120; i++) {
    state.bodies[1].object.position.x -= 1e-4;
    await ask();
    updates.push([state.update, state.answer.ms]);
    await new Promise(requestAnimationFrame);
  }
  const median = (list) => list.sort((a, b) => a - b)[list.length >> 1].toFixed(2);
  return `update ${median(updates.map(([update]) => update))} ms, with render ${median(state.work.slice(-120))} ms, contacts in the Worker ${median(updates.map(([, ms]) => ms))} ms`;
});
console.log("two bunnies, medians of 120 frames:", frames);
console.log(`${browser.version()}, Chromium, headless`);
await browser.close();
server.close();
