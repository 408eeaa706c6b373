// Draws the points, away from the page's own thread: a count a pixel, then a colour a count. No GPU is needed; where there
// is one, it draws (gpu.ts).

import { Gpu, hasGpu } from "./gpu";

export interface Layer { poses: string; rgb: [number, number, number]; alpha: number }
export interface Scene {
  /** Bottom to top. */
  layers: Layer[];
  /** Points to light up on top: indices, and where the first layer's poses have them. */
  lit: { indices: Uint32Array; rgb: [number, number, number] }[];
  /** Glides from one set of poses to another: the layer of that name, until the time. */
  glide: { layer: string; from: string; to: string; start: number; ms: number } | null;
  tag: number;
}
export interface View { x: number; y: number; scale: number; width: number; height: number; ratio: number; moving: boolean }
export type ToWorker =
  | { kind: "canvas"; canvas: OffscreenCanvas; gpu: "auto" | "always" | "never" }
  | { kind: "points"; starts: Uint32Array; points: Float32Array }
  | { kind: "poses"; name: string; poses: Float64Array | null }
  | { kind: "view"; view: View }
  | { kind: "scene"; scene: Scene };
export interface Frame { ms: number; tag: number; stride: number; at: number; gliding: boolean; by: "cpu" | "gpu" }

let context: OffscreenCanvasRenderingContext2D | null = null, gpu: Gpu | null = null, canvas: OffscreenCanvas | null = null;
let starts = new Uint32Array(1), points = new Float32Array(0), reach = new Float32Array(0);
const poseSets = new Map<string, Float64Array>();
let view: View = { x: 0, y: 0, scale: 20, width: 1, height: 1, ratio: 1, moving: false };
let scene: Scene = { layers: [], lit: [], glide: null, tag: 0 };
let counts = new Int32Array(0), image: ImageData | null = null;
let scheduled = false, sharpen = 0, msAPoint = 20e-6;

const raf: (f: () => void) => void =
  "requestAnimationFrame" in self ? (f) => void self.requestAnimationFrame(f) : (f) => void setTimeout(f, 16);

function schedule(): void {
  if (scheduled) return;
  scheduled = true;
  raf(() => { scheduled = false; draw(); });
}

self.onmessage = ({ data }: MessageEvent<ToWorker>) => {
  switch (data.kind) {
    case "canvas": take(data.canvas, data.gpu); break;
    case "points": ({ starts, points } = data as { starts: Uint32Array<ArrayBuffer>; points: Float32Array<ArrayBuffer> }); measureReach(); gpu?.points(starts, points); break;
    case "poses": data.poses ? poseSets.set(data.name, data.poses) : poseSets.delete(data.name); gpu?.poses(data.name, data.poses); break;
    case "view": view = data.view; break;
    case "scene": scene = data.scene; break;
  }
  schedule();
};

function take(given: OffscreenCanvas, wanted: "auto" | "always" | "never"): void {
  canvas = given;
  [gpu, context] = [null, null];
  if (wanted === "always" || (wanted === "auto" && hasGpu())) gpu = Gpu.on(given);
  if (gpu) {
    gpu.points(starts, points);
    for (const [name, poses] of poseSets) gpu.poses(name, poses);
    given.addEventListener("webglcontextlost", () => self.postMessage("lost"));
  } else context = given.getContext("2d", { desynchronized: true }) as OffscreenCanvasRenderingContext2D;
}

/** How far each pose's points go: what is off screen is left out as a whole. */
function measureReach(): void {
  reach = new Float32Array(starts.length - 1);
  for (let pose = 0; pose < reach.length; pose++) {
    let most = 0;
    for (let k = starts[pose]; k < starts[pose + 1]; k++) most = Math.max(most, points[2 * k] ** 2 + points[2 * k + 1] ** 2);
    reach[pose] = Math.sqrt(most);
  }
}

function between(a: Float64Array, b: Float64Array, t: number): Float64Array {
  const out = new Float64Array(a.length);
  for (let k = 0; k < a.length; k += 3) {
    out[k] = a[k] + (b[k] - a[k]) * t;
    out[k + 1] = a[k + 1] + (b[k + 1] - a[k + 1]) * t;
    let turn = (b[k + 2] - a[k + 2]) % (2 * Math.PI);
    if (turn > Math.PI) turn -= 2 * Math.PI; else if (turn < -Math.PI) turn += 2 * Math.PI;
    out[k + 2] = a[k + 2] + turn * t;
  }
  return out;
}

/** Adds up the points of one set of poses; every `stride`-th only. */
function count(poses: Float64Array, stride: number): number {
  const { ratio, width, height } = view;
  const w = counts.length ? Math.round(width * ratio) : 0, h = Math.round(height * ratio), s = view.scale * ratio;
  const cx = w / 2 - view.x * s, cy = h / 2 + view.y * s;
  let drawn = 0;
  for (let pose = 0; pose < reach.length; pose++) {
    const x = poses[3 * pose] * s + cx, y = cy - poses[3 * pose + 1] * s, r = reach[pose] * s;
    if (x + r < 0 || y + r < 0 || x - r > w || y - r > h) continue;
    const cos = Math.cos(poses[3 * pose + 2]) * s, sin = Math.sin(poses[3 * pose + 2]) * s;
    const end = starts[pose + 1];
    for (let k = starts[pose] + (pose % stride); k < end; k += stride) {
      const px = points[2 * k], py = points[2 * k + 1];
      const u = (cos * px - sin * py + x) | 0, v = (y - sin * px - cos * py) | 0;
      if (u >= 0 && u < w && v >= 0 && v < h) counts[v * w + u]++;
    }
    drawn += end - starts[pose];
  }
  return drawn;
}

/** Colours by count: light where few points lie, full where many do. */
function table([r, g, b]: [number, number, number], alpha: number, gain: number): Uint32Array {
  const colours = new Uint32Array(64);
  for (let n = 1; n < 64; n++) {
    const share = Math.min(1, 0.42 + 0.58 * Math.log(n * gain) / Math.log(24));
    colours[n] = ((Math.round(255 * Math.max(0.3, share) * alpha) << 24) | (b << 16) | (g << 8) | r) >>> 0;
  }
  return colours;
}

function paint(out: Uint32Array, colours: Uint32Array, size: number, w: number, h: number): void {
  if (size === 1) {
    for (let k = 0; k < out.length; k++) {
      const n = counts[k];
      if (n > 0) out[k] = colours[n > 63 ? 63 : n];
    }
    return;
  }
  for (let v = 0; v < h; v++) {
    for (let u = 0; u < w; u++) {
      const n = counts[v * w + u];
      if (n === 0) continue;
      const colour = colours[n > 63 ? 63 : n];
      for (let dv = 0; dv < size && v + dv < h; dv++) {
        const row = (v + dv) * w;
        for (let du = 0; du < size && u + du < w; du++) if (colour >>> 24 > out[row + u + du] >>> 24) out[row + u + du] = colour;
      }
    }
  }
}

function light(out: Uint32Array, poses: Float64Array, indices: Uint32Array, [r, g, b]: [number, number, number], w: number, h: number): void {
  const s = view.scale * view.ratio, cx = w / 2 - view.x * s, cy = h / 2 + view.y * s;
  const colour = ((255 << 24) | (b << 16) | (g << 8) | r) >>> 0, size = Math.max(2, Math.round(2 * view.ratio));
  let pose = 0;
  for (const k of indices) {
    while (k >= starts[pose + 1]) pose++;
    const theta = poses[3 * pose + 2], px = points[2 * k], py = points[2 * k + 1];
    const u = ((Math.cos(theta) * px - Math.sin(theta) * py + poses[3 * pose]) * s + cx) | 0;
    const v = (cy - (Math.sin(theta) * px + Math.cos(theta) * py + poses[3 * pose + 1]) * s) | 0;
    for (let dv = 0; dv < size; dv++) for (let du = 0; du < size; du++) {
      if (u + du >= 0 && u + du < w && v + dv >= 0 && v + dv < h) out[(v + dv) * w + u + du] = colour;
    }
  }
}

/** The layers as they are now: a gliding one has poses and strength of its own. */
function present(): { layers: { layer: Layer; poses: Float64Array; alpha: number }[]; gliding: boolean } {
  const { glide } = scene;
  const t = glide ? Math.min(1, Math.max(0, (Date.now() - glide.start) / glide.ms)) : 1;
  const layers = [];
  for (const layer of scene.layers) {
    let poses = poseSets.get(layer.poses), alpha = layer.alpha;
    if (glide?.layer === layer.poses) {
      const from = poseSets.get(glide.from), to = poseSets.get(glide.to);
      if (t >= 1 || !from || !to || from.length !== to.length) continue;
      poses = between(from, to, 1 - (1 - t) ** 3);
      alpha *= 1 - t ** 3;
    }
    if (poses?.length === 3 * reach.length) layers.push({ layer, poses, alpha });
  }
  return { layers, gliding: t < 1 };
}

function draw(): void {
  if (!canvas || reach.length === 0) return;
  const begun = performance.now();
  const w = Math.max(1, Math.round(view.width * view.ratio)), h = Math.max(1, Math.round(view.height * view.ratio));
  if (canvas.width !== w || canvas.height !== h) [canvas.width, canvas.height] = [w, h];
  const { layers, gliding } = present();
  const size = (view.scale > 220 ? 3 : view.scale > 70 ? 2 : 1) * Math.max(1, Math.round(view.ratio));
  const stride = gpu ? 1 : byCpu(layers, gliding, size, w, h);
  if (gpu) byGpu(gpu, layers, size, w, h);
  self.postMessage({ ms: performance.now() - begun, tag: scene.tag, stride, at: Date.now(), gliding, by: gpu ? "gpu" : "cpu" } satisfies Frame);
  if (gliding) schedule();
  else if (stride > 1) {
    clearTimeout(sharpen);
    sharpen = setTimeout(() => { view = { ...view, moving: false }; schedule(); }, 140) as unknown as number;
  }
}

function byGpu(gl: Gpu, layers: { layer: Layer; poses: Float64Array; alpha: number }[], size: number, w: number, h: number): void {
  gl.begin(w, h);
  for (const { layer, poses, alpha } of layers) {
    const glides = scene.glide?.layer === layer.poses;
    if (glides) gl.poses("gliding", poses);
    gl.layer(glides ? "gliding" : layer.poses, layer.rgb, alpha, size, view);
  }
  if (layers[0]) for (const { indices, rgb } of scene.lit) gl.light(layers[0].layer.poses, starts, points, indices, rgb, Math.max(2, size), view);
}

/** Draws; returns which share of the points: every n-th. */
function byCpu(layers: { layer: Layer; poses: Float64Array; alpha: number }[], gliding: boolean, size: number, w: number, h: number): number {
  if (!image || image.width !== w || image.height !== h) {
    image = new ImageData(w, h);
    counts = new Int32Array(w * h);
  }
  const begun = performance.now(), out = new Uint32Array(image.data.buffer);
  out.fill(0);
  const whole = (points.length / 2) * Math.max(1, layers.length);
  // While something moves, as many points as 12 ms are good for; all of them when it stands still.
  const stride = view.moving || gliding ? Math.min(16, Math.max(1, Math.ceil((whole * msAPoint) / 12))) : 1;
  let drawn = 0;
  for (const { layer, poses, alpha } of layers) {
    counts.fill(0);
    drawn += count(poses, stride) / stride;
    paint(out, table(layer.rgb, alpha, stride), size, w, h);
  }
  if (layers[0]) for (const { indices, rgb } of scene.lit) light(out, layers[0].poses, indices, rgb, w, h);
  context?.putImageData(image, 0, 0);
  if (drawn > 20_000) msAPoint = 0.8 * msAPoint + 0.2 * ((performance.now() - begun) / drawn);
  return stride;
}
