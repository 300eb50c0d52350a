// Opens the pages of the program in a browser as a user would: node check.mjs PROGRAM FOLDER HOSTILE.html
// Pages and pictures are left in FOLDER to be looked at.
import { chromium } from "playwright-core";
import { spawnSync } from "node:child_process";
import assert from "node:assert/strict";
import fs from "node:fs";
import path from "node:path";
import { pathToFileURL } from "node:url";
import { faults } from "./faults.mjs";

const [program, folder, third] = process.argv.slice(2).map((p) => path.resolve(p));
const only = process.env.ONLY;
const root = path.resolve(import.meta.dirname, "../../..");
const requirement = "requirements/quadruped_mini_cheetah.toml";
const commands = {
  rank: ["rank", "--mark", "t-motor-ri50"],
  compare: ["compare", "t-motor-ri50", "t-motor-u8"],
  optimize: ["optimize", requirement],
  gears: ["optimize", "requirements/humanoid_hip_catalog_gears.toml"],
  spring: ["optimize", "requirements/ankle_prosthesis_parallel_spring.toml"],
  robot: ["optimize", requirement, "--robot"],
  robust: ["optimize", requirement, "--robust"],
  check: ["check", "requirements/designs/quadruped_mini_cheetah/design.toml"],
  study: ["study", "requirements/studies/quadruped.toml", "--force", "--out", path.join(folder, "study")],
  characterize: ["characterize", "requirements/bench/motor_on_bench.toml"],
  pareto: ["optimize", requirement, "--pareto", "loss,reflected_inertia"],
  sweep: ["sweep", requirement, "--ratios", "6"],
  explain: ["explain", "t-motor-ri50", requirement, "--joint", "knee"],
  audit: ["audit"],
  identify: ["identify", "requirements/bench/leg_actuator.toml"],
};
fs.mkdirSync(folder, { recursive: true });

const hostile = ["<script>alert(1)</script>", "</script><script>alert(2)</script>", '"><img src=x onerror=alert(3)>', "=cmd|' /C calc'!A0", "a\u2028b", "<b>bold</b>"];
const cell = (text) => `"${text.replaceAll('"', '""')}"`;
function hostileCatalogue() {
  const file = path.join(folder, "hostile.csv");
  const head = "id,manufacturer,model,source,source_kind,terminals,current,resistance [ohm],torque_constant [N*m/A],rotor_inertia [g*cm^2],mass [g],peak_current [A],continuous_current [A]";
  const rows = hostile.map((name, k) => [`motor-${k}`, name, name, name, "datasheet", "q_axis", "q_axis", 0.1 + 0.01 * k, 0.1, 300 + 10 * k, 400, 60, 25].map((c) => cell(String(c))).join(","));
  fs.writeFileSync(file, [head, ...rows].join("\n") + "\n");
  return file;
}
// A design that breaks many rules, with paths that are long.
function brokenDesign() {
  const shipped = path.join(root, "requirements/designs/quadruped_mini_cheetah/design.toml"), file = path.join(folder, "broken.toml");
  const text = fs.readFileSync(shipped, "utf8").replaceAll('"../../', `"${root}/requirements/`).replace(/^rules = .*$/m, "").replace("ratio = 9.33", "ratio = 3");
  fs.writeFileSync(file, text);
  return file;
}
commands.broken = ["check", brokenDesign()];
const catalogue = hostileCatalogue();
commands.hostile_rank = ["rank", catalogue];
commands.hostile_compare = ["compare", "motor-0", "motor-1", "--catalog", catalogue];
// Ids of catalogues have letters only; a page of things with hostile ids is left here by tests/program/cli/html.rs.
const hostileIds = third;

function make(name) {
  const file = path.join(folder, `${name}.html`);
  if (process.env.GEARWISE_PAGES_AS_THEY_ARE && fs.existsSync(file)) return file;
  const done = spawnSync(program, [...commands[name], "--html", file], { cwd: root, encoding: "utf8" });
  assert.ok(done.status === 0 || done.status === 1, `${name}: ${done.stderr}`);
  return file;
}

const browser = await chromium.launch({
  executablePath: process.env.CHROMIUM ?? "/usr/bin/chromium",
  args: ["--headless", "--no-sandbox", "--disable-gpu", "--disable-quic", "--no-first-run", "--disable-background-networking", "--disable-component-update", "--disable-sync"],
});
const version = browser.version();
let checks = 0;
const ok = (condition, message) => { checks++; assert.ok(condition, message); };
const equal = (a, b, message) => { checks++; assert.deepEqual(a, b, message); };

// A page that notes all it should not do.
async function open(file, options) {
  const context = await browser.newContext({ viewport: { width: 1280, height: 900 }, ...options });
  const page = await context.newPage();
  // A busy machine takes its time.
  page.setDefaultTimeout(180000);
  const wrong = [];
  page.on("console", (m) => ["error", "warning"].includes(m.type()) && wrong.push(`console: ${m.text()}`));
  page.on("pageerror", (e) => wrong.push(`error: ${e.message}`));
  page.on("dialog", (d) => { wrong.push(`dialog: ${d.message()}`); d.dismiss(); });
  page.on("request", (r) => r.url() !== pathToFileURL(file).href && !r.url().startsWith("data:") && wrong.push(`request: ${r.url()}`));
  await page.goto(pathToFileURL(file).href);
  return { page, wrong, close: () => context.close() };
}
const wait = (page) => page.evaluate(() => new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(done))));

// What finds faults must find them.
async function finds(file) {
  const { page, close } = await open(file, { viewport: { width: 390, height: 844 } });
  await wait(page);
  equal(await faults(page), []);
  const spoilt = {
    "off screen": { width: "600px", maxWidth: "none" },
    cut: { width: "50px", overflow: "hidden", whiteSpace: "nowrap" },
    contrast: { color: "#999999" },
  };
  for (const [fault, style] of Object.entries(spoilt)) {
    await page.evaluate((style) => {
      const p = document.createElement("p");
      p.id = "spoilt";
      p.textContent = "a sentence that stands here to be found by the test";
      document.querySelector("main").prepend(p);
      Object.assign(p.style, style);
    }, style);
    ok((await faults(page)).some((text) => text.includes(fault)), `what is ${fault} is found`);
    await page.evaluate(() => document.getElementById("spoilt").remove());
  }
  await close();
}

// Every page in every look: nothing wrong, nothing cut or off screen, every text readable, every diagram drawn.
async function looks(name, file) {
  const views = {};
  for (const colorScheme of ["light", "dark"]) {
    views[`1440-${colorScheme}`] = { viewport: { width: 1440, height: 900 }, colorScheme };
    views[`800-${colorScheme}`] = { viewport: { width: 800, height: 900 }, colorScheme };
    views[`390-${colorScheme}`] = { viewport: { width: 390, height: 844 }, colorScheme, deviceScaleFactor: 2, isMobile: true, hasTouch: true };
  }
  for (const [view, options] of Object.entries(views)) {
    const { page, wrong, close } = await open(file, options);
    await wait(page);
    const width = await page.evaluate(() => [document.documentElement.scrollWidth, innerWidth]);
    ok(width[0] <= width[1], `${name} ${view}: the page is ${width[0]} px wide, the window ${width[1]}`);
    equal(await faults(page), [], `${name} ${view}`);
    const heads = await page.evaluate(() => [...document.querySelectorAll("h2")].map((h) => h.textContent));
    if (commands[name]) equal(heads.slice(0, 2), ["What was asked", "In short"], name);
    const drawn = await page.evaluate(() => panels.map((v) => [v.panel.series.length, v.marks.length, v.plot.width]));
    for (const [series, marks, size] of drawn) ok(series > 0 && marks > 0 && size > 200, `${name} ${view}: a diagram is empty`);
    const ground = await page.evaluate(() => getComputedStyle(document.body).backgroundColor);
    equal(ground, view.endsWith("dark") ? "rgb(18, 22, 27)" : "rgb(255, 255, 255)", `${name} ${view}: ground`);
    const levels = await page.evaluate(() => [...document.querySelectorAll("h1,h2,h3,h4")].map((h) => Number(h.tagName[1])));
    equal(levels[0], 1);
    ok(levels.every((l, k) => k === 0 || l <= levels[k - 1] + 1), `${name}: a heading's level is left out`);
    await page.screenshot({ path: path.join(folder, `${name}-${view}.png`), fullPage: true, clip: await seen(page, 6000) });
    equal(wrong, [], `${name} ${view}`);
    await close();
  }
}

// A page down to some length: longer ones make pictures that nobody can look at.
const seen = (page, most) => page.evaluate((most) => ({ x: 0, y: 0, width: innerWidth, height: Math.min(most, document.documentElement.scrollHeight) }), most);

async function sortsAndFilters(file) {
  const { page, wrong, close } = await open(file);
  // The hip: enough motors can do it for a field to search in.
  const table = page.locator("#s1 div.table").first();
  const column = (text) => table.evaluate((box, text) => {
    const heads = [...box.querySelectorAll("thead th")], k = heads.findIndex((h) => h.textContent.startsWith(text));
    return [...box.querySelectorAll("tbody tr")].filter((r) => !r.hidden).map((r) => r.cells[k].textContent);
  }, text);
  const sortState = (text) => table.locator("thead th", { hasText: text }).first().getAttribute("aria-sort");
  const before = await column("loss");
  await table.getByRole("button", { name: /^mass/ }).click();
  equal(await sortState("mass"), "ascending");
  const masses = (await column("mass")).map(Number), known = masses.filter((m) => !Number.isNaN(m));
  equal(known, [...known].sort((a, b) => a - b), "masses rise");
  ok(masses.slice(known.length).every(Number.isNaN), "what is unknown stands last");
  await table.getByRole("button", { name: /^mass/ }).click();
  equal(await sortState("mass"), "descending");
  const down = (await column("mass")).map(Number).filter((m) => !Number.isNaN(m));
  equal(down, [...known].sort((a, b) => b - a), "masses fall");
  // By keyboard.
  await table.getByRole("button", { name: /^loss/ }).focus();
  await page.keyboard.press("Enter");
  equal(await sortState("loss"), "ascending");
  equal(await sortState("mass"), "none");
  const losses = (await column("loss")).map(Number);
  equal(losses, before.map(Number).sort((a, b) => a - b), "losses rise, none is lost");
  const limit = losses[Math.floor(losses.length / 2)];
  await table.getByRole("searchbox").fill(`loss<${limit}`);
  equal((await column("loss")).map(Number), losses.filter((l) => l < limit), "a filter by number");
  ok((await table.locator(".count").textContent()).includes(` of ${losses.length} rows`));
  await table.getByRole("searchbox").fill("maxon");
  const motors = await column("motor");
  ok(motors.length > 0 && motors.length < losses.length, "a filter by word leaves some");
  await table.getByRole("searchbox").fill("");
  equal((await column("loss")).length, losses.length);
  equal(wrong, []);
  await close();
}

// A fragment that comes later takes the place of what is alike: sorting, filter, zoom, hidden series and focus stay.
async function renews(file) {
  const { page, wrong, close } = await open(file);
  await wait(page);
  // The raw section as the program wrote it, with a change or without.
  const mounted = (change) => page.evaluate(([html, change]) => {
    const raw = new DOMParser().parseFromString(html, "text/html"), own = JSON.parse(raw.getElementById("data").textContent);
    const section = raw.getElementById("s1");
    section.querySelectorAll("h2").forEach((h) => h.remove());
    let root = document.getElementById("renewed");
    if (!root) {
      root = Object.assign(document.createElement("section"), { id: "renewed" });
      document.querySelector("main").prepend(root);
    }
    const rows = [...section.querySelectorAll("div.table tbody")[0].rows];
    if (change === "rows") {
      // Another loss, one row less, and a motor that the page did not know.
      rows.at(-1).remove();
      const name = rows[0].cells[0].textContent;
      own.ids[rows[0].dataset.i] = "a-motor-of-later";
      rows[0].cells[[...rows[0].cells].findIndex((c) => c.textContent === name)].textContent = "a-motor-of-later";
      for (const figure of own.figures) for (const g of figure.groups) for (const p of g.panels) for (const s of p.series) s.y = s.y.map((v) => v === null ? v : 1.01 * v);
    }
    if (change === "other") section.querySelectorAll("div.table thead th")[0].textContent = "another head";
    mount(root, { html: section.innerHTML, ids: own.ids, figures: own.figures });
  }, [fs.readFileSync(file, "utf8"), change]);
  await mounted("");
  await wait(page);
  const table = page.locator("#renewed div.table").first(), sort = table.locator("thead th button").nth(2);
  await sort.click();
  await sort.click();
  await table.getByRole("searchbox").fill("-maxon");
  const before = await page.evaluate(() => {
    const host = document.querySelector("#renewed .plot"), view = panels.find((v) => v.host === host);
    const [low, high] = view.full.x;
    view.plot.setScale("x", { min: low + 0.25 * (high - low), max: low + 0.5 * (high - low) });
    const button = document.querySelector("#renewed .legend button");
    button.click();
    button.focus();
    return { panels: panels.length, hidden: button.textContent, table: document.querySelector("#renewed div.table"), y: view.panel.series.map((s) => s.y) };
  });
  await wait(page);
  const seen = () => page.evaluate(() => {
    const host = document.querySelector("#renewed .plot"), view = panels.find((v) => v.host === host);
    const { min, max } = view.plot.scales.x, [low, high] = view.full.x, button = document.querySelector("#renewed .legend button");
    const table = document.querySelector("#renewed div.table"), shown = [...table.querySelectorAll("tbody tr")].filter((r) => !r.hidden);
    return {
      zoom: [(min - low) / (high - low), (max - low) / (high - low)].map((v) => Math.round(100 * v)), reset: !host.querySelector(".reset").hidden,
      hidden: [...view.hidden], pressed: button.getAttribute("aria-pressed"), focus: document.activeElement === button,
      sort: table.querySelectorAll("thead th")[2].getAttribute("aria-sort"), filter: table.querySelector("input").value,
      maxon: shown.some((r) => r.textContent.includes("maxon")), rows: table.querySelectorAll("tbody tr").length, later: table.textContent.includes("a-motor-of-later"),
      keys: shown.map((r) => parseFloat(r.cells[2].textContent)).filter((v) => !Number.isNaN(v)), y: view.panel.series.map((s) => s.y), panels: panels.length,
    };
  });
  const first = await seen();
  await mounted("rows");
  await wait(page);
  const now = await seen();
  const kept = ({ zoom, reset, hidden, pressed, focus, sort, filter, maxon, panels }) => ({ zoom, reset, hidden, pressed, focus, sort, filter, maxon, panels });
  equal(kept(now), kept(first), "what the user did stays");
  equal({ ...kept(now), panels: 0 }, { zoom: [25, 50], reset: true, hidden: [before.hidden], pressed: "false", focus: true, sort: "descending", filter: "-maxon", maxon: false, panels: 0 });
  equal(now.rows, first.rows - 1, "a row went");
  ok(now.later && !first.later, "another came");
  equal(now.keys, [...now.keys].sort((a, b) => b - a), "what is new is in order");
  ok(JSON.stringify(now.y) !== JSON.stringify(first.y), "the diagram shows what is new");
  // The new motor is one thing in table and diagram.
  await table.getByRole("searchbox").fill("");
  equal((await seen()).keys, [...(await seen()).keys].sort((a, b) => b - a));
  await table.getByRole("button", { name: "a-motor-of-later" }).click();
  ok((await page.locator("#chosen-text").textContent()).startsWith("a-motor-of-later: in 1 row"));
  // What is not alike is replaced: its filter goes with it.
  await mounted("other");
  await wait(page);
  equal(await page.evaluate(() => document.querySelector("#renewed div.table input")?.value ?? ""), "");
  equal((await seen()).panels, first.panels, "no diagram is left behind");
  equal(wrong, []);
  await close();
}

// The columns that are not shown at once come by the button, and go again.
async function columns(file) {
  const { page, wrong, close } = await open(file, { viewport: { width: 1440, height: 900 } });
  await wait(page);
  const table = page.locator("#s0 div.table").first(), head = table.locator("thead th"), all = await head.count();
  const shown = () => head.evaluateAll((heads) => heads.filter((h) => h.offsetWidth > 0).length);
  const few = await shown();
  ok(few >= 5 && few < all, `${few} of ${all} columns`);
  const button = table.getByRole("button", { name: `all ${all} columns` });
  await button.click();
  equal(await shown(), all);
  await table.getByRole("button", { name: "main columns" }).click();
  equal(await shown(), few);
  equal(wrong, []);
  await close();
}

async function highlights(file) {
  const { page, wrong, close } = await open(file);
  // A mark in the first diagram that has marks of a motor.
  const target = await page.evaluate(() => {
    for (const [v, view] of panels.entries()) {
      for (const m of view.marks) {
        if (m.line || !m.s.ids) continue;
        const box = view.plot.over.getBoundingClientRect(), ratio = devicePixelRatio || 1, bbox = view.plot.bbox;
        const k = m.px.findIndex(Number.isFinite);
        view.host.scrollIntoView({ block: "center" });
        const now = view.plot.over.getBoundingClientRect();
        return { v, id: m.s.ids.length === 1 ? m.s.ids[0] : m.s.ids[k], x: now.left + (m.px[k] - bbox.left) / ratio, y: now.top + (m.py[k] - bbox.top) / ratio };
      }
    }
  });
  const motor = await page.evaluate((id) => data.ids[id], target.id);
  const picture = () => page.evaluate((v) => panels[v].plot.root.querySelector("canvas").toDataURL(), target.v);
  const plain = await picture();
  await page.mouse.move(target.x, target.y);
  await wait(page);
  const tip = page.locator("#tip");
  ok(await tip.isVisible(), "the pointer on a mark says what it is");
  ok((await tip.textContent()).includes(motor), `the note names ${motor}`);
  ok((await picture()) !== plain, "hovering is seen in the diagram");
  ok((await page.locator("tr.hovered").count()) > 0, "hovering is seen in the tables");
  await page.mouse.click(target.x, target.y);
  await wait(page);
  const names = await page.locator("tr.chosen").evaluateAll((rows) => rows.map((r) => [...r.cells].map((c) => c.textContent)));
  ok(names.length > 0 && names.every((cells) => cells.includes(motor)), "only the rows of this motor are chosen");
  const tables = await page.evaluate((motor) => [...document.querySelectorAll("tbody tr")].filter((r) => [...r.cells].some((c) => c.textContent === motor) && r.dataset.i !== undefined).length, motor);
  equal(names.length, tables, "all rows of this motor are chosen");
  const lit = await page.evaluate((id) => panels.filter((v) => v.panel.series.some((s) => s.ids?.includes(id))).map((v) => v.host.dataset.lit), target.id);
  ok(lit.length > 0 && lit.every((l) => l === String(target.id)), "every diagram with this motor shows it");
  ok((await page.locator("#chosen-text").textContent()).startsWith(`${motor}: in ${names.length} row`));
  await page.screenshot({ path: path.join(folder, `${path.basename(file, ".html")}-chosen.png`) });
  await page.keyboard.press("Escape");
  await wait(page);
  equal(await page.locator("tr.chosen").count(), 0, "Escape clears");
  ok(await page.locator("#chosen").isHidden());
  // From a table, by keyboard.
  const pick = page.locator("button.pick", { hasText: motor }).first();
  await pick.focus();
  await page.keyboard.press("Enter");
  equal(await pick.getAttribute("aria-pressed"), "true");
  equal(await page.evaluate(() => state.chosen), target.id, "a table's button chooses");
  await page.keyboard.press("Escape");
  equal(wrong, []);
  await close();
}

async function zooms(file) {
  const { page, wrong, close } = await open(file);
  const box = await page.evaluate(() => { panels[0].host.scrollIntoView({ block: "center" }); const b = panels[0].plot.over.getBoundingClientRect(); return { x: b.x, y: b.y, w: b.width, h: b.height }; });
  const range = () => page.evaluate(() => ["x", "y"].map((k) => [panels[0].plot.scales[k].min, panels[0].plot.scales[k].max]));
  const full = await range();
  await page.mouse.move(box.x + 0.3 * box.w, box.y + 0.3 * box.h);
  await page.mouse.down();
  await page.mouse.move(box.x + 0.5 * box.w, box.y + 0.5 * box.h, { steps: 4 });
  await page.mouse.move(box.x + 0.7 * box.w, box.y + 0.7 * box.h, { steps: 4 });
  await page.mouse.up();
  await wait(page);
  const near = await range();
  for (const k of [0, 1]) ok(near[k][0] > full[k][0] && near[k][1] < full[k][1], "a drawn rectangle is the new range");
  await page.screenshot({ path: path.join(folder, "zoomed.png") });
  await page.getByRole("button", { name: "whole range" }).first().click();
  await wait(page);
  equal(await range(), full, "the button gives the whole range");
  const legend = page.locator(".legend button").first();
  const marks = () => page.evaluate(() => panels.reduce((n, v) => n + v.marks.length, 0));
  const all = await marks();
  await legend.click();
  await wait(page);
  ok((await marks()) < all, "the legend hides");
  await legend.click();
  await wait(page);
  equal(await marks(), all, "and shows again");
  equal(wrong, []);
  await close();
}

async function themes(file) {
  const { page, wrong, close } = await open(file, { colorScheme: "light" });
  const ground = () => page.evaluate(() => getComputedStyle(document.body).backgroundColor);
  const canvas = () => page.evaluate(() => panels[0].plot.root.querySelector("canvas").toDataURL());
  const light = [await ground(), await canvas()];
  await page.getByRole("button", { name: /^theme/ }).click();
  await wait(page);
  ok((await ground()) !== light[0] && (await canvas()) !== light[1], "the button makes it dark, diagrams too");
  // Printed, it is light whatever the theme.
  const pdf = await page.pdf({ format: "A4", path: path.join(folder, `${path.basename(file, ".html")}.pdf`) });
  ok(pdf.length > 10000);
  equal(wrong, []);
  await close();
}

async function holds(file, names) {
  const { page, wrong, close } = await open(file);
  await page.waitForTimeout(200);
  equal(wrong, [], "hostile names do nothing");
  equal(await page.locator("img, iframe, object, embed, b:not(#tip b)").count(), 0, "no element came in");
  equal(await page.locator("script").count(), 2);
  const shown = await page.evaluate(() => document.body.innerText);
  for (const name of names.filter((n) => !n.includes("\u2028"))) ok(shown.includes(name), `${name} is shown`);
  await page.evaluate(() => choose(0));
  ok(await page.locator("#chosen").isVisible());
  const target = await page.evaluate(() => {
    const view = panels[0], m = view.marks.find((m) => m.s.ids || m.s.name), bbox = view.plot.bbox;
    view.host.scrollIntoView({ block: "center" });
    const box = view.plot.over.getBoundingClientRect();
    const k = Math.floor(m.px.length / 2);
    return { x: box.left + m.px[k] - bbox.left, y: box.top + m.py[k] - bbox.top };
  });
  await page.mouse.move(target.x, target.y);
  await wait(page);
  ok(await page.locator("#tip").isVisible(), `${file}: a mark says what it is`);
  equal(await page.locator("#tip img, #tip script").count(), 0);
  equal(wrong, [], "nor when pointed at");
  // The policy is in force: what would come in could not run, nor call home.
  const ran = await page.evaluate(async () => {
    const script = document.createElement("script");
    script.textContent = "window.ran = true";
    document.body.append(script);
    const holder = document.createElement("div");
    holder.innerHTML = '<img src="x" onerror="window.ran = true">';
    document.body.append(holder);
    const fetched = await fetch("https://example.org/").then(() => true, () => false);
    await new Promise((done) => setTimeout(done, 100));
    return [window.ran === true, fetched];
  });
  equal(ran, [false, false], "the policy forbids scripts and the network");
  ok(wrong.some((w) => w.includes("Content Security Policy")), "and the browser says so");
  ok(!wrong.some((w) => w.startsWith("dialog")), "no dialog");
  await close();
}

const files = Object.fromEntries(Object.keys(commands).filter((n) => !only || only.split(",").includes(n)).map((name) => [name, make(name)]));
for (const [name, file] of Object.entries(files)) {
  await looks(name, file);
  console.log(`${name}: ${fs.statSync(file).size} bytes`);
}
if (files.check) await finds(files.check);
if (files.optimize) await sortsAndFilters(files.optimize);
if (files.optimize) await columns(files.optimize);
if (files.optimize) await renews(files.optimize);
for (const name of ["optimize", "rank", "sweep", "pareto"]) if (files[name]) await highlights(files[name]);
if (files.rank) await zooms(files.rank);
for (const name of ["optimize", "rank"]) if (files[name]) await themes(files[name]);
if (files.hostile_rank) await holds(files.hostile_rank, hostile);
if (files.hostile_compare) await holds(files.hostile_compare, hostile.slice(0, 2));
if (!only) {
  await looks("hostile_ids", hostileIds);
  await holds(hostileIds, hostile.slice(0, 4));
}
await browser.close();
console.log(`${checks} checks hold in Chromium ${version}`);
