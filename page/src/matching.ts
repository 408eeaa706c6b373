// What fits by itself: after a change of the corrections the server matches the visits with each other, on a copy, while one
// draws on. What it finds is shown once nobody is in the middle of a stroke.

import { Refusal, get, post } from "./api";
import { act, onChange } from "./act";
import { complain, many, toast } from "./dom";
import { changed, model, on } from "./model";

export interface Found { name: string; i: number; j: number; inliers: number; chi2: number; agrees: boolean; weak: boolean }
export interface NearPass { i: number; j: number; distance_m: number; inliers: number }
interface Closures { revision: number; factors: Found[]; near_passes: NearPass[]; refused: { name: string; i: number; j: number }[] }

export const matching = {
  /** After every change of the corrections; kept in the browser. */
  always: localStorage.getItem("match") !== "0",
  running: false,
  closures: { revision: 0, factors: [], near_passes: [], refused: [] } as Closures,
};

export function setAlways(always: boolean): void {
  matching.always = always;
  localStorage.setItem("match", always ? "1" : "0");
  if (always && model.state?.map && !model.state.matching.footprints && !model.state.matching.is_current && model.state.corrections.length > 0) void match();
}

/** Strokes on the way, or a ghost: the map must not change under them. */
const isBusy = (): boolean => model.strokes.length > 0 || model.drawing !== null || model.preview !== null || model.busy;

export async function match(): Promise<void> {
  const revision = model.revision;
  matching.running = true;
  changed("layers");
  try {
    await post("/api/match", { revision });
    await idle();
    // A map that has changed meanwhile was matched again, if it was to be.
    if (model.revision === revision && await act({ event: "match" })) say();
  } catch (error) {
    if (!(error instanceof Refusal && error.status === 409)) complain(error);
  }
  matching.running = false;
  changed("layers");
}

function idle(): Promise<void> {
  if (!isBusy()) return Promise.resolve();
  return new Promise((resolve) => { waiting.push(resolve); });
}
const waiting: (() => void)[] = [];

function say(): void {
  const now = model.state?.matching;
  if (!now) return;
  if (now.withdrawn) toast("What was matched contradicts itself, so none of it is kept: the map is still too bent. Draw more strokes.", true);
  else if (now.factors > 0) toast(`${many(now.factors, "place")} matched by themselves. Ctrl+Z takes that back.`, true);
}

async function bring(): Promise<void> {
  const state = model.state;
  if (!state?.map || matching.closures.revision === model.revision) return;
  const { factors, near_passes, refused } = state.matching;
  if (factors + near_passes + refused === 0) matching.closures = { revision: model.revision, factors: [], near_passes: [], refused: [] };
  else matching.closures = await get<Closures>("/api/closures");
  changed("layers");
}

export function startMatching(): void {
  onChange(() => { if (matching.always && !model.state?.matching.footprints) void match(); });
  on(["tool"], () => { if (!isBusy()) waiting.splice(0).forEach((go) => go()); });
  on(["poses", "state"], () => { if (model.state?.revision === model.revision) bring().catch(complain); });
}
