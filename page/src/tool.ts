// Correcting: which relation, stroke a, stroke b, look, apply. And straightening, which needs one stroke.

import { Refusal, block, postPacked, type Ends, type Mode, type Point } from "./api";
import { act, changedCorrections, takePoses } from "./act";
import { $, complain, el, icon, length, angle, toast } from "./dom";
import { changed, model, on, type Caught, type Preview, type Tool } from "./model";
import { drawn, sendGhost } from "./raster";
import { planPoint } from "./panels";

export const MODES: { mode: Mode | "straighten"; name: string; key: string; tip: string }[] = [
  { mode: "colocation", name: "Same place", key: "1", tip: "Colocation: the same wall, and the same place along it (1)" },
  { mode: "collinear", name: "Same line", key: "2", tip: "Collinear: both on one line, free to slide along it (2)" },
  { mode: "parallel", name: "Parallel", key: "3", tip: "Parallel: the same direction (3)" },
  { mode: "perpendicular", name: "Right angle", key: "4", tip: "Perpendicular: at a right angle (4)" },
  { mode: "straighten", name: "Straighten", key: "5", tip: "Turn the map so that a wall lies along an axis: one stroke (5)" },
];

let asking = false, again: Ends | null = null, previewing: AbortController | null = null;
export const times = { release: 0, preview: 0, server: 0 };

export function startTool(): void {
  for (const { mode, name, key, tip } of MODES) {
    const button = el("button", { id: `mode-${mode}`, "aria-pressed": "false", "data-tip": tip, "aria-keyshortcuts": key, onclick: () => choose(mode) }, icon(mode), el("span", {}, name), el("kbd", {}, key));
    $("modes").append(button);
  }
  $("commit").onclick = () => void commit();
  $("discard").onclick = back;
  $<HTMLInputElement>("weight").onchange = () => void preview();
  on(["tool", "state"], show);
  on(["poses"], outdated);
}

export function choose(tool: Tool): void {
  if (!model.state?.map) return;
  const same = model.tool === tool;
  reset();
  model.tool = same ? "none" : tool;
  changed("tool");
  $("overlay").focus();
}

function reset(): void {
  previewing?.abort();
  Object.assign(model, { strokes: [], drawing: null, preview: null, suggested: null, busy: false, pen: null });
  $<HTMLInputElement>("weight").value = "1";
  sendGhost(null);
}

/** Of a suggestion the person takes all or nothing. */
function drop(): void {
  reset();
  model.tool = "none";
}

/** Esc: one step back. */
export function back(): void {
  if (model.drawing) model.drawing = null;
  else if (model.preview || model.busy || model.strokes.length) {
    previewing?.abort();
    model.busy = false;
    model.preview = null;
    if (model.suggested) drop(); else model.strokes.pop();
    sendGhost(null);
  } else if (model.pen) model.pen = null;
  else { reset(); model.tool = "none"; }
  changed("tool");
}

/** Strokes mean nothing on a map that they were not drawn on. */
function outdated(): void {
  const all = model.drawing ? [...model.strokes, model.drawing] : model.strokes;
  if (all.every((stroke) => stroke.revision === model.revision)) return;
  forget();
  toast("The map has changed meanwhile: draw the strokes again.");
}

/** Another map is on screen: what was drawn on the old one is gone. */
export function forget(): void { if (model.strokes.length || model.drawing || model.preview) { reset(); changed("tool"); } }

export const drawsNow = (): boolean => model.tool !== "none" && model.tool !== "plan" && !model.preview && !model.busy && model.strokes.length < 2;

export function begin(at: Point): void {
  if (model.tool === "plan") return planPoint(at);
  if (!drawsNow()) return;
  model.drawing = { revision: model.revision, drawn: [at, at], segment: null, points: new Uint32Array(0), count: 0, poses: 0 };
  changed("tool");
}

export function drag(at: Point): void {
  if (!model.drawing) return;
  model.drawing.drawn = [model.drawing.drawn[0], at];
  changed("tool");
  if (pixels(model.drawing.drawn) >= SHORTEST) void look(model.drawing.drawn);
}

/** A shorter drag is a click, pixels. */
const SHORTEST = 5;

/** Asks what the stroke catches; of many questions only the last waits. */
async function look(drawn: Ends): Promise<void> {
  if (asking) { again = drawn; return; }
  asking = true;
  try {
    const caught = await ask(drawn);
    if (model.drawing) { model.drawing = { ...caught, drawn: model.drawing.drawn }; changed("tool"); }
  } catch (error) { complain(error); }
  asking = false;
  const next = again;
  again = null;
  if (next && model.drawing) void look(next);
}

type CaughtHead = { segment?: Ends; count: number; poses?: number; reason?: string; warning?: string | null };

async function ask(drawn: Ends): Promise<Caught> {
  const revision = model.revision;
  const packed = await postPacked<CaughtHead>("/api/catch", { stroke: drawn, revision });
  const { segment = null, count, poses = 0, reason, warning } = packed.head;
  return { revision, drawn, segment, count, poses, reason, warning, points: block(packed, Uint32Array, count) };
}

const pixels = ([p, q]: Ends): number => Math.hypot(p[0] - q[0], p[1] - q[1]) * model.view.scale;

export async function release(at: Point): Promise<void> {
  if (!model.drawing) return;
  const drawn: Ends = [model.drawing.drawn[0], at];
  Object.assign(times, { release: performance.now(), preview: 0 });
  if (pixels(drawn) < SHORTEST) { model.drawing = null; changed("tool"); return; }
  try {
    if (model.tool === "straighten") {
      model.drawing = null;
      reset();
      model.tool = "none";
      changed("tool");
      await act({ event: "straighten", stroke: drawn });
      return;
    }
    if (model.strokes.length === 1) {
      // What the second stroke catches comes with the ghost.
      model.strokes = [...model.strokes, { ...model.drawing, drawn }];
      model.drawing = null;
      await preview();
      return;
    }
    const caught = await ask(drawn);
    // Esc while it was asked for: the stroke is not wanted.
    if (!model.drawing) return;
    model.drawing = null;
    if (caught.reason) { changed("tool"); nothing(caught.reason); return; }
    model.strokes = [...model.strokes, caught];
    changed("tool");
  } catch (error) {
    model.drawing = null;
    changed("tool");
    complain(error);
  }
}

type PreviewHead = Omit<Preview, "ms"> & { poses: number; server_ms: number; b: CaughtHead };

function nothing(reason: string): void { toast(`Nothing caught: ${reason}. Draw again, along a wall.`); }

const asked = () => ({ mode: model.tool, a: model.strokes[0].drawn, b: model.strokes[1].drawn, weight: Number($<HTMLInputElement>("weight").value) || 1, anchors: model.suggested?.anchors, revision: model.strokes[0].revision });

/** Strokes that nobody drew, as if they had been: then the person looks. */
export async function propose(what: { mode: Mode; strokes: [Ends, Ends]; anchors: [number, number]; weight: number; reason: string }): Promise<void> {
  reset();
  const [a, b] = what.strokes, caught = await ask(a);
  model.tool = what.mode;
  model.strokes = [caught, { ...caught, drawn: b, segment: null, points: new Uint32Array(0), count: 0, poses: 0, warning: null }];
  model.suggested = { anchors: what.anchors, reason: what.reason };
  $<HTMLInputElement>("weight").value = String(what.weight);
  await preview();
}

export async function preview(): Promise<void> {
  previewing?.abort();
  const mine = (previewing = new AbortController());
  model.busy = true;
  model.preview = null;
  changed("tool");
  try {
    const packed = await postPacked<PreviewHead>("/api/preview", asked(), mine.signal);
    if (mine.signal.aborted) return;
    model.busy = false;
    const { poses, server_ms, b } = packed.head;
    if (b.reason) {
      if (model.suggested) drop(); else model.strokes = model.strokes.slice(0, 1);
      changed("tool");
      nothing(b.reason);
      return;
    }
    const ghost = poses ? block(packed, Float64Array, 3 * poses) : null;
    const { segment = null, count, warning } = b;
    model.strokes = [model.strokes[0], { ...model.strokes[1], segment, count, warning, poses: b.poses ?? 0, points: block(packed, Uint32Array, count) }];
    model.preview = { ...packed.head, ms: server_ms };
    sendGhost(ghost);
    changed("tool");
    times.server = server_ms;
    void drawn().then(() => { times.preview = performance.now() - times.release; });
  } catch (error) {
    if (mine.signal.aborted) return;
    model.busy = false;
    if (model.suggested) drop(); else model.strokes.pop();
    changed("tool");
    complain(error);
  }
}

export async function commit(): Promise<void> {
  if (!model.preview?.accepted || model.busy) return;
  model.busy = true;
  changed("tool");
  try {
    const packed = await postPacked<{ revision: number; poses: number; server_ms: number }>("/api/commit", asked());
    // The same relation again is the likeliest next thing.
    if (model.suggested) drop(); else reset();
    takePoses(packed);
    changed("tool");
    changedCorrections();
  } catch (error) {
    model.busy = false;
    if (error instanceof Refusal && error.status === 409) reset();
    changed("tool");
    complain(error);
  }
}

/** The status line: always the next step. */
function show(): void {
  const { tool, strokes, drawing, preview: seen, state } = model;
  for (const { mode } of MODES) $(`mode-${mode}`).setAttribute("aria-pressed", String(tool === mode));
  $("overlay").classList.toggle("drawing", tool !== "none");
  $("status").hidden = !state?.map;
  $("preview").hidden = !seen;
  $("legend").hidden = !seen?.accepted;
  if (!state?.map) return;
  const k = strokes.length, name = () => el("b", { class: k === 0 ? "a" : "b" }, k === 0 ? "first stroke" : "second stroke");
  const step = $("step");
  const say = (...parts: (Node | string)[]) => step.replaceChildren(...parts);
  if (!model.alive) say(el("b", { class: "bad" }, "hitl serve has ended. "), "All is saved; start it again, and reload.");
  else if (model.comparing) say("The map as it came. Let go to see it corrected.");
  else if (tool === "none") {
    say(state.corrections.length === 0 && state.map.name === "aces.clf.bz2"
      ? "The corridor in the east is there twice. Pick Same line (2), then draw along a wall of each."
      : state.corrections.length === 0
      ? state.matching.is_current && !state.matching.withdrawn ? "Is a wall there twice? Pick how its two parts relate: keys 1 to 4. All well? Export."
        : `Find a wall that is there twice, then pick how its two parts relate: keys 1 to 4.${state.matching.withdrawn || state.matching.footprints ? "" : " Or try Match now (M)."}`
      : "Keys 1 to 4: the next correction. W: where next? Hold B: before. Done? Export.");
  } else if (tool === "plan") say(planStep());
  else if (tool === "straighten") say(drawing ? "Let go: the map turns until this wall lies along an axis." : "Draw along one wall: the map turns until it lies along an axis.");
  else if (drawing) {
    const parts: (Node | string)[] = [];
    if (drawing.segment) parts.push(`${drawing.count.toLocaleString("en")} points from ${drawing.poses} poses`);
    else parts.push(drawing.reason ? `nothing yet: ${drawing.reason}` : "along the wall …");
    if (drawing.warning) parts.push(" · ", el("span", { class: "warn" }, drawing.warning));
    say(...parts);
  } else if (model.busy) say("Working out what the map would be …");
  else if (seen && !seen.accepted) say(el("span", { class: "bad" }, "This cannot be applied. "), "Esc: draw the second stroke again.");
  else if (seen) {
    const warning = strokes[1]?.warning;
    say(...(warning ? [el("span", { class: "warn" }, `Second stroke: ${warning}. `)] : []), model.suggested ? `${tool === "parallel" || tool === "perpendicular" ? "Do these two walls lie like that" : "Is this one wall"}? The ghost is the map if so: Enter applies it, Esc drops it.` : "The ghost is the corrected map. Enter applies it, Esc draws again.");
  }
  else {
    const warning = strokes[k - 1]?.warning;
    if (warning) say(el("span", { class: "warn" }, `${warning}. `), "Esc: again. Or draw the ", name(), " …");
    else if (model.pen) say("Arrows move the pen, Space sets the ends of the ", name(), ".");
    else say("Drag along ", k === 0 ? "a wall: the " : tool === "perpendicular" ? "the wall at a right angle to it: the " : tool === "parallel" ? "the wall parallel to it: the " : "its double: the ", name(), ".", k === 0 ? " Wheel zooms, Space+drag pans." : "");
  }
  if (seen) {
    const text = $("preview-text");
    if (!seen.accepted) text.textContent = seen.reason ?? "";
    else {
      const part = (what: string, [before, after]: [number | null, number | null], f: (v: number) => string) => before === null || after === null ? [] : [`${what} ${f(before)} → `, el("b", {}, f(after))];
      const [o, a] = [part("offset", seen.offset_m, length), part("angle", seen.angle_rad, angle)];
      const why = model.suggested ? [el("span", { class: "faint why" }, `Suggested: ${model.suggested.reason}.`)] : [];
      text.replaceChildren(...o, ...(o.length && a.length ? [" · "] : []), ...a, ...why);
    }
    $<HTMLButtonElement>("commit").disabled = !seen.accepted || model.busy;
    $("preview-weight").hidden = !seen.accepted;
  }
}

let planStep = (): string => "";
export function setPlanStep(f: () => string): void { planStep = f; }
