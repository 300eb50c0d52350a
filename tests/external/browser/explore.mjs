// The explorer in a browser, as a user would: node explore.mjs PROGRAM FOLDER
// Pictures are left in FOLDER to be looked at; how long an answer takes until it is painted is printed.
import { chromium } from "playwright-core";
import { spawn, spawnSync } from "node:child_process";
import assert from "node:assert/strict";
import fs from "node:fs";
import path from "node:path";
import { pathToFileURL } from "node:url";
import { faults } from "./faults.mjs";

const [program, folder] = process.argv.slice(2).map((p) => path.resolve(p));
const root = path.resolve(import.meta.dirname, "../../..");
const requirement = "requirements/quadruped_mini_cheetah.toml";
fs.mkdirSync(folder, { recursive: true });
const axe = fs.readFileSync(path.join(import.meta.dirname, "node_modules/axe-core/axe.min.js"), "utf8");

let checks = 0;
const ok = (condition, message) => { checks++; assert.ok(condition, message); };
const equal = (a, b, message) => { checks++; assert.deepEqual(a, b, message); };

// A server of its own: its address, and how to end it.
async function serve(...words) {
  const child = spawn(program, ["explore", ...words], { cwd: root, stdio: ["ignore", "pipe", "ignore"] });
  const url = await new Promise((done, failed) => {
    child.stdout.once("data", (text) => done(String(text).trim()));
    child.once("exit", (code) => failed(new Error(`explore ended with ${code}`)));
  });
  return { url, end: () => new Promise((done) => { child.once("exit", done); child.kill("SIGKILL"); }) };
}

const browser = await chromium.launch({
  executablePath: process.env.CHROMIUM ?? "/usr/bin/chromium",
  args: ["--headless", "--no-sandbox", "--disable-gpu", "--disable-quic", "--no-first-run", "--disable-background-networking", "--disable-component-update", "--disable-sync"],
});

// A page that notes what it should not do, and the replies that it gets.
async function open(url, options) {
  const context = await browser.newContext({ viewport: { width: 1440, height: 1000 }, acceptDownloads: true, ...options });
  const page = await context.newPage();
  page.setDefaultTimeout(120000);
  const wrong = [], replies = [], asked = [];
  page.on("console", (m) => ["error", "warning"].includes(m.type()) && wrong.push(`console: ${m.text()}`));
  page.on("pageerror", (e) => wrong.push(`error: ${e.message}`));
  page.on("dialog", (d) => { wrong.push(`dialog: ${d.message()}`); d.dismiss(); });
  const origin = new URL(url).origin;
  page.on("request", (r) => {
    if (!["data:", "blob:"].includes(new URL(r.url()).protocol) && new URL(r.url()).origin !== origin) wrong.push(`request: ${r.url()}`);
    if (r.url().endsWith("/ask")) asked.push(r.postDataJSON());
  });
  page.on("response", async (r) => {
    if (/\/(ask|more)$/.test(r.url()) && r.status() === 200) replies.push(await r.json().catch(() => null));
  });
  await page.goto(url);
  const of = { page, wrong, replies, asked, context, close: () => context.close() };
  await settled(of);
  return of;
}
// Until everything was answered and painted.
async function settled({ page }) {
  await page.waitForTimeout(60);
  await page.waitForFunction(() => !/…|motors$/.test(document.getElementById("busy").textContent) && document.querySelector("#headline p") && !document.querySelector(".waits"));
  await page.evaluate(() => new Promise((done) => requestAnimationFrame(() => setTimeout(done, 90))));
}
const headline = ({ page }) => page.evaluate(() => document.querySelector("#headline p").textContent);
const slide = async (of, id, value) => {
  await of.page.evaluate(([id, value]) => {
    const e = document.getElementById(id);
    e.value = value;
    e.dispatchEvent(new Event("input"));
  }, [id, value]);
  await settled(of);
};
const first = (replies, joint) => replies.flatMap((r) => r?.joints ?? []).filter((j) => j.joint === joint).at(-1);
const state = (page) => page.evaluate(() => Object.fromEntries(location.hash.slice(1).split("&").filter(Boolean).map((p) => p.split("=").map(decodeURIComponent))));

// Every control asks for what it shows, and gives back what the file says.
async function controls(url) {
  const of = await open(`${url}#joint=knee`), { page, wrong, asked } = of;
  const before = await headline(of);
  const keys = await page.evaluate(() => [...document.querySelectorAll(".control[data-key] input[type=range]")].filter((e) => e.id).map((e) => e.id.slice(2)));
  ok(keys.length === 11 && keys.includes("joint.knee.ratio.max"), `${keys}`);
  for (const key of keys) {
    const [from, to] = key.endsWith("ratio.min") ? [200, 300] : key.endsWith("ratio.max") ? [500, 600] : [300, 700];
    for (const value of [from, to]) await slide(of, `c-${key}`, value);
    const { state: last } = asked.at(-1), shown = await page.locator(`.control[data-key="${key}"] input[type=text]`).inputValue();
    equal(Object.keys(last), [key], key);
    equal(last[key], shown, `${key}: the field has what was asked`);
    ok(await page.locator(`.control[data-key="${key}"].turned`).count(), `${key} is marked`);
    await page.locator(`.control[data-key="${key}"] .undo`).click();
    await settled(of);
    equal(asked.at(-1).state, {}, `${key} is the file's again`);
    equal(await headline(of), before, `${key}: and so is the answer`);
  }
  // A field takes a bare number in its unit, and a number with another unit.
  for (const [typed, meant] of [["36", "36 V"], ["0.036 kV", "0.036 kV"]]) {
    const field = page.locator(".control[data-key='bus.voltage'] input[type=text]");
    await field.fill(typed);
    await field.press("Enter");
    await settled(of);
    equal(asked.at(-1).state, { "bus.voltage": meant });
  }
  equal(await page.locator(".wrong").count(), 0);
  await page.selectOption("#objective-pick", "mass");
  await settled(of);
  ok((await headline(of)).includes("mass"), "what is best is chosen");
  await page.selectOption("#objective-pick", "weights of three");
  await settled(of);
  ok(/loss = 1, mass = 1/.test(asked.at(-1).state["joint.knee.objective"]) && /loss = "/.test(asked.at(-1).state["joint.knee.reference"]), "weights have references");
  equal(wrong, []);
  await of.close();
}

// A wrong value leaves the last answer, in grey, with the message at its control.
async function mistakes(url) {
  const of = await open(`${url}#joint=knee`), { page } = of, before = await headline(of);
  const field = page.locator(".control[data-key='bus.voltage'] input[type=text]");
  await field.fill("36 X");
  await field.press("Enter");
  await settled(of);
  ok((await page.locator(".control[data-key='bus.voltage'] .wrong").textContent()).includes("unknown unit"));
  equal([await field.getAttribute("aria-invalid"), await page.locator("#views.stale").count(), await headline(of)], ["true", 1, before]);
  ok(await page.evaluate(() => document.getElementById(document.activeElement.getAttribute("aria-describedby"))?.textContent.includes("unit")), "the message is described by");
  await field.fill("30");
  await field.press("Enter");
  await settled(of);
  equal([await field.getAttribute("aria-invalid"), await page.locator("#views.stale").count(), await page.locator(".wrong").count()], [null, 0, 0]);
  await of.close();
  // Of a link what is good is applied.
  const link = await open(`${url}#joint=knee&bus.voltage=zz&scale.torque=1.1&no.such=1&file=00000000`);
  equal(link.asked.at(-1).lenient, true);
  const banner = await link.page.locator("#banner").textContent();
  ok(banner.includes("no.such") && banner.includes("another requirements/quadruped_mini_cheetah.toml"), banner);
  ok((await link.page.locator(".control[data-key='bus.voltage'] .wrong").textContent()).length > 10);
  equal(await link.page.locator(".control[data-key='scale.torque'] input[type=text]").inputValue(), "1.1");
  await link.close();
}

// Saved, the file gives the same ratio to the last digit; copied, the link gives the same page; Back goes back.
async function rounds(url) {
  const of = await open(`${url}#joint=knee`), { page, replies, wrong } = of, plain = await headline(of);
  await slide(of, "c-bus.voltage", 620);
  // What stands for half a second is a step.
  await page.waitForTimeout(600);
  await slide(of, "c-scale.torque", 610);
  const turned = await headline(of), shown = first(replies, "knee");
  ok(turned !== plain);
  const [download] = await Promise.all([page.waitForEvent("download"), page.click("#save")]);
  const file = path.join(root, "requirements", `.explored_${process.pid}.toml`);
  try {
    await download.saveAs(file);
    const saved = spawnSync(program, ["optimize", file, "--json"], { cwd: root, encoding: "utf8" });
    const best = JSON.parse(saved.stdout).joints.find((j) => j.joint === "knee").candidates[0];
    equal([best.motor, best.ratio], [shown.motor, shown.ratio], "the saved file chooses what was shown");
    ok(fs.readFileSync(file, "utf8").includes("# Motions: hip and knee"), "comments are kept");
  } finally { fs.rmSync(file, { force: true }); }
  await page.waitForTimeout(600);
  const link = await page.evaluate(() => location.hash);
  ok(!link.includes(new URL(url).pathname.split("/")[1]), "a link has no secret in it");
  const other = await open(url + link);
  equal([await headline(other), first(other.replies, "knee").ratio], [turned, shown.ratio], "the same page by the link");
  await other.close();
  const again = await open(url);
  await again.page.evaluate((link) => { location.hash = link; }, link);
  await settled(again);
  equal(await headline(again), turned, "and typed behind the address");
  await again.close();
  await page.goBack();
  await settled(of);
  await page.goBack();
  await settled(of);
  equal(await headline(of), plain, "Back goes back");
  await page.goForward();
  await page.goForward();
  await settled(of);
  equal(await headline(of), turned);
  await page.locator("h1").click();
  await page.keyboard.press("Control+z");
  await settled(of);
  ok((await headline(of)) !== turned, "Ctrl-Z too");
  equal(wrong, []);
  await of.close();
}

// Answers that come late are those of what was asked last.
async function late(url) {
  const of = await open(`${url}#joint=knee`), { page, replies } = of;
  let held = null, count = 0;
  await page.route("**/ask", async (route) => {
    if (count++ === 0) await new Promise((done) => { held = done; });
    await route.continue();
  });
  await page.evaluate(() => { for (const value of [300, 400, 500, 650]) { const e = document.getElementById("c-scale.torque"); e.value = value; e.dispatchEvent(new Event("input")); } });
  await page.waitForFunction(() => document.getElementById("busy").textContent === "…");
  await page.waitForTimeout(100);
  equal(count, 1, "one flies, the latest waits");
  held();
  await settled(of);
  const field = await page.locator(".control[data-key='scale.torque'] input[type=text]").inputValue();
  const last = replies.filter((r) => r?.views?.headline).at(-1);
  equal([last.state["scale.torque"], count], [field, 2], "what is shown is what was asked last");
  await of.close();
}

// The ratio, a motor that is rejected in two clicks, pins.
async function designs(url) {
  const of = await open(`${url}#joint=knee`), { page, wrong } = of;
  const sentence = () => page.locator("#design > p").first().textContent();
  const lines = () => page.evaluate(() => panels.filter((v) => v.host.closest("#design")).map((v) => v.plot.root.querySelector("canvas").toDataURL().length));
  await page.locator("#looked").scrollIntoViewIfNeeded();
  await page.waitForTimeout(200);
  const before = [await sentence(), await lines()];
  await slide(of, "ratio-at", 400);
  ok((await sentence()) !== before[0], "N moves the design");
  ok((await lines()).some((l, k) => l !== before[1][k]), "and its diagrams");
  await page.click("#ratio-best");
  await settled(of);
  equal(await sentence(), before[0], "N* is the best again");
  await page.evaluate(() => scrollTo(0, 0));
  await page.click("#pin");
  await settled(of);
  // From the first view two clicks lead to why a motor was rejected.
  await page.locator("#others summary", { hasText: "Why not the others" }).click();
  const row = page.locator("#others details[open] tbody tr").first(), motor = await row.locator(".pick").textContent();
  const why = await row.locator("td").nth(1).textContent();
  ok(why.length > 10, "one click shows why");
  await row.locator(".pick").click();
  await settled(of);
  ok((await sentence()).includes(motor) && (await page.locator("#design").textContent()).includes("What is exceeded at this ratio"), "two clicks show by how much");
  ok((await page.locator("#design").textContent()).includes("is not feasible"));
  await page.click("#pin");
  await settled(of);
  ok(await page.locator("#held").isVisible());
  equal(await page.locator("#pinned .pinned").count(), 2);
  const heads = await page.locator("#pins thead th").allTextContents();
  equal(heads.map((h) => h.trim()), ["quantity", "unit", "A", "B", "difference"]);
  const [, , a, b, difference] = await page.locator("#pins tbody tr").first().locator("td").allTextContents();
  ok(Math.abs(Number(b) - Number(a) - parseFloat(difference)) < 2e-3 * Math.abs(Number(b)), `${a} ${b} ${difference}`);
  equal(await page.locator("#pins .plot").count(), 2, "both envelopes");
  await page.waitForTimeout(600);
  equal(await page.evaluate(() => location.hash.match(/pin=/g).length), 2, "pins are in the link");
  await page.locator("#pinned button", { hasText: "×" }).first().click();
  await settled(of);
  equal(await page.locator("#pinned .pinned").count(), 1);
  await page.click("#fronts");
  await page.waitForSelector("#front figure");
  await settled(of);
  // What was folded stays open, and a filter stays, when something is turned.
  await page.locator("#ranking .bar input").fill("maxon");
  await slide(of, "c-bus.voltage", 560);
  ok(await page.locator("#others details[open]").count(), "what was open stays open");
  equal(await page.locator("#ranking .bar input").inputValue(), "maxon");
  await page.waitForTimeout(600);
  equal((await state(page)).filter, "maxon");
  equal(wrong, []);
  await of.close();
}

// What takes long shows how far it is over the last answer.
async function pending() {
  const served = await serve("requirements/ankle_prosthesis_parallel_spring.toml");
  const of = await open(served.url), { page, replies, wrong } = of;
  await page.evaluate(() => {
    window.seen = [];
    new MutationObserver(() => window.seen.push([document.getElementById("busy").textContent, document.getElementById("views").classList.contains("stale")])).observe(document.getElementById("busy"), { childList: true, characterData: true, subtree: true });
  });
  await slide(of, "c-scale.torque", 520);
  const seen = await page.evaluate(() => window.seen);
  ok(seen.some(([text, stale]) => /^\d+ of \d+ motors$/.test(text) && stale), `how far it is, and in grey: ${JSON.stringify(seen)}`);
  ok(replies.some((r) => r?.far), "the program said so");
  equal(await page.locator("#views.stale").count(), 0);
  equal(wrong, []);
  // Killed while it is asked: it is said, and the last answer stays.
  const before = await headline(of);
  await page.evaluate(() => { const e = document.getElementById("c-scale.torque"); e.value = 480; e.dispatchEvent(new Event("input")); });
  await page.waitForTimeout(150);
  await served.end();
  await page.waitForFunction(() => document.getElementById("banner").textContent.includes("was stopped"));
  equal([await headline(of), await page.locator("#views.stale").count()], [before, 1]);
  await of.close();
}

// What is clicked while a state is worked on does not leave the answer of another state.
async function owed() {
  const served = await serve("requirements/arm_six_axis_pick_and_place.toml");
  const of = await open(served.url), { page } = of;
  for (const wait of [0, 60, 300]) {
    await page.evaluate((value) => { const e = document.getElementById("c-scale.torque"); e.value = value; e.dispatchEvent(new Event("input")); }, 300 + wait);
    await page.waitForTimeout(wait);
    await page.locator("#ranking .pick").nth(2).click();
    await page.waitForTimeout(1500);
    await settled(of);
    const cards = () => page.locator("#joints button").allTextContents();
    const seen = [await headline(of), await cards(), await page.locator("#views.stale").count()];
    const again = await open(served.url + (await page.evaluate(() => location.hash)));
    equal(seen, [await headline(again), await again.page.locator("#joints button").allTextContents(), 0], `clicked after ${wait} ms`);
    await again.close();
  }
  await of.close();
  await served.end();
}

// Everything by keyboard alone.
async function keyboard(url) {
  const of = await open(`${url}#joint=knee`), { page, asked } = of;
  const named = () => page.evaluate(() => { const e = document.activeElement; return e.id || e.getAttribute("aria-label") || e.textContent.trim(); });
  await page.keyboard.press("Tab");
  equal(await named(), "to the answer", "the first is a way past the controls");
  const seen = [];
  for (let k = 0; k < 60; k++) { seen.push(await named()); await page.keyboard.press("Tab"); }
  for (const wanted of ["link", "save", "report", "theme", "c-bus.voltage", "c-joint.knee.limits.safety", "objective-pick"]) ok(seen.includes(wanted), `${wanted} is reached: ${seen}`);
  await page.focus("[id='c-bus.voltage']");
  const before = asked.length;
  await page.keyboard.press("ArrowRight");
  await settled(of);
  ok(asked.length > before && asked.at(-1).state["bus.voltage"], "an arrow turns");
  equal(await named(), "c-bus.voltage", "and the focus stays");
  await page.locator("#ranking .pick").nth(1).focus();
  const motor = await named();
  await page.keyboard.press("Enter");
  await settled(of);
  equal(asked.at(-1).design, motor);
  await page.locator("#others summary").last().focus();
  await page.keyboard.press("Enter");
  ok(await page.locator("#others details[open]").count());
  await of.close();
}

// Nothing is cut, off screen, faint, or unnamed in any look.
async function looks(url) {
  const link = "#joint=knee&scale.torque=1.1&pin=joint%3Dknee&pin=joint%3Dhip%26design%3Dt-motor-u8-lee";
  const views = { "1440-light": [1440, 1000, "light"], "1440-dark": [1440, 1000, "dark"], "1024-light": [1024, 1000, "light"], "1024-dark": [1024, 1000, "dark"], "390-light": [390, 844, "light"], "390-dark": [390, 844, "dark"] };
  for (const [name, [width, height, colorScheme]] of Object.entries(views)) {
    const phone = width < 700 ? { deviceScaleFactor: 2, isMobile: true, hasTouch: true } : {};
    const of = await open(url + link, { viewport: { width, height }, colorScheme, ...phone }), { page, wrong } = of;
    if (width < 700) {
      equal(await page.locator("#controls").isVisible(), false, "on a phone the answer comes first");
      await page.screenshot({ path: path.join(folder, `explore-${name}-closed.png`) });
      await page.locator("#sheet > summary").click();
    }
    await page.evaluate(() => document.querySelectorAll("#views details").forEach((d) => { d.open = true; }));
    await page.waitForTimeout(150);
    const wide = await page.evaluate(() => [document.documentElement.scrollWidth, innerWidth]);
    ok(wide[0] <= wide[1], `${name}: the page is ${wide[0]} px wide`);
    equal(await faults(page), [], name);
    await page.evaluate(axe);
    const found = await page.evaluate(() => window.axe.run(document, { resultTypes: ["violations"] }));
    equal(found.violations.map((v) => `${v.id}: ${v.nodes.slice(0, 3).map((n) => n.target.join(" ")).join(", ")}`), [], `${name}: axe`);
    await page.evaluate(() => document.querySelectorAll("#views details").forEach((d) => { d.open = false; }));
    await page.screenshot({ path: path.join(folder, `explore-${name}.png`) });
    equal(wrong.filter((w) => !w.includes("Content Security Policy")), [], name);
    await of.close();
  }
  // As somebody sees it who cannot tell red from green.
  const of = await open(url + link), cdp = await of.context.newCDPSession(of.page);
  await cdp.send("Emulation.setEmulatedVisionDeficiency", { type: "deuteranopia" });
  await of.page.locator("#looked").scrollIntoViewIfNeeded();
  await of.page.screenshot({ path: path.join(folder, "explore-deuteranopia.png") });
  await of.close();
}

// Names from a catalogue and from a link do nothing.
async function hostile() {
  const names = ["<script>alert(1)</script>", '"><img src=x onerror=alert(3)>', "\u202Eevil"], file = path.join(folder, "hostile.csv");
  const cell = (text) => `"${text.replaceAll('"', '""')}"`;
  const head = "id,manufacturer,model,source,source_kind,terminals,current,resistance [ohm],torque_constant [N*m/A],rotor_inertia [g*cm^2],mass [g],peak_current [A],continuous_current [A]";
  fs.writeFileSync(file, [head, ...names.map((name, k) => [`motor-${k}`, name, name, name, "datasheet", "q_axis", "q_axis", 0.1, 0.1, 300, 300, 60, 25].map((c) => cell(String(c))).join(","))].join("\n") + "\n");
  const served = await serve(requirement, "--also", file);
  const link = `#joint=${encodeURIComponent("<img src=x onerror=alert(1)>")}&design=${encodeURIComponent("<b>x</b>")}&pin=${encodeURIComponent("joint=<i>x</i>&design=<img src=x>")}&a.${encodeURIComponent("<img src=y>")}=1`;
  const of = await open(served.url + link), { page, wrong } = of;
  equal(await page.locator("img, iframe, object, embed, i").count(), 0, "no element came in");
  equal(await page.locator("script").count(), 2);
  ok((await page.locator("#banner").textContent()).includes("<img"), "they are shown as they are");
  equal(wrong, []);
  await of.close();
  await served.end();
}

// Two pages do not disturb each other.
async function tabs(url) {
  const a = await open(`${url}#joint=knee`), b = await open(`${url}#joint=hip`);
  const before = await headline(b);
  await slide(a, "c-bus.voltage", 700);
  equal(await headline(b), before);
  await slide(b, "c-scale.torque", 700);
  ok((await headline(b)) !== before);
  equal([await state(a.page), await state(b.page)].map((s) => s.joint), ["knee", "hip"]);
  await a.close();
  await b.close();
}

// A page that needs no program.
async function alone() {
  const file = path.join(folder, "what_if.html");
  const made = spawnSync(program, ["explore", requirement, "--static", file, "--grid", "bus.voltage=24 V,48 V", "--grid", "scale.torque=1,1.25"], { cwd: root, encoding: "utf8" });
  equal(made.status, 0, made.stderr);
  const context = await browser.newContext({ viewport: { width: 1440, height: 1000 }, offline: true }), page = await context.newPage(), wrong = [];
  page.on("console", (m) => ["error", "warning"].includes(m.type()) && wrong.push(m.text()));
  page.on("pageerror", (e) => wrong.push(e.message));
  page.on("request", (r) => r.url() !== pathToFileURL(file).href && !r.url().startsWith("data:") && wrong.push(r.url()));
  await page.goto(pathToFileURL(file).href);
  const of = { page };
  await settled(of);
  await page.locator("#joints button").nth(2).click();
  await settled(of);
  const plain = await headline(of);
  await slide(of, "c-scale.torque", 1);
  const turned = await headline(of);
  ok(plain !== turned, "its sliders move the answer");
  const set = spawnSync(program, ["optimize", requirement, "--json", "--set", "scale.torque=1.25"], { cwd: root, encoding: "utf8" });
  ok(turned.includes(JSON.parse(set.stdout).joints[2].candidates[0].motor));
  equal(await page.locator("#save, #report, #link, #pin").evaluateAll((all) => all.filter((e) => e.checkVisibility()).length), 0);
  equal(await faults(page), []);
  equal(wrong, []);
  await context.close();
}

// From a slider to the painted answer.
async function times(url) {
  for (const joint of ["hip_abad", "hip", "knee"]) {
    const of = await open(`${url}#joint=${joint}`), { page } = of;
    for (const id of ["c-bus.voltage", "c-scale.torque", "ratio-at"]) {
      await page.evaluate(() => { window.gearwiseTimes.length = 0; });
      for (let k = 0; k < 20; k++) await slide(of, id, 310 + 17 * k);
      const took = (await page.evaluate(() => window.gearwiseTimes)).map((t) => t.took).sort((a, b) => a - b);
      ok(took.length === 20, `${took.length} answers`);
      console.log(`${joint}, ${id}: painted after ${took[10].toFixed(0)} ms (median), ${took[18].toFixed(0)} ms (95 %)`);
    }
    await of.close();
  }
}

const served = await serve(requirement);
const all = { controls, mistakes, rounds, late, designs, keyboard, tabs, looks, times };
const only = process.env.ONLY?.split(",");
for (const [name, check] of Object.entries(all)) if (!only || only.includes(name)) { await check(served.url); console.log(`explore, ${name}: holds`); }
await served.end();
for (const [name, check] of Object.entries({ pending, owed, hostile, alone })) if (!only || only.includes(name)) { await check(); console.log(`explore, ${name}: holds`); }
const version = browser.version();
await browser.close();
console.log(`${checks} checks of the explorer hold in Chromium ${version}`);
