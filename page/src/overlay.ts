// Everything but the points: poses, factors, strokes, the pen, the scale bar. Drawn on the page's own thread.

import type { Ends, Point } from "./api";
import { drawBackdrop } from "./backdrop";
import { $, css, length } from "./dom";
import { model, on } from "./model";
import { setOverlay } from "./raster";
import { roundLength } from "./viewport";

let context: CanvasRenderingContext2D, ratio = 1, scheduled = false;

export function startOverlay(): void {
  context = $<HTMLCanvasElement>("overlay").getContext("2d")!;
  on(["state", "poses", "view", "tool", "layers", "theme"], redraw);
  setOverlay(redraw);
}

export function redraw(): void {
  if (scheduled) return;
  scheduled = true;
  requestAnimationFrame(() => { scheduled = false; draw(); });
}

function draw(): void {
  const { view, layers } = model;
  const canvas = context.canvas;
  ratio = Math.min(2, devicePixelRatio);
  const [w, h] = [Math.round(view.width * ratio), Math.round(view.height * ratio)];
  if (canvas.width !== w || canvas.height !== h) [canvas.width, canvas.height] = [w, h];
  context.setTransform(ratio, 0, 0, ratio, 0, 0);
  context.clearRect(0, 0, view.width, view.height);
  drawBackdrop(ratio);
  if (!model.state?.map) return;
  context.lineCap = "round";
  if (layers.inconsistency && model.heat) heat();
  const poses = model.comparing ? model.source : model.now;
  if (layers.factors) factors(poses, false);
  if (layers.closures) factors(poses, true);
  if (layers.poses) arrows(poses);
  if (layers.strokes && !model.comparing) corrections();
  model.strokes.forEach((stroke, k) => both(stroke, k));
  if (model.drawing) both(model.drawing, model.strokes.length);
  if (model.pen) pen(model.pen);
  scaleBar();
}

function line([from, to]: Ends): void {
  const [a, b] = [model.view.toScreen(from), model.view.toScreen(to)];
  context.beginPath();
  context.moveTo(...a);
  context.lineTo(...b);
  context.stroke();
}

/** A stroke as drawn, thin, and the wall that it was taken for, thick. */
function both(stroke: { drawn: Ends; segment: Ends | null }, k: number): void {
  const colour = css(k === 0 && model.tool !== "straighten" ? "--a" : "--b");
  context.strokeStyle = colour;
  context.lineWidth = 1.5;
  context.setLineDash(stroke.segment ? [4, 4] : []);
  line(stroke.drawn);
  context.setLineDash([]);
  if (!stroke.segment) return;
  context.lineWidth = 2.5;
  line(stroke.segment);
  for (const end of stroke.segment) dot(model.view.toScreen(end), 5, colour);
}

function dot([x, y]: Point, radius: number, colour: string): void {
  context.fillStyle = colour;
  context.beginPath();
  context.arc(x, y, radius, 0, 2 * Math.PI);
  context.fill();
}

/** The strokes of the corrections; of the one that is looked at in the list, also from where it was seen. */
function corrections(): void {
  for (const c of model.state?.corrections ?? []) {
    if (!c.segments || !c.enabled) continue;
    const hovered = model.hovered === c.id;
    context.globalAlpha = model.hovered === null ? 0.8 : hovered ? 1 : 0.2;
    c.segments.forEach((segment, k) => {
      context.strokeStyle = css(k === 0 ? "--a" : "--b");
      context.lineWidth = hovered ? 5 : 2.5;
      line(segment);
    });
    if (hovered) {
      const [a, b] = c.segments.map(([p, q]): Point => [(p[0] + q[0]) / 2, (p[1] + q[1]) / 2]);
      context.strokeStyle = css("--faint");
      context.lineWidth = 1;
      context.setLineDash([3, 5]);
      line([a, b]);
      context.setLineDash([]);
    }
  }
  context.globalAlpha = 1;
}

/** Poses as arrows where there is room, as a line of travel where there is none; those of a human factor blue. */
function arrows(poses: Float64Array): void {
  const { view } = model;
  const count = poses.length / 3, ink = css("--ink"), blue = css("--accent");
  const hovered = model.state?.corrections.find((c) => c.id === model.hovered);
  const special = new Set((hovered ? [hovered] : model.state?.corrections ?? []).filter((c) => c.enabled).flatMap((c) => c.seen_from?.flat() ?? []));
  const size = Math.min(11, Math.max(3, view.scale * 0.22));
  context.strokeStyle = ink;
  context.globalAlpha = 0.32;
  context.lineWidth = 1;
  context.beginPath();
  for (let i = 0; i < count; i++) {
    const [x, y] = view.toScreen([poses[3 * i], poses[3 * i + 1]]);
    i === 0 ? context.moveTo(x, y) : context.lineTo(x, y);
  }
  context.stroke();
  const draw = (colour: string, alpha: number, wanted: (i: number) => boolean, gap: number, radius: number) => {
    context.fillStyle = colour;
    context.globalAlpha = alpha;
    context.beginPath();
    let last: Point = [-1e9, -1e9];
    for (let i = 0; i < count; i++) {
      if (!wanted(i)) continue;
      const at = view.toScreen([poses[3 * i], poses[3 * i + 1]]);
      if (at[0] < -20 || at[1] < -20 || at[0] > view.width + 20 || at[1] > view.height + 20) continue;
      if (Math.hypot(at[0] - last[0], at[1] - last[1]) < gap) continue;
      last = at;
      const c = Math.cos(poses[3 * i + 2]) * radius, s = -Math.sin(poses[3 * i + 2]) * radius;
      context.moveTo(at[0] + c, at[1] + s);
      context.lineTo(at[0] - 0.7 * c - 0.55 * s, at[1] - 0.7 * s + 0.55 * c);
      context.lineTo(at[0] - 0.7 * c + 0.55 * s, at[1] - 0.7 * s - 0.55 * c);
      context.closePath();
    }
    context.fill();
    context.globalAlpha = 1;
  };
  draw(ink, 0.55, (i) => !special.has(i), size * 2, size * 0.85);
  if (!model.comparing) draw(blue, 0.95, (i) => special.has(i), hovered ? 1 : 4, size * (hovered ? 1.3 : 1));
}

/** Lines between the poses of relative factors: along the chain, or closures. */
function factors(poses: Float64Array, closures: boolean): void {
  context.strokeStyle = css(closures ? "--ghost" : "--faint");
  context.lineWidth = closures ? 1.2 : 1;
  context.globalAlpha = 0.7;
  context.beginPath();
  const { factors: pairs, view } = model;
  for (let k = 0; k < pairs.length; k += 2) {
    const [i, j] = [pairs[k], pairs[k + 1]];
    if ((Math.abs(i - j) !== 1) !== closures) continue;
    context.moveTo(...view.toScreen([poses[3 * i], poses[3 * i + 1]]));
    context.lineTo(...view.toScreen([poses[3 * j], poses[3 * j + 1]]));
  }
  context.stroke();
  context.globalAlpha = 1;
}

/** Cells that contradict each other; the worst hundredth is solid, what is common is faint. */
function heat(): void {
  const { cells, resolution } = model.heat!, { view } = model;
  const size = Math.max(1, resolution * view.scale);
  const counts = Float32Array.from({ length: cells.length / 3 }, (_, k) => cells[3 * k + 2]).sort();
  const worst = Math.log2(1 + (counts[Math.floor(counts.length * 0.99)] ?? 1));
  context.fillStyle = css("--bad");
  for (let level = 0; level < 4; level++) {
    context.globalAlpha = [0.06, 0.2, 0.45, 0.9][level];
    for (let k = 0; k < cells.length; k += 3) {
      if (Math.min(3, Math.floor((4 * Math.log2(1 + cells[k + 2])) / worst)) !== level) continue;
      const [x, y] = view.toScreen([cells[k], cells[k + 1]]);
      if (x > -9 && y > -9 && x < view.width + 9 && y < view.height + 9) context.fillRect(x - size / 2, y - size / 2, size, size);
    }
  }
  context.globalAlpha = 1;
}

function pen([x, y]: Point): void {
  context.strokeStyle = css("--accent");
  context.lineWidth = 1.5;
  context.beginPath();
  context.moveTo(x - 12, y); context.lineTo(x + 12, y);
  context.moveTo(x, y - 12); context.lineTo(x, y + 12);
  context.stroke();
}

function scaleBar(): void {
  const metres = roundLength(model.view.scale, 130);
  const bar = $("scale");
  (bar.firstElementChild as HTMLElement).style.width = `${metres * model.view.scale}px`;
  bar.lastElementChild!.textContent = length(metres).replace(".00 m", " m").replace(".0 cm", " cm");
}
