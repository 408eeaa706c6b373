// Relative factors: along the path, and the closures that the map came with.

import { css, many } from "../dom";
import { model } from "../model";
import { addLayer } from "./registry";

function lines(context: CanvasRenderingContext2D, poses: Float64Array, closures: boolean): void {
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

export function addFactors(): void {
  addLayer({ name: "factors", label: "Relative factors along the path", on: false, draw: (c, p) => lines(c, p, false) });
  addLayer({
    name: "closures", label: "Closures that the map came with", on: true, draw: (c, p) => lines(c, p, true),
    note: () => { const n = model.state?.map?.closures ?? 0; return n ? many(n, "closure") : "none in this map"; },
  });
}
