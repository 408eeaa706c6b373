// Walks on the page: a folder of `hitl feetslam`, a walk's CSV; layers and playback. `npm test`; HITL_SHOTS=DIR keeps pictures.

import assert from "node:assert/strict";
import { execFileSync } from "node:child_process";
import { mkdtempSync, rmSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { after, before, test } from "node:test";
import { Person, browser, hitl, killAll, serve } from "./browser.mjs";

let chromium, made;
before(async () => {
  made = mkdtempSync(join(tmpdir(), "hitl-walks-"));
  const run = (...args) => execFileSync(hitl, ["feetslam", ...args], { cwd: made, stdio: "ignore" });
  run("simulate", "rooms", "--seed", "2", "-o", "walks");
  run("run", ...[1, 2, 3, 4].map((k) => `walks/w${k}.csv`), "--mode", "footslam", "--particles", "200", "--start", "0,0,-90", "--plan", "walks/walls.csv", "-o", "out");
  chromium = await browser();
});
after(async () => { killAll(); await chromium?.close(); rmSync(made, { recursive: true, force: true }); });

/** The colours on the overlay that stand out, counted. */
const ink = (page) => page.evaluate(() => {
  const canvas = document.getElementById("overlay");
  const { data } = canvas.getContext("2d").getImageData(0, 0, canvas.width, canvas.height);
  let count = 0;
  for (let k = 3; k < data.length; k += 4) if (data[k] > 40) count++;
  return count;
});

test("a folder of feetslam shows its walks over the plan, plays them, and takes corrections", async () => {
  const served = await serve([join(made, "out")]);
  const person = await Person.at(chromium, served.url);
  const { page } = person;
  await person.ready();
  await page.waitForSelector("#playback:not([hidden])");
  assert.equal(await page.evaluate(() => window.hitl.model.state.map.name), "paths.csv");
  assert.match(await page.textContent("#playback"), /^▶.*of 1:|^▶.*of \d:\d\d$/);
  await person.shot("walks");
  const everything = await ink(page);

  // Dragged to the start, little is left; played, it comes back and ends at the end.
  await page.locator("#playback-time").evaluate((e) => { e.value = "5.5"; e.dispatchEvent(new Event("input")); });
  await page.waitForFunction(() => document.querySelector("#playback span").textContent.startsWith("0:05"));
  await person.shot("walks-early");
  assert.equal(await page.getAttribute("#play", "aria-label"), "Play");
  await page.click("#play");
  assert.equal(await page.getAttribute("#play", "aria-label"), "Pause");
  await page.waitForFunction(() => !document.querySelector("#playback span").textContent.startsWith("0:05"));
  await page.click("#play");
  assert.equal(await page.getAttribute("#play", "aria-label"), "Play");
  const shown = await page.textContent("#playback span");
  await page.waitForTimeout(300);
  assert.equal(await page.textContent("#playback span"), shown, "paused is paused");
  await person.shot("walks-paused");

  // Four walks are four lines of poses, and footprints are not matched with each other.
  assert.deepEqual(await page.evaluate(() => { const { walks, now } = window.hitl.model; return [walks.length, walks[0], walks[3] < now.length / 3]; }), [4, 0, true]);
  assert.match(await page.textContent("#match-said"), /footprints are no walls/);
  assert.ok(await page.isDisabled("#match-now"));

  // The layers by themselves.
  await page.click("#layers");
  assert.match(await page.textContent("#note-walks"), /^4 walks$/);
  assert.match(await page.textContent("#note-walls"), /^\d+ walls?$/);
  assert.match(await page.textContent("#note-hexagons"), /^0\.5 m$/);
  for (const name of ["hexagons", "walls", "walks"]) await page.uncheck(`#layer-${name}`);
  await page.keyboard.press("Escape");
  assert.ok(await page.isHidden("#playback"), "no walks, no playback");
  await page.waitForTimeout(100);
  assert.ok((await ink(page)) < 0.7 * everything, "nothing of them is left");

  assert.deepEqual(person.faults, []);
  await page.context().close();
  assert.equal(await served.end("SIGINT"), 0);
  served.clean();
});

test("a walk that is dropped is a map with its walk on it; a robot's map hides the bar until it is asked for", async () => {
  const served = await serve([join(made, "walks/w1.csv")]);
  const person = await Person.at(chromium, served.url, { viewport: { width: 1000, height: 700 }, colorScheme: "dark" });
  const { page } = person;
  await person.ready();
  await page.waitForSelector("#playback:not([hidden])");
  await person.shot("walk-dark");
  await page.keyboard.press("Escape");
  const opened = await page.evaluate(() => window.hitl.model.map);
  await page.evaluate(async (token) => { await fetch("/api/demo", { method: "POST", headers: { "x-hitl-token": token } }); }, new URL(served.url).searchParams.get("token"));
  await page.waitForFunction((n) => window.hitl.model.map > n, opened);
  await page.waitForSelector("#playback", { state: "hidden" });
  await page.click("#layers");
  await page.check("#layer-walks");
  await page.keyboard.press("Escape");
  await page.waitForSelector("#playback:not([hidden])");
  await person.shot("robot-playback");
  assert.deepEqual(person.faults, []);
  await page.context().close();
  assert.equal(await served.end("SIGINT"), 0);
  served.clean();
});
