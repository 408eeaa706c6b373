// Where the map contradicts itself: seen free from one pose, a wall from another.

import { block, postPacked } from "../api";
import { css } from "../dom";
import { model } from "../model";
import { addLayer } from "./registry";

interface Heat { cells: Float32Array; resolution: number; area: number; revision: number }
let heat: Heat | null = null, asked = 0;

const current = (): boolean => heat !== null && heat.revision === model.revision;

async function bring(): Promise<void> {
  if (current() || asked === model.revision) return;
  const revision = (asked = model.revision);
  try {
    const packed = await postPacked<{ inconsistency_m2: number; resolution_m: number; cells: number }>("/api/inconsistency", {});
    const { cells, resolution_m, inconsistency_m2 } = packed.head;
    heat = { cells: block(packed, Float32Array, 3 * cells), resolution: resolution_m, area: inconsistency_m2, revision };
  } finally { if (asked === revision) asked = 0; }
}

/** Cells that contradict each other; the worst hundredth is solid, what is common is faint. */
function draw(context: CanvasRenderingContext2D): void {
  if (!heat || !current() || model.comparing) return;
  const { cells, resolution } = heat, { view } = model;
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

export function addHeat(): void {
  addLayer({
    name: "inconsistency", label: "Inconsistency", on: false, bring, draw,
    note: () => (heat && current() ? `${heat.area.toFixed(1)} m²` : "seen free from one pose, a wall from another"),
  });
}
