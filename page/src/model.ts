// What the page knows, and who wants to hear when it changes.

import type { Ends, Point, State } from "./api";
import { Viewport } from "./viewport";

export interface Caught {
  /** The map that it was drawn on. */
  revision: number;
  drawn: Ends;
  segment: Ends | null;
  points: Uint32Array;
  count: number;
  poses: number;
  reason?: string;
  warning?: string | null;
}

export interface Preview {
  accepted: boolean;
  reason: string | null;
  offset_m: [number | null, number | null];
  angle_rad: [number | null, number | null];
  ms: number;
}

export type Tool = "none" | "colocation" | "collinear" | "parallel" | "perpendicular" | "straighten" | "plan";

export const model = {
  state: null as State | null,
  alive: true,
  /** World poses: as it stands, and as the map came. x, y, θ each. */
  now: new Float64Array(0),
  source: new Float64Array(0),
  /** Number of the map whose points are here, and of the poses. */
  map: 0,
  revision: 0,
  starts: new Uint32Array(1),
  /** The first pose of every walk; a robot's map is one. */
  walks: [0],
  points: new Float32Array(0),
  factors: new Uint32Array(0),
  bounds: [-5, -5, 5, 5] as [number, number, number, number],
  view: new Viewport(),
  /** Which are switched on (layers/registry.ts). */
  layers: { backdrop: true } as Record<string, boolean>,
  tool: "none" as Tool,
  strokes: [] as Caught[],
  /** The stroke that is being drawn. */
  drawing: null as Caught | null,
  /** The keyboard's pen, on screen; null: the mouse draws. */
  pen: null as Point | null,
  preview: null as Preview | null,
  /** The strokes were suggested: the poses that they hang on, and why. */
  suggested: null as { anchors: [number, number]; reason: string } | null,
  busy: false,
  comparing: false,
  hovered: null as string | null,
  paperKeys: localStorage.getItem("paper-keys") === "1",
};

const listeners = new Map<string, (() => void)[]>();
type Topic = "state" | "poses" | "view" | "tool" | "layers" | "theme";

export function on(topics: Topic[], listener: () => void): void {
  for (const topic of topics) listeners.set(topic, [...(listeners.get(topic) ?? []), listener]);
}

export function changed(topic: Topic): void { for (const listener of listeners.get(topic) ?? []) listener(); }

/** The box around the points, from a sample of them. */
export function measureBounds(): void {
  const { starts, points, now } = model;
  const xs: number[] = [], ys: number[] = [];
  const step = Math.max(1, Math.floor(points.length / 2 / 40_000));
  for (let pose = 0; pose + 1 < starts.length; pose++) {
    const [x, y, c, s] = [now[3 * pose], now[3 * pose + 1], Math.cos(now[3 * pose + 2]), Math.sin(now[3 * pose + 2])];
    xs.push(x); ys.push(y);
    for (let k = starts[pose] + (pose % step); k < starts[pose + 1]; k += step) {
      xs.push(x + c * points[2 * k] - s * points[2 * k + 1]);
      ys.push(y + s * points[2 * k] + c * points[2 * k + 1]);
    }
  }
  if (xs.length === 0) return;
  const sorted = (values: number[]) => Float64Array.from(values).sort();
  const [u, v] = [sorted(xs), sorted(ys)];
  // A few returns through a window must not make the map small.
  const low = Math.floor(u.length * 0.001), high = u.length - 1 - low;
  model.bounds = [u[low], v[low], u[high], v[high]];
}
