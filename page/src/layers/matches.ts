// Automatic factors, those that disagree, and where visits pass each other unmatched.

import type { Point } from "../api";
import { css } from "../dom";
import { matching } from "../matching";
import { changed, model } from "../model";
import { addLayer } from "./registry";

interface Pair { i: number; j: number }
let pointed: Pair | null = null;

/** Lights one up. */
export function point(pair: Pair | null): void {
  if (pointed === pair) return;
  pointed = pair;
  changed("layers");
}

const place = (poses: Float64Array, pose: number): Point => [poses[3 * pose], poses[3 * pose + 1]];

/** The box around two poses, with what is seen from there. */
export function around({ i, j }: Pair, reach = 4): [number, number, number, number] {
  const [[x0, y0], [x1, y1]] = [place(model.now, i), place(model.now, j)];
  return [Math.min(x0, x1) - reach, Math.min(y0, y1) - reach, Math.max(x0, x1) + reach, Math.max(y0, y1) + reach];
}

function draw(context: CanvasRenderingContext2D, poses: Float64Array): void {
  const { view } = model, { factors, near_passes } = matching.closures;
  if (model.comparing) return;
  const lines = (pairs: readonly Pair[], colour: string, width: number, alpha: number) => {
    context.strokeStyle = css(colour);
    context.lineWidth = width;
    context.globalAlpha = alpha;
    context.beginPath();
    for (const { i, j } of pairs) {
      if (3 * j >= poses.length) continue;
      context.moveTo(...view.toScreen(place(poses, i)));
      context.lineTo(...view.toScreen(place(poses, j)));
    }
    context.stroke();
  };
  lines(factors.filter((f) => f.agrees), "--ghost", 1.4, 0.85);
  lines(factors.filter((f) => !f.agrees), "--bad", 2.4, 0.9);
  // A ring where two visits pass; of those that lie over each other only the nearest.
  const taken = new Set<string>();
  context.strokeStyle = css("--warn");
  context.lineWidth = 2;
  context.globalAlpha = 0.9;
  for (const { i, j } of near_passes) {
    if (3 * j >= poses.length) continue;
    const [a, b] = [view.toScreen(place(poses, i)), view.toScreen(place(poses, j))];
    const [x, y] = [(a[0] + b[0]) / 2, (a[1] + b[1]) / 2], cell = `${Math.round(x / 20)},${Math.round(y / 20)}`;
    if (taken.has(cell)) continue;
    taken.add(cell);
    context.beginPath();
    context.arc(x, y, 8, 0, 2 * Math.PI);
    context.stroke();
  }
  if (pointed && 3 * pointed.j < poses.length) {
    const ends = [place(poses, pointed.i), place(poses, pointed.j)].map((p) => view.toScreen(p));
    lines([pointed], "--accent", 3.5, 1);
    context.fillStyle = css("--accent");
    for (const [x, y] of ends) { context.beginPath(); context.arc(x, y, 6, 0, 2 * Math.PI); context.fill(); }
  }
  context.globalAlpha = 1;
}

export function addMatches(): void {
  addLayer({
    name: "matches", label: "Matched by themselves", on: true, draw,
    note: () => { const { factors, near_passes } = matching.closures; return factors.length + near_passes.length ? `${factors.length} matched, ${near_passes.length} near passes` : "none yet"; },
  });
}
