// Everything that changes the map, and the poses that come back.

import { block, getPacked, postPacked, type Packed } from "./api";
import { complain } from "./dom";
import { changed, model } from "./model";
import { drawn, sendPoints, sendPoses } from "./raster";

export const commitTimes = { asked: 0, answer: 0, screen: 0, server: 0 };

/** The poses of an answer become the map on screen. */
export function takePoses(packed: Packed<{ revision: number; poses: number; server_ms: number }>): void {
  const old = model.now;
  model.now = block(packed, Float64Array, 3 * packed.head.poses);
  model.revision = packed.head.revision;
  sendPoses(old);
  changed("poses");
  commitTimes.server = packed.head.server_ms;
  commitTimes.answer = performance.now() - commitTimes.asked;
  void drawn().then(() => { commitTimes.screen = performance.now() - commitTimes.asked; });
}

/** What changes what the visits can be matched by. */
const CHANGES = ["enable", "reweight", "delete", "settings", "allow"];
let heard: () => void = () => {};
/** Hears of every change of the corrections that was made here. */
export function onChange(f: () => void): void { heard = f; }
export function changedCorrections(): void { heard(); }

let queue: Promise<boolean> = Promise.resolve(true);

/** Lets an event happen, after all that were asked for before; true if it did. */
export function act(event: Record<string, unknown>): Promise<boolean> {
  queue = queue.then(() => carryOut(event));
  return queue;
}

async function carryOut(event: Record<string, unknown>): Promise<boolean> {
  commitTimes.asked = performance.now();
  try {
    const turns = event["event"] === "straighten" || event["event"] === "undo" || event["event"] === "redo";
    takePoses(await postPacked("/api/act", { ...event, revision: model.revision }));
    if (turns) await fetchPoses();
    if (CHANGES.includes(String(event["event"]))) heard();
    return true;
  } catch (error) {
    complain(error);
    return false;
  }
}

let fetching = false;

/** Brings points and poses up to what the server says it shows. */
export async function follow(): Promise<void> {
  const state = model.state;
  if (!state?.map || fetching || (model.map === state.map.number && model.revision === state.revision)) return;
  fetching = true;
  try {
    if (model.map !== state.map.number) await fetchMap();
    else await fetchPoses();
  } catch (error) { complain(error); }
  fetching = false;
  // It may have changed meanwhile.
  if (model.state && (model.map !== model.state.map?.number || model.revision !== model.state.revision)) setTimeout(() => void follow(), 100);
}

async function fetchMap(): Promise<void> {
  const [points, factors] = await Promise.all([
    getPacked<{ map: number; points: number; starts: number; walks: number[] }>("/api/points"),
    getPacked<{ factors: number }>("/api/factors"),
  ]);
  model.starts = block(points, Uint32Array, points.head.starts);
  model.walks = points.head.walks;
  model.points = block(points, Float32Array, 2 * points.head.points);
  model.factors = block(factors, Uint32Array, 2 * factors.head.factors);
  model.now = new Float64Array(0);
  sendPoints();
  await fetchPoses();
  model.map = points.head.map;
  changed("state");
}

async function fetchPoses(): Promise<void> {
  const packed = await getPacked<{ revision: number; poses: number }>("/api/poses");
  const old = model.now, isNew = packed.head.revision !== model.revision;
  model.now = block(packed, Float64Array, 3 * packed.head.poses);
  model.source = block(packed, Float64Array, 3 * packed.head.poses);
  model.revision = packed.head.revision;
  sendPoses(isNew && old.length === model.now.length ? old : null);
  changed("poses");
}
