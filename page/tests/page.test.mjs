// The page as a person uses it, in a real browser, on the program as built. `npm test`; HITL_SHOTS=DIR keeps pictures.

import assert from "node:assert/strict";
import { execFileSync } from "node:child_process";
import { existsSync, readFileSync, statSync, writeFileSync } from "node:fs";
import { join } from "node:path";
import { after, before, test } from "node:test";
import { Person, STROKES, browser, demo as openDemo, distance, done, hitl, killAll, project, serve } from "./browser.mjs";

let chromium;
before(async () => { chromium = await browser(); });
// Also after a failure: a server that is left running would keep the tests from ending.
after(async () => { killAll(); await chromium?.close(); });

const demo = (options) => openDemo(chromium, options);

test("where next: a suggestion is drawn to be looked at, dropped, asked for again, applied; it can be given up", async () => {
  const { served, person } = await demo();
  const { page } = person;
  const suggested = () => page.waitForFunction(() => window.hitl.model.suggested && window.hitl.model.preview?.accepted, null, { timeout: 60_000 });
  const original = await person.poses();
  // Given up from within the page, as soon as it says what it does: the search may take less time than it takes to ask from outside.
  const said = page.evaluate(() => new Promise((done) => {
    const work = document.getElementById("work");
    new MutationObserver((_, observer) => {
      if (work.hidden) return;
      observer.disconnect();
      done(document.getElementById("work-text").textContent);
      document.getElementById("cancel").click();
    }).observe(work, { attributeFilter: ["hidden"] });
  }));
  await page.click("#suggest");
  assert.equal(await said, "looking where a stroke would help …");
  await page.waitForFunction(() => !document.getElementById("suggest").disabled);
  assert.equal(await person.model((m) => m.strokes.length), 0, "given up");

  await page.locator("#overlay").focus();
  await page.keyboard.press("w");
  await suggested();
  await person.shot("where-next");
  assert.match(await page.textContent("#preview-text"), /Suggested: .+ poses? \d+/);
  assert.match(await person.status(), /^Is this one wall\? .+ Enter applies it, Esc drops it\.$/);
  assert.deepEqual(await person.poses(), original, "a suggestion changes nothing");
  await page.keyboard.press("Escape");
  assert.deepEqual(await person.model((m) => [m.tool, m.strokes.length, m.suggested]), ["none", 0, null]);

  await page.keyboard.press("w");
  await suggested();
  const { anchors } = await person.model((m) => m.suggested);
  await person.changes(() => page.keyboard.press("Enter"));
  assert.ok(distance(original, await person.poses()) > 0.5, "the map has changed");
  const [correction] = await person.corrections();
  assert.ok(correction.seen_from.every((poses, k) => poses.some((p) => Math.abs(p - anchors[k]) < 10)), "the walls that were meant are tied");
  await person.shot("where-next-applied");
  await page.locator("#overlay").focus();
  await person.changes(() => page.keyboard.press("Control+z"));
  assert.deepEqual(await person.poses(), original, "undo is exact");
  await done({ served, person });
});

test("from the demo to a corrected map: draw, look, apply, undo, redo, switch off, reweight, delete, resume", async () => {
  const { served, person } = await demo();
  const { page } = person;
  assert.match(await person.status(), /^The corridor in the east is there twice/);
  await person.shot("open");
  await page.keyboard.press("2");
  assert.match(await person.status(), /^Drag along a wall: the first stroke\./);
  await person.draw(STROKES[0], async () => {
    await page.waitForFunction(() => window.hitl.model.drawing?.count > 500);
    assert.match(await person.status(), /^[\d,]+ points from \d+ poses/);
    await person.shot("first-stroke");
  });
  assert.match(await person.status(), /the second stroke\.$/);
  await person.draw(STROKES[1]);
  await person.previewed();
  assert.match(await person.status(), /^The ghost is the corrected map\. Enter applies it/);
  assert.match(await page.textContent("#preview-text"), /^offset 12\.1\d m → < 1 mm/);
  const original = await person.poses();
  assert.equal((await person.corrections()).length, 0, "a preview changes nothing");
  await person.shot("preview");
  await person.changes(() => page.keyboard.press("Enter"));
  const corrected = await person.poses();
  assert.ok(distance(original, corrected) > 5, "the map has changed");
  const [first] = await person.corrections();
  assert.ok(first.offset_before_m > 12 && first.offset_m < 0.01, "the walls are on one line");
  assert.equal(await page.locator("#list li").count(), 1);
  await person.shot("corrected");

  await page.keyboard.press("Escape");
  await person.changes(() => page.keyboard.press("Control+z"));
  assert.deepEqual(await person.poses(), original, "undo is exact");
  assert.equal(await page.locator("#list li").count(), 0);
  await person.changes(() => page.keyboard.press("Control+y"));
  assert.deepEqual(await person.poses(), corrected, "so is redo");
  await person.changes(() => page.locator("#list input[type=checkbox]").uncheck());
  assert.deepEqual(await person.poses(), original, "switched off");
  await person.shot("switched-off");
  await person.changes(() => page.locator("#list input[type=checkbox]").check());
  await person.changes(async () => {
    await page.locator("#list input[type=number]").fill("0.01");
    await page.keyboard.press("Enter");
  });
  assert.equal((await person.corrections())[0].weight, 0.01);
  assert.ok(distance(await person.poses(), corrected) > 1e-6, "a weight pulls");
  await person.changes(() => page.keyboard.press("Control+z"));
  assert.deepEqual(await person.poses(), corrected);

  await page.reload();
  await person.ready();
  assert.deepEqual(await person.poses(), corrected, "a reload shows what was there");
  await person.page.context().close();
  await served.end("SIGKILL");
  const again = await serve([join("hitl-maps", "aces.clf.bz2")], served.folder);
  const back = await Person.at(chromium, again.url);
  await back.ready();
  assert.deepEqual(await back.poses(), corrected, "killed and started again: nothing is lost");
  await back.changes(() => back.page.getByRole("button", { name: "Delete c1" }).click());
  assert.deepEqual(await back.poses(), original, "deleted");
  await back.changes(() => back.page.click("#undo"));
  assert.deepEqual(await back.poses(), corrected);
  // As fast as fingers go: every one counts.
  const undone = await back.model((m) => m.state.summary.events);
  for (let k = 0; k < 3; k++) await back.page.keyboard.press("Control+z");
  for (let k = 0; k < 3; k++) await back.page.keyboard.press("Control+y");
  await back.page.waitForFunction((n) => window.hitl.model.state.summary.events === n + 6, undone);
  await back.page.waitForFunction(() => window.hitl.model.revision === window.hitl.model.state.revision);
  assert.ok(await back.page.locator("#toast").isHidden());
  // Strokes are of the map that they were drawn on.
  await back.page.keyboard.press("2");
  await back.draw([[-0.9, -1.5], [-3.4, -1.5]]);
  await back.changes(() => back.page.keyboard.press("Control+z"));
  await back.page.waitForFunction(() => window.hitl.model.strokes.length === 0);
  assert.match(await back.page.textContent("#toast"), /^The map has changed meanwhile/);
  await done({ served: again, person: back });
});

test("every export arrives as a file, and a replay of the session is the map on screen", async () => {
  const { served, person } = await demo();
  const { page } = person;
  await page.keyboard.press("2");
  for (const stroke of STROKES) await person.draw(stroke);
  await person.previewed();
  await person.changes(() => page.click("#commit"));
  await page.keyboard.press("Escape");
  await page.keyboard.press("e");
  await person.shot("export");
  const files = {};
  for (const format of await page.locator("[data-format]").evaluateAll((all) => all.map((b) => b.dataset.format))) {
    const [download] = await Promise.all([page.waitForEvent("download"), page.click(`[data-format=${format}]`)]);
    files[format] = join(served.folder, download.suggestedFilename());
    await download.saveAs(files[format]);
    assert.ok(statSync(files[format]).size > 100, format);
  }
  assert.equal(Object.keys(files).length, 10);
  const run = (...args) => execFileSync(hitl, args, { cwd: served.folder, encoding: "utf8", stdio: ["ignore", "pipe", "pipe"] });
  for (const format of ["npz", "g2o", "toro", "stfs", "tum", "clf"]) assert.match(run("info", files[format]), /poses|scans/, format);
  run("replay", files.session, "-o", "replayed.npz", "--map", join("hitl-maps", "aces.clf.bz2"));
  assert.ok(readFileSync(join(served.folder, "replayed.npz")).equals(readFileSync(files.npz)), "byte for byte");
  run("correct", join("hitl-maps", "aces.clf.bz2"), "-c", files.corrections, "--no-reassociate", "-o", "corrected.npz");
  assert.ok(readFileSync(join(served.folder, "corrected.npz")).equals(readFileSync(files.npz)), "byte for byte");
  await page.getByText("Summary of this session").click();
  await page.waitForSelector("#summary-picture:not([hidden])");
  await page.waitForFunction(() => document.getElementById("panel-body").textContent.includes("inconsistency"), null, { timeout: 60_000 });
  assert.match(await page.textContent("#panel-body"), /1correction/);
  await person.shot("summary");
  await done({ served, person });
});

test("without a mouse: keys draw, apply, compare and straighten", async () => {
  const { served, person } = await demo();
  const { page } = person;
  const original = await person.poses();
  /** Moves the pen to a place in the world and sets an end there. */
  const set = async (point) => {
    const to = await person.at(point);
    await page.keyboard.press("ArrowRight");
    for (const [axis, keys] of [[0, ["ArrowLeft", "ArrowRight"]], [1, ["ArrowUp", "ArrowDown"]]]) {
      let gap = Math.round(to[axis] - (await person.model((m, a) => m.pen[a], axis)));
      for (const [modifier, step] of [["Shift+", 60], ["", 10], ["Alt+", 1]]) {
        for (; Math.abs(gap) >= step; gap -= Math.sign(gap) * step) await page.keyboard.press(modifier + keys[gap > 0 ? 1 : 0]);
      }
    }
    await page.keyboard.press("Space");
  };
  await page.keyboard.press("f");
  await page.keyboard.press("2");
  for (let k = 0; k < 2; k++) {
    await set(STROKES[k][0]);
    await page.waitForFunction(() => window.hitl.model.drawing);
    if (k === 0) { await page.keyboard.press("ArrowLeft"); await person.shot("keyboard"); }
    await set(STROKES[k][1]);
    await page.waitForFunction((n) => window.hitl.model.strokes.length === n, k + 1);
  }
  await person.previewed();
  await person.changes(() => page.keyboard.press("Enter"));
  assert.equal((await person.corrections()).length, 1);
  assert.ok(await page.locator("#toast").isHidden(), "nothing to complain of");
  await page.keyboard.press("Escape");
  await page.keyboard.down("b");
  assert.match(await person.status(), /^The map as it came/);
  assert.equal(await person.model((m) => m.comparing), true);
  await person.shot("before-held");
  await page.keyboard.up("b");
  assert.equal(await person.model((m) => m.comparing), false);
  const heading = (p) => p[2];
  const bent = await person.poses();
  await page.keyboard.press("5");
  await set([-2.4, -1.5]);
  await page.waitForFunction(() => window.hitl.model.drawing);
  await person.changes(() => set([-0.9, -1.5]));
  assert.notEqual(heading(await person.poses()), heading(bent), "turned as a whole");
  await person.changes(() => page.keyboard.press("Control+z"));
  await person.changes(() => page.keyboard.press("Control+z"));
  assert.deepEqual(await person.poses(), original);
  await page.keyboard.press("?");
  assert.ok(await page.getByText("undo, redo, without end").isVisible());
  await done({ served, person });
});

test("what cannot be: a bad file, a stroke on nothing, a correction that is refused", async () => {
  const served = await serve();
  const person = await Person.at(chromium, served.url);
  const { page } = person;
  await person.shot("first-screen");
  const bad = join(served.folder, "holiday.jpg");
  writeFileSync(bad, "no map at all\n");
  await page.setInputFiles("#file", bad);
  await page.waitForSelector("#first-fault:not([hidden])");
  assert.match(await page.textContent("#first-fault"), /^holiday\.jpg/);
  await person.shot("bad-file");
  await page.check("#start-odometry");
  await page.setInputFiles("#file", join(project, "data/aces.clf.bz2"));
  await person.ready();
  assert.ok(existsSync(join(served.folder, "hitl-maps/session.jsonl")));
  await page.keyboard.press("3");
  await person.draw([[20, 20], [22, 20]]);
  assert.match(await page.textContent("#toast"), /^Nothing caught: .*Draw again/);
  await person.draw(STROKES[0]);
  await page.keyboard.press("Escape");
  assert.equal(await person.model((m) => m.strokes.length), 0, "Esc takes the stroke back");
  await page.keyboard.press("Escape");
  assert.equal(await person.model((m) => m.tool), "none");
  await page.click("#menu");
  await page.click("#open-other");
  await page.setInputFiles("#file", bad);
  await page.waitForSelector("#first-fault:not([hidden])");
  await page.click("#first-back");
  assert.equal(await person.model((m) => m.state.map.name), "aces.clf.bz2", "what was open stays");
  await done({ served, person });
});

test("a second window follows live, and a narrow one has everything", async () => {
  const { served, person } = await demo();
  const other = await Person.at(chromium, served.url, { viewport: { width: 400, height: 760 }, colorScheme: "dark" });
  await other.ready();
  await person.page.keyboard.press("2");
  for (const stroke of STROKES) await person.draw(stroke);
  await person.previewed();
  await other.changes(() => person.page.keyboard.press("Enter"));
  assert.deepEqual(await other.poses(), await person.poses());
  assert.match(await other.page.textContent("#list-toggle"), /1/);
  await other.shot("narrow");
  await other.page.click("#list-toggle");
  assert.equal(await other.page.locator("#list li").count(), 1);
  await other.shot("narrow-list");
  for (const id of ["mode-colocation", "mode-straighten", "undo", "redo", "export", "layers", "list-toggle"]) {
    const box = await other.page.locator(`#${id}`).boundingBox();
    assert.ok(box && box.x >= 0 && box.x + box.width <= 400 && box.y + box.height <= 760, `#${id} is on the screen`);
  }
  await person.changes(() => other.page.click("#undo"));
  assert.equal((await person.corrections()).length, 0, "both ways");
  await other.page.context().close();
  await done({ served, person });
});

test("layers, solver, cross-check, colours", async () => {
  const { served, person } = await demo({ viewport: { width: 1280, height: 800 }, colorScheme: "dark" });
  const { page } = person;
  await page.keyboard.press("2");
  for (const stroke of STROKES) await person.draw(stroke);
  await person.previewed();
  await person.shot("preview-dark");
  await person.changes(() => page.keyboard.press("Enter"));
  await page.keyboard.press("Escape");
  await page.hover("#list li");
  await person.shot("corrected-dark");
  await page.keyboard.press("l");
  await page.check("#layer-inconsistency");
  await page.waitForFunction(() => / m²$/.test(document.getElementById("note-inconsistency")?.textContent ?? ""), null, { timeout: 60_000 });
  await page.check("#layer-factors");
  const plan = join(served.folder, "plan.pgm");
  writeFileSync(plan, Buffer.concat([Buffer.from("P5\n# plan\n40 30\n255\n"), Buffer.alloc(1200, 205)]));
  writeFileSync(join(served.folder, "plan.yaml"), "image: plan.pgm\nresolution: 1.0\norigin: [-30.0, -20.0, 0.0]\nnegate: 0\n");
  await page.setInputFiles("#backdrop-file", [plan, join(served.folder, "plan.yaml")]);
  await page.waitForFunction(() => document.getElementById("layer-backdrop"));
  await page.keyboard.press("Escape");
  await person.shot("layers-dark");
  await page.click("#more");
  if (await page.locator("#set-solver option[value=ceres]").isEnabled()) {
    await page.click("#crosscheck");
    await page.getByText("The two solvers agree.").waitFor();
    await person.shot("crosscheck");
    const before = await person.poses();
    await person.changes(() => page.selectOption("#set-solver", "ceres"));
    assert.ok(distance(before, await person.poses()) < 1e-6);
  }
  await done({ served, person });
});

test("the paper's keys", async () => {
  const { served, person } = await demo();
  const { page } = person;
  await page.click("#more");
  await page.check("#paper-keys");
  await page.keyboard.press("Escape");
  await page.locator("#overlay").focus();
  await page.keyboard.press("p");
  await page.keyboard.down("Shift");
  for (const stroke of STROKES) await person.draw(stroke);
  await page.keyboard.up("Shift");
  await person.previewed();
  await person.changes(() => page.keyboard.press("p"));
  assert.deepEqual((await person.corrections()).map((c) => c.mode), ["collinear"]);
  await done({ served, person });
});

test("a GPU draws the same picture as the CPU", async () => {
  const { served, person } = await demo();
  // Software WebGL here: slow, and the same program.
  const other = await Person.at(chromium, `${served.url}&gpu=always`);
  await other.ready();
  assert.equal(await other.page.evaluate(() => window.hitl.frames.at(-1).by), "gpu");
  assert.equal(await person.page.evaluate(() => window.hitl.frames.at(-1).by), "cpu");
  const picture = async ({ page }) => {
    await page.evaluate(() => { for (const id of ["overlay", "bar", "side", "status", "scale"]) document.getElementById(id).style.visibility = "hidden"; });
    await page.waitForTimeout(400);
    return [...(await page.screenshot())];
  };
  /** Of the pixels that are lit in one, the share with a lit one next to it in the other. */
  const alike = await person.page.evaluate(async (pictures) => {
    const lit = await Promise.all(pictures.map(async (bytes) => {
      const image = await createImageBitmap(new Blob([new Uint8Array(bytes)]));
      const context = new OffscreenCanvas(image.width, image.height).getContext("2d");
      context.drawImage(image, 0, 0);
      const { data, width, height } = context.getImageData(0, 0, image.width, image.height);
      return { width, height, at: Uint8Array.from({ length: width * height }, (_, k) => Number(data[4 * k] - data[4 * k + 2] > 60)) };
    }));
    const share = (p, q) => {
      let [all, met] = [0, 0];
      for (let y = 1; y < p.height - 1; y++) for (let x = 1; x < p.width - 1; x++) {
        if (!p.at[y * p.width + x]) continue;
        all++;
        let near = 0;
        for (const dy of [-1, 0, 1]) for (const dx of [-1, 0, 1]) near |= q.at[(y + dy) * p.width + x + dx];
        met += near;
      }
      return [all, met / all];
    };
    return [share(lit[0], lit[1]), share(lit[1], lit[0])];
  }, [await picture(person), await picture(other)]);
  for (const [all, share] of alike) assert.ok(all > 5000 && share > 0.97, JSON.stringify(alike));
  assert.deepEqual(other.faults, []);
  await other.page.context().close();
  await done({ served, person });
});
