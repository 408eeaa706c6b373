// What can be switched on over the map. A new layer is one `addLayer` in a file of its own, imported by `layers/all.ts`.

import { changed, model } from "../model";

export interface Layer {
  /** Its name in `model.layers`, and of its tick box (`layer-NAME`). */
  name: string;
  /** Beside the tick box. */
  label: string;
  /** Switched on at the start. */
  on: boolean;
  /** A few words in grey, or with what the layer needs. */
  note?: () => string;
  /** Draws on the overlay, CSS pixels; `poses` (x, y, θ each) are those on screen. Layers are drawn in the order of `addLayer`. */
  draw?: (context: CanvasRenderingContext2D, poses: Float64Array) => void;
  /** Brings what the layer shows; called while it is on: when it is switched on, and whenever the map is another one. */
  bring?: () => Promise<void>;
  /** Controls of its own, under the tick box, in the dialog. */
  controls?: () => HTMLElement[];
}

const layers: Layer[] = [];

export function addLayer(layer: Layer): void {
  layers.push(layer);
  model.layers[layer.name] = layer.on;
}

export const allLayers = (): readonly Layer[] => layers;

/** Switches a layer on or off. */
export function switchLayer(name: string, on: boolean): void {
  model.layers[name] = on;
  changed("layers");
  if (on) void bring(name);
}

/** Everything that is switched on is made to fit the map on screen. */
export function bringAll(): void { for (const { name } of layers) if (model.layers[name]) void bring(name); }

async function bring(name: string): Promise<void> {
  const layer = layers.find((l) => l.name === name);
  if (!layer?.bring) return;
  try { await layer.bring(); changed("layers"); } catch (error) { failed(name, error as Error); }
}

let failed: (name: string, error: Error) => void = () => {};
/** Says what happens to a layer that cannot be had. */
export function onFailure(f: (name: string, error: Error) => void): void { failed = f; }
