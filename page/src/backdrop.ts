// An existing map under the points: PGM + YAML (it knows where it lies), or any picture (which is put there by hand).

import type { Point } from "./api";
import { $ } from "./dom";
import { changed, model } from "./model";

/** Where the picture lies: lower left corner in the world, metres a pixel, turn. */
export interface Place { x: number; y: number; metres: number; turn: number }

export const backdrop = { image: null as ImageBitmap | null, name: "", place: { x: 0, y: 0, metres: 0.05, turn: 0 } as Place, opacity: 0.6 };

function pgm(bytes: Uint8Array): ImageData {
  let at = 0;
  const word = (): string => {
    for (;;) {
      while (at < bytes.length && bytes[at] <= 32) at++;
      if (bytes[at] !== 35) break;
      while (at < bytes.length && bytes[at] !== 10) at++;
    }
    const from = at;
    while (at < bytes.length && bytes[at] > 32) at++;
    return new TextDecoder().decode(bytes.subarray(from, at));
  };
  const magic = word(), width = Number(word()), height = Number(word()), most = Number(word());
  if (!["P5", "P2"].includes(magic) || !(width > 0 && height > 0 && width * height < 4e8 && most > 0 && most < 65536)) {
    throw new Error("found a damaged PGM, expected P5 or P2 with width, height and depth");
  }
  at++;
  const wide = most > 255 ? 2 : 1;
  if (magic === "P5" && bytes.length - at < width * height * wide) throw new Error("found a cut-off PGM, expected more pixels");
  const image = new ImageData(width, height);
  for (let k = 0; k < width * height; k++) {
    const value = magic === "P2" ? Number(word()) : wide === 2 ? bytes[at + 2 * k] * 256 + bytes[at + 2 * k + 1] : bytes[at + k];
    image.data.fill((255 * value) / most, 4 * k, 4 * k + 3);
    image.data[4 * k + 3] = 255;
  }
  return image;
}

/** Reads what was chosen: a picture, with its YAML if it has one. */
export async function openBackdrop(files: File[]): Promise<void> {
  const yaml = files.find((f) => /\.ya?ml$/i.test(f.name));
  const picture = files.find((f) => f !== yaml);
  if (!picture) throw new Error("found a YAML alone, expected its picture too: choose both files");
  const bytes = new Uint8Array(await picture.arrayBuffer());
  const isPgm = bytes[0] === 80 && (bytes[1] === 53 || bytes[1] === 50);
  let image: ImageBitmap;
  try {
    image = await createImageBitmap(isPgm ? pgm(bytes) : picture);
  } catch (error) {
    throw new Error(`${picture.name}: ${isPgm ? (error as Error).message : "found no picture that this browser reads, expected PGM, PNG, JPEG or SVG"}`);
  }
  const [x0, y0, x1, y1] = model.bounds;
  const place: Place = { x: x0, y: y0, metres: Math.max((x1 - x0) / image.width, (y1 - y0) / image.height), turn: 0 };
  if (yaml) {
    const text = await yaml.text();
    const resolution = Number(/^\s*resolution:\s*([^\s#]+)/m.exec(text)?.[1]);
    const origin = /^\s*origin:\s*\[([^\]]+)\]/m.exec(text)?.[1].split(",").map(Number);
    if (!(resolution > 0) || !origin || origin.length < 2 || origin.some((v) => !Number.isFinite(v))) {
      throw new Error(`${yaml.name}: found no resolution and origin, expected a map server's YAML`);
    }
    Object.assign(place, { x: origin[0], y: origin[1], metres: resolution, turn: origin[2] ?? 0 });
  }
  Object.assign(backdrop, { image, place, name: picture.name });
  model.layers.backdrop = true;
  changed("layers");
}

export function toImage([x, y]: Point): Point {
  const { place } = backdrop, c = Math.cos(place.turn), s = Math.sin(place.turn);
  const [u, v] = [(x - place.x) / place.metres, (y - place.y) / place.metres];
  return [c * u + s * v, c * v - s * u];
}

/** Lays the picture so that two of its points (pixels, y up) come to lie on two of the map's. */
export function align([p1, p2]: Point[], [q1, q2]: Point[]): void {
  const [pu, pv, qu, qv] = [p2[0] - p1[0], p2[1] - p1[1], q2[0] - q1[0], q2[1] - q1[1]];
  const metres = Math.hypot(qu, qv) / Math.hypot(pu, pv), turn = Math.atan2(qv, qu) - Math.atan2(pv, pu);
  if (!Number.isFinite(metres) || metres === 0) throw new Error("found the same point twice, expected two different ones");
  const [c, s] = [Math.cos(turn) * metres, Math.sin(turn) * metres];
  backdrop.place = { metres, turn, x: q1[0] - (c * p1[0] - s * p1[1]), y: q1[1] - (s * p1[0] + c * p1[1]) };
  changed("layers");
}

export function drawBackdrop(ratio: number): void {
  const canvas = $<HTMLCanvasElement>("backdrop"), context = canvas.getContext("2d")!, { view } = model;
  const { image, place, opacity } = backdrop;
  if (!image && canvas.width === 1) return;
  [canvas.width, canvas.height] = image ? [Math.round(view.width * ratio), Math.round(view.height * ratio)] : [1, 1];
  if (!image || !model.layers.backdrop || !model.state?.map) return;
  const [x, y] = view.toScreen([place.x, place.y]), size = place.metres * view.scale;
  const [c, s] = [Math.cos(place.turn) * size, Math.sin(place.turn) * size];
  context.globalAlpha = opacity;
  context.imageSmoothingEnabled = size < 1;
  // From the picture's pixels (y down, from its upper left corner) to the screen.
  context.setTransform(c * ratio, -s * ratio, s * ratio, c * ratio, (x - s * image.height) * ratio, (y - c * image.height) * ratio);
  context.drawImage(image, 0, 0);
}
