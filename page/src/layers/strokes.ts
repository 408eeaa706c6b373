// The strokes of the corrections; of the one that is looked at in the list, also what belongs together.

import type { Point } from "../api";
import { css } from "../dom";
import { model } from "../model";
import { line } from "../overlay";
import { addLayer } from "./registry";

function draw(context: CanvasRenderingContext2D): void {
  if (model.comparing) return;
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

export function addStrokes(): void {
  addLayer({ name: "strokes", label: "Corrections", on: true, draw, note: () => "red: earlier, blue: later" });
}
