// How certain the poses are: a 1σ ellipse around each, as far as there is room.

import { block, getPacked } from "../api";
import { css, length } from "../dom";
import { model } from "../model";
import { addLayer } from "./registry";

/** Pixels between two ellipses, and below which half an ellipse cannot be seen. */
const APART = 20, SMALLEST = 0.75;
let known = { revision: 0, worst: 0, covariances: new Float32Array(0) };

async function bring(): Promise<void> {
  if (known.revision === model.revision) return;
  const packed = await getPacked<{ revision: number; poses: number; worst_sigma_m: number }>("/api/uncertainty");
  const { revision, poses, worst_sigma_m: worst } = packed.head;
  known = { revision, worst, covariances: block(packed, Float32Array, 3 * poses) };
}

function draw(context: CanvasRenderingContext2D, poses: Float64Array): void {
  if (known.revision !== model.revision || model.comparing) return;
  const { view } = model, { covariances } = known, taken = new Set<string>();
  context.strokeStyle = css("--sigma");
  context.lineWidth = 1.2;
  context.globalAlpha = 0.85;
  context.beginPath();
  for (let i = 0; 3 * i < poses.length; i++) {
    const [x, y] = view.toScreen([poses[3 * i], poses[3 * i + 1]]);
    const [xx, xy, yy] = covariances.subarray(3 * i, 3 * i + 3);
    // Half-axes: the roots of the eigenvalues; the first along `turn`.
    const middle = (xx + yy) / 2, radius = Math.hypot((xx - yy) / 2, xy);
    const [a, b] = [middle + radius, Math.max(0, middle - radius)].map((v) => Math.sqrt(v) * view.scale);
    const cell = `${Math.floor(x / APART)},${Math.floor(y / APART)}`;
    if (a < SMALLEST || x < -a || y < -a || x > view.width + a || y > view.height + a || taken.has(cell)) continue;
    taken.add(cell);
    const turn = -Math.atan2(2 * xy, xx - yy) / 2;
    context.moveTo(x + a * Math.cos(turn), y + a * Math.sin(turn));
    context.ellipse(x, y, a, b, turn, 0, 2 * Math.PI);
  }
  context.stroke();
  context.globalAlpha = 1;
}

export function addEllipses(): void {
  addLayer({
    name: "ellipses", label: "Uncertainty", on: false, draw, bring,
    note: () => (known.revision === model.revision && known.worst > 0 ? `1σ of each pose; the worst ${length(known.worst)}` : "1σ ellipse of each pose, the first one held"),
  });
}
