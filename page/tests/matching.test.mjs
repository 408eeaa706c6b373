// What fits by itself: scans of a raw log, visits after a stroke; what takes long and is given up; what contradicts itself.

import assert from "node:assert/strict";
import { execFileSync } from "node:child_process";
import { createHash } from "node:crypto";
import { copyFileSync, mkdtempSync, readFileSync, writeFileSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { after, before, test } from "node:test";
import { Person, STROKES, browser, demo, distance, done, hitl, killAll, project, serve } from "./browser.mjs";

let chromium;
before(async () => { chromium = await browser(); });
after(async () => { killAll(); await chromium?.close(); });

const ACES = join(project, "data/aces.clf.bz2");
const matched = ({ page }) => page.waitForFunction(() => window.hitl.model.state.matching.is_current && window.hitl.model.state.revision === window.hitl.model.revision, null, { timeout: 60_000 });

test("a raw log begins with its scans matched: that can be given up; then visits are matched, looked at, refused, replayed", async () => {
  const served = await serve();
  const person = await Person.at(chromium, served.url);
  const { page } = person;
  await page.setInputFiles("#file", ACES);
  await page.waitForSelector("#work:not([hidden])");
  await page.waitForFunction(() => /^matching the scans of aces\.clf\.bz2: \d+ %$/.test(document.getElementById("work-text").textContent));
  await person.shot("scans-being-matched");
  await page.click("#cancel");
  await page.waitForSelector("#first-fault:not([hidden])");
  assert.equal(await page.textContent("#first-fault"), "given up: nothing has changed");
  assert.ok(await page.locator("#work").isHidden());
  await page.setInputFiles("#file", ACES);
  await person.ready();
  assert.equal(await person.model((m) => m.state.map.name), "aces-matched.npz");
  assert.match(await person.status(), /Or try Match now \(M\)\.$/);

  const chain = await person.poses();
  await person.shot("scans-matched");
  await person.changes(() => page.keyboard.press("m"));
  await matched(person);
  await page.waitForSelector('[data-section="Agree"]');
  assert.ok(distance(chain, await person.poses()) > 0.3, "loops are closed");
  const { factors } = await person.model((m) => m.state.matching);
  assert.ok(factors > 30, `${factors}`);
  assert.match(await page.textContent("#match-said"), new RegExp(`^${factors} places matched\\.$`));
  await page.click('[data-section="Agree"] summary');
  const scale = await person.model((m) => m.view.scale);
  await page.locator('[data-section="Agree"] li .place').first().click();
  assert.ok((await person.model((m) => m.view.scale)) > 2 * scale, "it is brought near");
  await person.shot("one-match");
  const closed = await person.poses();
  await person.changes(() => page.locator('[data-section="Agree"] li').first().getByRole("button", { name: /^Refuse / }).click());
  await page.waitForSelector('[data-section="Refused by you"]');
  assert.ok((await person.model((m) => m.state.matching.factors)) < factors);
  await page.locator("#overlay").focus();
  await person.changes(() => page.keyboard.press("Control+z"));
  assert.deepEqual(await person.poses(), closed, "undo is exact");

  await page.keyboard.press("f");
  await page.keyboard.press("l");
  await page.check("#layer-ellipses");
  await page.waitForFunction(() => /^1σ of each pose; the worst \d/.test(document.getElementById("note-ellipses").textContent));
  await page.keyboard.press("Escape");
  await person.shot("ellipses");
  await page.keyboard.press("e");
  const [download] = await Promise.all([page.waitForEvent("download"), page.click("[data-format=npz]")]);
  const file = join(served.folder, "by-page.npz");
  await download.saveAs(file);
  execFileSync(hitl, ["replay", "hitl-maps/session.jsonl", "-o", "replayed.npz"], { cwd: served.folder, stdio: "pipe" });
  assert.ok(readFileSync(join(served.folder, "replayed.npz")).equals(readFileSync(file)), "byte for byte");
  await done({ served, person });
});

test("after a stroke the visits are matched while one draws on; it waits for the hand, can be given up, and is undone by itself", async () => {
  const { served, person } = await demo(chromium, { match: true });
  const { page } = person;
  await page.keyboard.press("2");
  for (const stroke of STROKES) await person.draw(stroke);
  await person.previewed();
  await person.changes(() => page.keyboard.press("Enter"));
  const stroked = await person.poses();
  assert.equal(await person.model((m) => m.state.matching.is_current), false, "the stroke's own solve is shown at once");
  await person.draw([[-0.9, -1.5], [-3.4, -1.5]]);
  assert.equal(await person.model((m) => m.strokes.length), 1);
  await page.waitForFunction(() => window.hitl.model.state.works.length === 0 && document.getElementById("match-said").textContent === "matching the visits …", null, { timeout: 60_000 });
  await page.waitForTimeout(300);
  assert.deepEqual(await person.poses(), stroked, "found, but nobody's stroke is torn away");
  assert.equal(await person.model((m) => m.strokes.length), 1);
  await page.keyboard.press("Escape");
  await matched(person);
  assert.match(await page.textContent("#toast"), /places matched by themselves\. Ctrl\+Z takes that back\.$/);
  assert.ok(distance(stroked, await person.poses()) > 0.5);
  await person.shot("one-stroke-and-what-fits");
  const closed = await person.poses();

  await page.keyboard.press("Escape");
  await person.changes(() => page.keyboard.press("Control+z"));
  assert.deepEqual(await person.poses(), stroked, "the matches, and not the stroke");
  await person.changes(() => page.keyboard.press("Control+y"));
  assert.deepEqual(await person.poses(), closed);

  // A change takes the matches that came after it; they are looked for again, and that is given up.
  await person.changes(async () => { await page.locator("#list input[type=number]").fill("2"); await page.keyboard.press("Enter"); });
  await page.waitForFunction(() => /^matching visits: \d+ %$/.test(document.getElementById("work-text").textContent) && !document.getElementById("work").hidden);
  await page.click("#cancel");
  await page.waitForFunction(() => !document.getElementById("match-now").disabled);
  assert.equal(await person.model((m) => m.state.matching.factors), 0);
  await page.uncheck("#match-always");
  await page.reload();
  await person.ready();
  assert.ok(!(await page.isChecked("#match-always")), "the switch is remembered");
  await done({ served, person });
});

test("a correction on the wrong wall is named in the list", async () => {
  const folder = mkdtempSync(join(tmpdir(), "hitl-page-"));
  copyFileSync(ACES, join(folder, "aces.clf.bz2"));
  const sha256 = createHash("sha256").update(readFileSync(ACES)).digest("hex");
  const corrections = readFileSync(join(project, "data/aces.corrections.jsonl"), "utf8").trim().split("\n").map((line) => JSON.parse(line));
  const [east, north] = ["east-junction", "north-junction"].map((id) => corrections.find((c) => c.id === id));
  east.b = north.b;
  const lines = [{ event: "session", version: "0.1.0", map: "aces.clf.bz2", sha256 }, ...corrections.map((c) => ({ event: "correct", at: 1_790_000_000, ...c }))];
  writeFileSync(join(folder, "session.jsonl"), lines.map((line) => `${JSON.stringify(line)}\n`).join(""));
  const served = await serve(["aces.clf.bz2"], folder);
  const person = await Person.at(chromium, served.url);
  const { page } = person;
  await person.ready();
  const row = page.locator('#list li[data-id="east-junction"]');
  assert.match(await row.locator(".why").textContent(), /^contradicts the rest: /);
  assert.ok(await page.locator("#unjudged").isHidden());
  await person.shot("contradiction");
  await person.changes(() => row.locator("input[type=checkbox]").uncheck());
  await page.waitForFunction(() => document.querySelectorAll("#list .why").length === 0);
  await done({ served, person });
});

test("without WebGL, and when the GPU is lost, the CPU draws", async () => {
  const { served, person } = await demo(chromium);
  const without = await browser(["--disable-software-rasterizer"]);
  const by = ({ page }) => page.evaluate(() => window.hitl.drawn().then((frame) => frame.by));
  try {
    const other = await Person.at(without, `${served.url}&gpu=always`);
    await other.ready();
    assert.equal(await by(other), "cpu");
    assert.deepEqual(other.faults, []);
  } finally { await without.close(); }
  const gpu = await Person.at(chromium, `${served.url}&gpu=always`);
  await gpu.ready();
  assert.equal(await by(gpu), "gpu");
  await (await chromium.newBrowserCDPSession()).send("Browser.crashGpuProcess").catch(() => {});
  await gpu.page.waitForFunction(() => window.hitl.drawn().then((frame) => frame.by === "cpu"), null, { timeout: 20_000 });
  await gpu.shot("after-the-gpu-was-lost");
  await gpu.page.context().close();
  await done({ served, person });
});
