// Everything but the points: the layers, what is being drawn, the pen, the scale bar. Drawn on the page's own thread.

import type { Ends, Point } from "./api";
import { drawBackdrop } from "./backdrop";
import { $, css, length } from "./dom";
import { model, on } from "./model";
import { allLayers } from "./layers/registry";
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
  const { view } = model;
  const canvas = context.canvas;
  ratio = Math.min(2, devicePixelRatio);
  const [w, h] = [Math.round(view.width * ratio), Math.round(view.height * ratio)];
  if (canvas.width !== w || canvas.height !== h) [canvas.width, canvas.height] = [w, h];
  context.setTransform(ratio, 0, 0, ratio, 0, 0);
  context.clearRect(0, 0, view.width, view.height);
  drawBackdrop(ratio);
  if (!model.state?.map) return;
  context.lineCap = "round";
  const poses = model.comparing ? model.source : model.now;
  for (const { name, draw } of allLayers()) if (draw && model.layers[name]) draw(context, poses);
  model.strokes.forEach((stroke, k) => both(stroke, k));
  if (model.drawing) both(model.drawing, model.strokes.length);
  if (model.pen) pen(model.pen);
  scaleBar();
}

export function line([from, to]: Ends): void {
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
