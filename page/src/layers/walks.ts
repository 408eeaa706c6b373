// Where walkers (or the robot) went, with playback; how often, as hexagons; and the walls of a floor plan beside the map.

import { block, getPacked, type Point } from "../api";
import { css, el, many } from "../dom";
import { changed, model, on } from "../model";
import { addLayer, switchLayer } from "./registry";

interface Head {
  map: number; revision: number; scans: number; walks: number[];
  hexagons: number; hex_radius_m: number; hex_angle_rad: number; walls: number; remark: string | null;
}
interface Walks {
  head: Head;
  /** Seconds, pose and offset from it of every scan, walk after walk. */
  stamps: Float64Array; parents: Uint32Array; offsets: Float32Array;
  /** Centre x, y and crossings; x1, y1, x2, y2. */
  hexagons: Float32Array; walls: Float32Array;
}

const SHOWN = ["walks", "hexagons", "walls"];
/** A walk is played in this time at most, seconds; shorter ones as fast as they were. */
const LONGEST_SHOW_S = 30;
const COLOURS = ["--a", "--b", "--accent", "--good", "--bad", "--ink"];

let walks: Walks | null = null, asked = 0;
/** Time that is shown, seconds after the first scan; null: everything. */
let shown: number | null = null, playing = 0, before = 0;
let bar: HTMLElement, slider: HTMLInputElement, button: HTMLButtonElement, clock: HTMLElement;

const current = (): boolean => walks !== null && walks.head.map === model.map;

async function bring(): Promise<void> {
  if ((current() && walks!.head.revision === model.revision) || asked === model.revision) return;
  const revision = (asked = model.revision);
  try {
    const packed = await getPacked<Head>("/api/walks");
    const { scans, hexagons, walls } = packed.head;
    const next: Walks = {
      head: packed.head, stamps: block(packed, Float64Array, scans), parents: block(packed, Uint32Array, scans),
      offsets: block(packed, Float32Array, 2 * scans), hexagons: block(packed, Float32Array, 3 * hexagons), walls: block(packed, Float32Array, 4 * walls),
    };
    if (walks?.head.map !== next.head.map) pause(null);
    walks = next;
    if (packed.head.remark) throw new Error(packed.head.remark);
  } finally { if (asked === revision) asked = 0; place(); }
}

function span(): [number, number] {
  let low = Infinity, high = -Infinity;
  for (const stamp of walks?.stamps ?? []) { if (stamp < low) low = stamp; if (stamp > high) high = stamp; }
  return low <= high ? [low, high] : [0, 0];
}

/** A scan on the poses that are on screen. */
function at(poses: Float64Array, k: number): Point {
  const { parents, offsets } = walks!;
  const p = 3 * parents[k], c = Math.cos(poses[p + 2]), s = Math.sin(poses[p + 2]);
  return model.view.toScreen([poses[p] + c * offsets[2 * k] - s * offsets[2 * k + 1], poses[p + 1] + s * offsets[2 * k] + c * offsets[2 * k + 1]]);
}

function drawWalks(context: CanvasRenderingContext2D, poses: Float64Array): void {
  if (!current()) return;
  const { head, stamps } = walks!;
  const until = shown === null ? Infinity : span()[0] + shown;
  let first = 0;
  head.walks.forEach((count, number) => {
    const colour = css(COLOURS[number % COLOURS.length]), last = first + count;
    let now = first;
    while (now < last && stamps[now] <= until) now++;
    const stretch = (from: number, to: number, alpha: number, width: number) => {
      if (to - from < 2) return;
      context.globalAlpha = alpha;
      context.lineWidth = width;
      context.strokeStyle = colour;
      context.beginPath();
      for (let k = from; k < to; k++) k === from ? context.moveTo(...at(poses, k)) : context.lineTo(...at(poses, k));
      context.stroke();
    };
    stretch(Math.max(first, now - 1), last, 0.2, 1.2);
    stretch(first, now, 0.85, 1.8);
    if (shown !== null && now > first) {
      // Between two steps a walker is on the way.
      let [x, y] = at(poses, now - 1);
      if (now < last) {
        const share = Math.min(1, Math.max(0, (until - stamps[now - 1]) / (stamps[now] - stamps[now - 1])));
        const [u, v] = at(poses, now);
        x += (u - x) * share; y += (v - y) * share;
      }
      context.globalAlpha = 1;
      context.fillStyle = colour;
      context.beginPath();
      context.arc(x, y, 9, 0, 2 * Math.PI);
      context.fill();
      context.fillStyle = css("--paper");
      context.font = "600 11px system-ui, sans-serif";
      context.textAlign = "center";
      context.textBaseline = "middle";
      context.fillText(String(number + 1), x, y + 0.5);
    }
    first = last;
  });
  context.globalAlpha = 1;
}

/** Darker where more went; comparing shows the map as it came, to which they do not belong. */
function drawHexagons(context: CanvasRenderingContext2D): void {
  if (!current() || model.comparing) return;
  const { head, hexagons } = walks!, { view } = model;
  let most = 1;
  for (let k = 2; k < hexagons.length; k += 3) most = Math.max(most, hexagons[k]);
  const corners = Array.from({ length: 6 }, (_, k) => {
    const a = head.hex_angle_rad + Math.PI / 6 + (k * Math.PI) / 3;
    return [head.hex_radius_m * 0.96 * Math.cos(a), head.hex_radius_m * 0.96 * Math.sin(a)];
  });
  context.fillStyle = css("--accent");
  for (let k = 0; k < hexagons.length; k += 3) {
    context.globalAlpha = 0.08 + 0.42 * Math.log2(1 + hexagons[k + 2]) / Math.log2(1 + most);
    context.beginPath();
    corners.forEach(([x, y], c) => {
      const p = view.toScreen([hexagons[k] + x, hexagons[k + 1] + y]);
      c === 0 ? context.moveTo(...p) : context.lineTo(...p);
    });
    context.fill();
  }
  context.globalAlpha = 1;
}

function drawWalls(context: CanvasRenderingContext2D): void {
  if (!current()) return;
  const { walls } = walks!, { view } = model;
  context.strokeStyle = css("--ink");
  context.globalAlpha = 0.55;
  context.lineWidth = 1.5;
  context.beginPath();
  for (let k = 0; k < walls.length; k += 4) {
    context.moveTo(...view.toScreen([walls[k], walls[k + 1]]));
    context.lineTo(...view.toScreen([walls[k + 2], walls[k + 3]]));
  }
  context.stroke();
  context.globalAlpha = 1;
}

/** Stops, and shows the walks up to a time; null: all of them. */
function pause(time: number | null): void {
  cancelAnimationFrame(playing);
  playing = 0;
  shown = time;
  place();
  changed("layers");
}

function play(): void {
  const [low, high] = span(), length = high - low;
  if (length <= 0) return;
  if (shown === null || shown >= length) shown = 0;
  before = performance.now();
  const speed = Math.max(1, length / LONGEST_SHOW_S);
  const frame = (now: number) => {
    shown = shown! + ((now - before) / 1000) * speed;
    before = now;
    if (shown >= length) { pause(null); return; }
    place();
    changed("layers");
    playing = requestAnimationFrame(frame);
  };
  playing = requestAnimationFrame(frame);
  place();
}

const toggle = (): void => { if (playing) pause(shown); else play(); };

/** The bar says what is on screen. */
function place(): void {
  bar.hidden = !(model.layers["walks"] && current() && walks!.head.scans > 1 && model.state?.map);
  if (bar.hidden) return;
  const [low, high] = span(), time = shown ?? high - low;
  slider.max = String(high - low);
  slider.step = String((high - low) / 1000 || 1);
  slider.value = String(time);
  button.textContent = playing ? "❚❚" : "▶";
  button.setAttribute("aria-label", playing ? "Pause" : "Play");
  const text = (s: number) => `${Math.floor(s / 60)}:${String(Math.floor(s % 60)).padStart(2, "0")}`;
  clock.textContent = `${text(time)} of ${text(high - low)}`;
}

export function addWalks(): void {
  button = el("button", { id: "play", "aria-label": "Play", onclick: toggle }, "▶") as HTMLButtonElement;
  slider = el("input", { type: "range", id: "playback-time", min: "0", max: "1", value: "1", "aria-label": "Time", oninput: () => pause(Number(slider.value)) }) as HTMLInputElement;
  clock = el("span", { class: "faint number" }, "");
  bar = el("div", { id: "playback", role: "group", "aria-label": "Playback of the walks", hidden: true }, button, slider, clock);
  document.body.append(bar);
  addLayer({ name: "walls", label: "Floor plan (walls.csv beside the map)", on: false, bring, draw: drawWalls, note: () => current() ? (walks!.head.walls ? many(walks!.head.walls, "wall") : "none there") : "" });
  addLayer({ name: "hexagons", label: "Hexagons: how often the ways were gone", on: false, bring, draw: drawHexagons, note: () => current() ? `${walks!.head.hex_radius_m} m` : "" });
  addLayer({ name: "walks", label: "Walks, with playback", on: false, bring, draw: drawWalks, note: () => current() ? many(walks!.head.walks.length, "walk") : "the way of every scan, by time" });
  on(["layers", "state"], place);
  // A map of walks shows them by itself.
  let seen = 0;
  on(["state"], () => {
    if (!model.map || model.map !== model.state?.map?.number || model.map === seen) return;
    seen = model.map;
    const isWalks = /\.csv$/i.test(model.state?.map?.name ?? "");
    SHOWN.forEach((name) => { if (isWalks !== model.layers[name]) switchLayer(name, isWalks); });
  });
}
