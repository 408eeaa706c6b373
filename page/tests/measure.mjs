// How fast is the page on a large map without a GPU? `node measure.mjs MAP CORRECTIONS` prints JSON. The corrections are
// those of `hitl simulate`: strokes in the frame of a pose.

import { readFileSync } from "node:fs";
import { resolve } from "node:path";
import { Person, browser, serve } from "./browser.mjs";

const [map, corrections] = process.argv.slice(2).map((path) => resolve(path));
const chromium = await browser();
const viewport = { width: 1600, height: 900 };

const served = await serve([map, "--session", "session.jsonl"]);
const printed = performance.now() - served.started;
const person = await Person.at(chromium, served.url, { viewport });
await person.ready();
await person.page.evaluate(() => window.hitl.drawn());
const ready = performance.now() - served.started;
const { page } = person;
const { poses, points } = await person.model((m) => m.state.map);

/** Frames a second while the mouse does something for two seconds, and how long each took. */
async function frames(act) {
  await page.waitForTimeout(500);
  await page.evaluate(() => { window.hitl.frames.length = 0; });
  const begun = performance.now();
  for (let k = 0; performance.now() - begun < 2000; k++) await act(k);
  const [all, seconds] = [await page.evaluate(() => window.hitl.frames.slice()), (performance.now() - begun) / 1000];
  const ms = all.map((f) => f.ms).sort((a, b) => a - b);
  const gaps = all.slice(1).map((f, k) => f.at - all[k].at).sort((a, b) => a - b);
  return { fps: all.length / seconds, frame_ms: ms[ms.length >> 1], worst_gap_ms: gaps[gaps.length - 1], stride: Math.max(...all.map((f) => f.stride)) };
}

await page.mouse.move(800, 450);
await page.mouse.down();
const pan = await frames((k) => page.mouse.move(800 + 200 * Math.sin(k / 15), 450 + 120 * Math.cos(k / 15)));
await page.mouse.up();
const zoom = await frames((k) => page.mouse.wheel(0, k % 40 < 20 ? -60 : 60));
await page.keyboard.press("f");
await page.waitForTimeout(400);
const still = await page.evaluate(() => window.hitl.drawn());

const rows = [];
for (const line of readFileSync(corrections, "utf8").trim().split("\n")) {
  const { mode, a, b } = JSON.parse(line);
  const strokes = await person.model((m, all) => all.map(({ pose, points }) => points.map(([x, y]) => {
    const [px, py, t] = m.now.slice(3 * pose, 3 * pose + 3);
    return [px + Math.cos(t) * x - Math.sin(t) * y, py + Math.sin(t) * x + Math.cos(t) * y];
  })), [a, b]);
  await page.keyboard.press({ colocation: "1", collinear: "2", parallel: "3", perpendicular: "4" }[mode]);
  for (const stroke of strokes) await person.draw(stroke);
  await person.previewed();
  await page.waitForFunction(() => window.hitl.times.preview > 0);
  const times = await page.evaluate(() => ({ ...window.hitl.times }));
  if (!(await person.model((m) => m.preview.accepted))) throw new Error("a simulated correction was refused");
  await page.waitForTimeout(300);
  await page.evaluate(() => { window.hitl.commitTimes.screen = 0; });
  await person.changes(() => page.keyboard.press("Enter"));
  await page.waitForFunction(() => window.hitl.commitTimes.screen > 0);
  const commit = await page.evaluate(() => ({ ...window.hitl.commitTimes }));
  rows.push({ preview_ms: times.preview, preview_server_ms: times.server, commit_ms: commit.screen, commit_answer_ms: commit.answer, commit_server_ms: commit.server });
  await page.keyboard.press("Escape");
  await page.waitForTimeout(700);
}
if (person.faults.length) throw new Error(person.faults.join("\n"));
await chromium.close();
await served.end("SIGINT");
served.clean();
console.log(JSON.stringify({ poses, points, viewport, printed_ms: printed, ready_ms: ready, pan, zoom, still_ms: still.ms, corrections: rows }, null, 1));
