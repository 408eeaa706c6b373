// Which part of the world is on screen. World: metres, y up. Screen: CSS pixels, y down.

import type { Point } from "./api";

export class Viewport {
  x = 0;
  y = 0;
  /** Pixels per metre. */
  scale = 20;
  width = 1;
  height = 1;

  toScreen([x, y]: Point): Point {
    return [this.width / 2 + (x - this.x) * this.scale, this.height / 2 - (y - this.y) * this.scale];
  }

  toWorld([px, py]: Point): Point {
    return [this.x + (px - this.width / 2) / this.scale, this.y - (py - this.height / 2) / this.scale];
  }

  pan(dx: number, dy: number): void {
    this.x -= dx / this.scale;
    this.y += dy / this.scale;
  }

  /** Zooms so that what is under the cursor stays there. */
  zoom(factor: number, at: Point): void {
    const fixed = this.toWorld(at);
    this.scale = Math.min(5000, Math.max(0.05, this.scale * factor));
    const now = this.toWorld(at);
    this.x += fixed[0] - now[0];
    this.y += fixed[1] - now[1];
  }

  /** Shows a box, with room for what lies over the map on each side (pixels: top, right, bottom, left). */
  fit([x0, y0, x1, y1]: [number, number, number, number], [top, right, bottom, left]: [number, number, number, number]): void {
    const width = Math.max(80, this.width - left - right), height = Math.max(80, this.height - top - bottom);
    this.scale = Math.min(400, Math.min(width / Math.max(x1 - x0, 0.5), height / Math.max(y1 - y0, 0.5)) * 0.96);
    this.x = (x0 + x1) / 2 + (right - left) / 2 / this.scale;
    this.y = (y0 + y1) / 2 - (bottom - top) / 2 / this.scale;
  }
}

/** A round length for the scale bar that is about `wanted` pixels long: metres. */
export function roundLength(scale: number, wanted: number): number {
  const metres = wanted / scale;
  const power = 10 ** Math.floor(Math.log10(metres));
  return [5, 2, 1].map((k) => k * power).find((k) => k <= metres) ?? power;
}
