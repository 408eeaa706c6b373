// The points on screen: tells the worker what to draw.

import { $, rgb } from "./dom";
import { changed, model, on } from "./model";
import type { Frame, Layer, Scene, ToWorker } from "./worker";

declare const WORKER_SOURCE: string;

const worker = new Worker(URL.createObjectURL(new Blob([WORKER_SOURCE], { type: "text/javascript" })));
const tell = (message: ToWorker, transfer: Transferable[] = []) => worker.postMessage(message, transfer);

/** The frames so far, for whoever measures. */
export const frames: Frame[] = [];
const waiting = new Map<number, (frame: Frame) => void>();
let tag = 0, ghost = false, glide: Scene["glide"] = null, stilling = 0;

worker.onmessage = ({ data }: MessageEvent<Frame | "lost">) => {
  if (data === "lost") return give("never");
  frames.push(data);
  if (frames.length > 2000) frames.splice(0, 1000);
  for (const [asked, tell] of waiting) if (asked <= data.tag) { waiting.delete(asked); tell(data); }
  if (glide && !data.gliding && data.at >= glide.start + glide.ms) glide = null;
};

/** Gives the worker a canvas; one that has lost its GPU is of no use any more. */
function give(gpu: "auto" | "always" | "never"): void {
  const old = $<HTMLCanvasElement>("points"), fresh = old.cloneNode() as HTMLCanvasElement;
  old.replaceWith(fresh);
  const canvas = fresh.transferControlToOffscreen();
  tell({ kind: "canvas", canvas, gpu }, [canvas]);
}

export function startRaster(): void {
  const wanted = new URLSearchParams(location.search).get("gpu");
  give(wanted === "always" || wanted === "never" ? wanted : "auto");
  on(["view"], () => sendView(false));
  on(["layers", "tool", "theme", "state"], sendScene);
}

export function sendPoints(): void { tell({ kind: "points", starts: model.starts, points: model.points }); }

/** The map moved from `old` to `model.now`: it is there at once, and the old one glides into it. */
export function sendPoses(old: Float64Array | null): void {
  if (old && old.length === model.now.length) {
    tell({ kind: "poses", name: "old", poses: old });
    glide = { layer: "old", from: "old", to: "now", start: Date.now(), ms: matchMedia("(prefers-reduced-motion: reduce)").matches ? 0 : 450 };
  }
  tell({ kind: "poses", name: "now", poses: model.now });
  tell({ kind: "poses", name: "source", poses: model.source });
  sendScene();
}

export function sendGhost(poses: Float64Array | null): void {
  ghost = poses !== null;
  tell({ kind: "poses", name: "ghost", poses });
  sendScene();
}

export function sendView(moving: boolean): void {
  const { x, y, scale, width, height } = model.view;
  tell({ kind: "view", view: { x, y, scale, width, height, ratio: Math.min(2, devicePixelRatio), moving } });
  clearTimeout(stilling);
  if (moving) stilling = setTimeout(() => sendView(false), 160) as unknown as number;
}

/** The view is on the move: fewer points, for now. */
export function moving(): void { sendView(true); changedOverlay(); }
let changedOverlay = (): void => changed("view");
export function setOverlay(redraw: () => void): void { changedOverlay = redraw; }

export function sendScene(): void {
  const points = rgb("--points"), layers: Layer[] = [];
  if (model.layers.points) {
    if (model.comparing) layers.push({ poses: "source", rgb: points, alpha: 1 });
    else {
      layers.push({ poses: "now", rgb: points, alpha: ghost ? 0.42 : 1 });
      if (ghost) layers.push({ poses: "ghost", rgb: rgb("--ghost"), alpha: 1 });
      if (glide) layers.push({ poses: "old", rgb: rgb("--faint"), alpha: 0.8 });
    }
  }
  const lit = [...model.strokes, ...(model.drawing ? [model.drawing] : [])].map((stroke, k) => ({
    indices: stroke.points,
    rgb: rgb(k === 0 ? "--a" : "--b"),
  }));
  tell({ kind: "scene", scene: { layers, lit: model.comparing ? [] : lit, glide, tag: ++tag } });
}

/** Resolves when what was sent last is on screen. */
export function drawn(): Promise<Frame> { return new Promise((resolve) => { sendScene(); waiting.set(tag, resolve); }); }
