// A browser on a running `hitl serve`, as a person has it.

import assert from "node:assert/strict";
import { chromium } from "playwright-core";
import { spawn } from "node:child_process";
import { existsSync, mkdtempSync, rmSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";

export const project = new URL("../../", import.meta.url).pathname;
export const hitl = process.env.HITL ?? join(project, "target/release/hitl");
/** Set: screenshots of every step go there. */
const shots = process.env.HITL_SHOTS;

export async function browser(more = []) {
  const executablePath = ["/usr/bin/chromium", "/usr/bin/chromium-browser", "/usr/bin/google-chrome"].find(existsSync);
  if (!executablePath) throw new Error("found no chromium, expected /usr/bin/chromium: apt-get install chromium");
  const args = ["--headless", "--no-sandbox", "--disable-gpu", "--disable-quic", "--no-first-run", "--disable-background-networking", "--disable-component-update", "--disable-sync", ...more];
  return chromium.launch({ executablePath, args });
}

const children = new Set();

/** Ends every server that is still running. */
export function killAll() {
  children.forEach((child) => child.kill("SIGKILL"));
}

/** Runs `hitl serve` in a folder of its own. */
export async function serve(args = [], folder = mkdtempSync(join(tmpdir(), "hitl-page-"))) {
  const started = performance.now();
  const child = spawn(hitl, ["serve", "--no-open", ...args], { cwd: folder });
  children.add(child);
  child.on("exit", () => children.delete(child));
  let errors = "";
  child.stderr.on("data", (text) => { errors += text; });
  const url = await new Promise((resolve, reject) => {
    child.stdout.once("data", (text) => resolve(String(text).trim()));
    child.once("exit", (code) => reject(new Error(`hitl serve ended with ${code}: ${errors}`)));
  });
  const end = (signal) => new Promise((resolve) => { child.removeAllListeners("exit"); child.once("exit", resolve); child.kill(signal); });
  return { url, folder, started, end, clean: () => rmSync(folder, { recursive: true, force: true }) };
}

/** A page with what a person does on it. */
export class Person {
  /** `match`: let visits be matched after every change, as the page does if it is not told otherwise. */
  static async at(browser, url, { match = false, ...options } = {}) {
    const context = await browser.newContext({ acceptDownloads: true, viewport: { width: 1280, height: 800 }, ...options });
    if (!match) await context.addInitScript(() => localStorage.setItem("match", "0"));
    const page = await context.newPage();
    const person = new Person(page);
    page.on("pageerror", (error) => person.faults.push(error.message));
    page.on("console", (message) => { if (message.type() === "error" && !/status of 4\d\d/.test(message.text())) person.faults.push(message.text()); });
    await page.goto(url);
    return person;
  }

  constructor(page) { this.page = page; this.faults = []; this.count = 0; }

  model(f, ...args) { return this.page.evaluate(`(${f})(window.hitl.model, ...${JSON.stringify(args)})`); }
  ready() { return this.page.waitForFunction(() => window.hitl?.model.map > 0 && window.hitl.frames.length > 0); }
  corrections() { return this.model((m) => m.state.corrections); }
  poses() { return this.model((m) => Array.from(m.now)); }
  async status() { return (await this.page.textContent("#step")).trim(); }
  at(point) { return this.model((m, p) => m.view.toScreen(p), point); }
  async shot(name) {
    if (!shots) return;
    await this.page.waitForTimeout(450);
    await this.page.screenshot({ path: join(shots, `${name}.png`) });
  }

  /** Draws with the mouse, ends in the world. */
  async draw([from, to], during) {
    const [p, q] = [await this.at(from), await this.at(to)];
    await this.page.mouse.move(...p);
    await this.page.mouse.down();
    for (let k = 1; k <= 6; k++) await this.page.mouse.move(p[0] + ((q[0] - p[0]) * k) / 6, p[1] + ((q[1] - p[1]) * k) / 6);
    if (during) await during();
    const before = await this.model((m) => m.strokes.length);
    await this.page.mouse.up();
    await this.page.waitForFunction((n) => window.hitl.model.strokes.length !== n || window.hitl.model.tool === "none" || !document.getElementById("toast").hidden, before);
  }

  previewed() { return this.page.waitForFunction(() => window.hitl.model.preview); }

  /** Waits until the map is another one than before something was done. */
  async changes(what) {
    const before = await this.model((m) => m.revision);
    await what();
    await this.page.waitForFunction((n) => window.hitl.model.revision !== n && window.hitl.model.state.revision === window.hitl.model.revision, before);
  }
}

/** A served demo with a person in front of it. */
export async function demo(chromium, options) {
  const served = await serve();
  const person = await Person.at(chromium, served.url, options);
  await person.page.click("#demo");
  await person.ready();
  return { served, person };
}

/** Nothing went wrong in the page, and the server ends as it should. */
export async function done({ served, person }) {
  assert.deepEqual(person.faults, []);
  await person.page.context().close();
  assert.equal(await served.end("SIGINT"), 0, "Ctrl-C ends it cleanly");
  served.clean();
}

/** How far two sets of poses are apart at most, per coordinate. */
export const distance = (p, q) => Math.max(...p.map((v, k) => (k % 3 === 2 ? 0 : Math.abs(v - q[k]))));

/** The first correction of data/aces.corrections.jsonl: the two ends of the bent map, one wall. */
export const STROKES = [[[-0.9, -1.5], [-3.4, -1.5]], [[-4.9, 11.1], [-7.1, 9.9]]];
