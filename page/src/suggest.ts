// Where next: the server looks where a stroke would help most, and its two strokes are drawn as if by hand, to be looked at.

import { Refusal, post, type Ends, type Mode } from "./api";
import { $, complain, toast } from "./dom";
import { showBox } from "./input";
import { model, on } from "./model";
import { propose } from "./tool";

interface Suggestion { mode: Mode; weight: number; strokes: [Ends, Ends]; anchors: [number, number]; reason: string }

/** So much of the map is shown around the strokes, metres. */
const AROUND = 6;
let running = false;

export function startSuggest(): void {
  $("suggest").onclick = () => void suggest();
  on(["state", "tool"], show);
}

/** What the person has begun is not taken away. */
const isDrawing = (): boolean => model.drawing !== null || model.strokes.length > 0;

function show(): void {
  $<HTMLButtonElement>("suggest").disabled = running || model.busy || isDrawing() || !model.state?.map || model.state.matching.footprints;
}

export async function suggest(): Promise<void> {
  const revision = model.revision;
  running = true;
  show();
  try {
    const { suggestion } = await post<{ suggestion: Suggestion | null }>("/api/suggest", { revision });
    if (model.revision !== revision || isDrawing()) return;
    if (!suggestion) { toast("Nothing that its own scans can tell is visibly wrong.", true); return; }
    const { mode, strokes, anchors, weight, reason } = suggestion;
    const [xs, ys] = [0, 1].map((k) => strokes.flat().map((p) => p[k]));
    showBox([Math.min(...xs) - AROUND, Math.min(...ys) - AROUND, Math.max(...xs) + AROUND, Math.max(...ys) + AROUND]);
    await propose({ mode, strokes, anchors, weight, reason });
  } catch (error) {
    if (!(error instanceof Refusal && error.status === 409)) complain(error);
  } finally {
    running = false;
    show();
  }
}
