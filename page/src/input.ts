// Mouse, touch and keys on the map.

import { act, commitTimes } from "./act";
import type { Point } from "./api";
import { $ } from "./dom";
import { changed, measureBounds, model } from "./model";
import { moving } from "./raster";
import { keys, openExports, openLayers } from "./panels";
import { back, begin, choose, commit, drag, drawsNow, MODES, release } from "./tool";

let space = false, paper = false;

export function fit(): void {
  measureBounds();
  showBox(model.bounds);
}

/** Brings a box of the world on screen, between what lies over the map. */
export function showBox(box: [number, number, number, number]): void {
  const side = $("side"), narrow = innerWidth <= 720;
  const right = side.hidden || narrow ? 24 : 316;
  model.view.fit(box, [$("bar").offsetHeight + 28, right, narrow && !side.hidden ? innerHeight * 0.38 + 56 : 112, 24]);
  changed("view");
}

export function startInput(): void {
  const overlay = $<HTMLCanvasElement>("overlay");
  const held = new Map<number, Point>();
  let panning = false;

  overlay.addEventListener("pointerdown", (e) => {
    overlay.focus();
    overlay.setPointerCapture(e.pointerId);
    held.set(e.pointerId, [e.offsetX, e.offsetY]);
    if (held.size === 2) { model.drawing = null; panning = true; changed("tool"); return; }
    const draws = e.button === 0 && !space && (model.tool === "plan" || drawsNow() || (paper && paperMode(e)));
    panning = !draws;
    overlay.classList.toggle("grabbing", panning);
    if (draws) { model.pen = null; begin(model.view.toWorld([e.offsetX, e.offsetY])); }
  });
  overlay.addEventListener("pointermove", (e) => {
    const last = held.get(e.pointerId), at: Point = [e.offsetX, e.offsetY];
    if (!last) return;
    if (held.size === 2) {
      const other = [...held].find(([id]) => id !== e.pointerId)![1];
      const [was, is] = [last, at].map((p) => Math.hypot(p[0] - other[0], p[1] - other[1]));
      model.view.zoom(is / Math.max(1, was), [(at[0] + other[0]) / 2, (at[1] + other[1]) / 2]);
      model.view.pan((at[0] - last[0]) / 2, (at[1] - last[1]) / 2);
      moving();
    } else if (panning) { model.view.pan(at[0] - last[0], at[1] - last[1]); moving(); }
    else drag(model.view.toWorld(at));
    held.set(e.pointerId, at);
  });
  const up = (e: PointerEvent) => {
    if (!held.delete(e.pointerId)) return;
    overlay.classList.remove("grabbing");
    if (!panning) void release(model.view.toWorld([e.offsetX, e.offsetY]));
    if (held.size === 0) panning = false;
  };
  overlay.addEventListener("pointerup", up);
  overlay.addEventListener("pointercancel", (e) => { held.delete(e.pointerId); model.drawing = null; changed("tool"); });
  overlay.addEventListener("contextmenu", (e) => e.preventDefault());
  overlay.addEventListener("wheel", (e) => {
    e.preventDefault();
    const pixels = e.deltaY * (e.deltaMode === 1 ? 24 : e.deltaMode === 2 ? 240 : 1);
    model.view.zoom(Math.exp(-Math.max(-240, Math.min(240, pixels)) * 0.0022), [e.offsetX, e.offsetY]);
    moving();
  }, { passive: false });

  const compare = (on: boolean) => { if (model.comparing !== on) { model.comparing = on; changed("tool"); changed("view"); } };
  const button = $("compare");
  button.addEventListener("pointerdown", () => compare(true));
  for (const end of ["pointerup", "pointerleave", "pointercancel"]) button.addEventListener(end, () => compare(false));
  $("undo").onclick = () => void act({ event: "undo" });
  $("redo").onclick = () => void act({ event: "redo" });
  $("fit").onclick = fit;
  window.addEventListener("keydown", (e) => { if (key(e, compare)) e.preventDefault(); });
  window.addEventListener("keyup", (e) => {
    if (e.key === " ") space = false;
    if (e.key.toLowerCase() === "b") compare(false);
  });
  window.addEventListener("blur", () => { space = false; compare(false); });
}

/** The paper's keys: the held keys say how the strokes relate. */
function paperMode(e: PointerEvent): boolean {
  const mode = e.shiftKey ? (e.altKey ? "perpendicular" : e.ctrlKey ? "parallel" : "collinear") : e.ctrlKey ? "colocation" : null;
  if (!mode || model.strokes.length >= 2) return false;
  if (model.tool !== mode) { model.strokes = []; model.tool = mode; }
  return true;
}

/** True if the key was for us. */
function key(e: KeyboardEvent, compare: (on: boolean) => void): boolean {
  const target = e.target as HTMLElement;
  if (!model.state?.map || !$("first").hidden || $<HTMLDialogElement>("panel").open) return false;
  if (target.matches("input, select, textarea") && !(target as HTMLInputElement).matches("[type=checkbox]")) {
    if (e.key === "Enter" || e.key === "Escape") { target.blur(); $("overlay").focus(); }
    return false;
  }
  const onMap = target === document.body || target.id === "overlay";
  if (e.ctrlKey || e.metaKey) {
    const letter = e.key.toLowerCase();
    if (letter === "z") { void act({ event: e.shiftKey ? "redo" : "undo" }); return true; }
    if (letter === "y") { void act({ event: "redo" }); return true; }
    return false;
  }
  if (model.paperKeys && e.key.toLowerCase() === "p") {
    if (paper && model.preview?.accepted) commitNow();
    else if (paper && model.tool !== "none") choose(model.tool);
    paper = !paper;
    $("overlay").classList.toggle("drawing", paper || model.tool !== "none");
    return true;
  }
  const mode = MODES.find((m) => m.key === e.key);
  if (mode) { choose(mode.mode); return true; }
  switch (e.key) {
    case "Escape": back(); return true;
    case "Enter": if (!model.preview || (!onMap && target.id !== "commit")) return onMap && pen(e); commitNow(); return true;
    case " ": if (!onMap) return false; if (model.pen) return pen(e); space = true; return true;
    case "+": case "=": model.view.zoom(1.25, model.pen ?? middle()); moving(); return true;
    case "-": model.view.zoom(0.8, model.pen ?? middle()); moving(); return true;
    case "?": keys(); return true;
    case "ArrowLeft": case "ArrowRight": case "ArrowUp": case "ArrowDown": return onMap && arrow(e);
  }
  if (e.altKey || e.shiftKey) return false;
  switch (e.key.toLowerCase()) {
    case "b": compare(true); return true;
    case "f": fit(); return true;
    case "m": if (!$<HTMLButtonElement>("match-now").disabled) $("match-now").click(); return true;
    case "w": if (!$<HTMLButtonElement>("suggest").disabled) $("suggest").click(); return true;
    case "l": openLayers(); return true;
    case "e": openExports(); return true;
  }
  return false;
}

function commitNow(): void { commitTimes.asked = performance.now(); void commit(); }
const middle = (): Point => [model.view.width / 2, model.view.height / 2];

/** Space or Enter: the pen sets the ends of a stroke. */
function pen(_: KeyboardEvent): boolean {
  if (!model.pen || model.preview || model.busy) return false;
  const at = model.view.toWorld(model.pen);
  if (model.drawing) void release(at); else begin(at);
  return true;
}

function arrow(e: KeyboardEvent): boolean {
  const step = e.shiftKey ? 60 : e.altKey ? 1 : 10;
  const [dx, dy] = [e.key === "ArrowLeft" ? -step : e.key === "ArrowRight" ? step : 0, e.key === "ArrowUp" ? -step : e.key === "ArrowDown" ? step : 0];
  if (model.tool === "none" || model.tool === "plan" || model.preview) { model.view.pan(-3 * dx, -3 * dy); moving(); return true; }
  const [x, y] = model.pen ?? middle();
  model.pen = [Math.min(model.view.width - 4, Math.max(4, x + dx)), Math.min(model.view.height - 4, Math.max(4, y + dy))];
  if (model.drawing) drag(model.view.toWorld(model.pen));
  changed("tool");
  return true;
}
