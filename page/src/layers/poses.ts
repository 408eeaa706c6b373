// Poses as arrows where there is room, as a line of travel where there is none; those of a human factor blue.

import type { Point } from "../api";
import { css, many } from "../dom";
import { model } from "../model";
import { addLayer } from "./registry";

function draw(context: CanvasRenderingContext2D, poses: Float64Array): void {
  const { view } = model;
  const count = poses.length / 3, ink = css("--ink"), blue = css("--accent");
  const hovered = model.state?.corrections.find((c) => c.id === model.hovered);
  const special = new Set((hovered ? [hovered] : model.state?.corrections ?? []).filter((c) => c.enabled).flatMap((c) => c.seen_from?.flat() ?? []));
  const size = Math.min(11, Math.max(3, view.scale * 0.22));
  context.strokeStyle = ink;
  context.globalAlpha = 0.32;
  context.lineWidth = 1;
  context.beginPath();
  let walk = 0;
  for (let i = 0; i < count; i++) {
    const [x, y] = view.toScreen([poses[3 * i], poses[3 * i + 1]]), isFirst = i === model.walks[walk];
    if (isFirst) walk++;
    isFirst ? context.moveTo(x, y) : context.lineTo(x, y);
  }
  context.stroke();
  const arrows = (colour: string, alpha: number, wanted: (i: number) => boolean, gap: number, radius: number) => {
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
  arrows(ink, 0.55, (i) => !special.has(i), size * 2, size * 0.85);
  if (!model.comparing) arrows(blue, 0.95, (i) => special.has(i), hovered ? 1 : 4, size * (hovered ? 1.3 : 1));
}

export function addPoses(): void {
  addLayer({ name: "poses", label: "Poses", on: true, draw, note: () => many(model.state?.map?.poses ?? 0, "pose") });
}
