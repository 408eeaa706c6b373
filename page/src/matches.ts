// The list of what was matched by itself: one by one, to look at and to refuse; and where the next stroke may go.

import { act } from "./act";
import { $, el, length, many } from "./dom";
import { showBox } from "./input";
import { around, point } from "./layers/matches";
import { match, matching, setAlways, type Found, type NearPass } from "./matching";
import { model, on } from "./model";

/** So many are listed at once. */
const SHOWN = 40;

export function startMatches(): void {
  $("match-now").onclick = () => void match();
  const always = $<HTMLInputElement>("match-always");
  always.checked = matching.always;
  always.onchange = () => setAlways(always.checked);
  on(["state", "layers"], show);
}

type Pair = { i: number; j: number };

function row(pair: Pair, text: (Node | string)[], ...buttons: HTMLElement[]): HTMLElement {
  const look = (p: Pair | null) => () => point(p);
  return el("li", { onmouseenter: look(pair), onmouseleave: look(null), onfocusin: look(pair), onfocusout: look(null), "data-pair": `${pair.i}-${pair.j}` },
    el("button", { class: "small place", "data-tip": "Show it", onclick: () => showBox(around(pair)) }, ...text), ...buttons);
}

function match_(f: Found): HTMLElement {
  const share = `${Math.round(100 * f.inliers)} % fit`;
  const verdict = f.agrees ? share : el("span", { class: "bad" }, `disagrees, χ² ${Math.round(f.chi2)}`);
  return row(f, [`${f.name} `, verdict, ...(f.weak ? [el("span", { class: "faint", title: "says nothing along the corridor" }, " · may slide")] : [])],
    el("button", { class: "small", "aria-label": `Refuse ${f.name}`, onclick: () => { point(null); void act({ event: "refuse", name: f.name }); } }, "Refuse"));
}

const pass = (p: NearPass): HTMLElement => row(p, [`${p.i}-${p.j}, ${length(p.distance_m)} apart`]);

function section(title: string, items: HTMLElement[], open: boolean, note = ""): HTMLElement[] {
  if (items.length === 0) return [];
  const rest = items.length - SHOWN;
  return [el("details", { open, "data-section": title }, el("summary", {}, `${title} `, el("span", { class: "faint" }, String(items.length))),
    ...(note ? [el("p", { class: "faint" }, note)] : []),
    el("ul", {}, ...items.slice(0, SHOWN)), ...(rest > 0 ? [el("p", { class: "faint" }, `and ${rest} more`)] : []))];
}

let shown = "";

function show(): void {
  const state = model.state;
  if (!state?.map) return;
  const { closures: { revision, factors, near_passes, refused }, running } = matching, { is_current, withdrawn, footprints } = state.matching;
  const said = footprints ? "A map of walks: footprints are no walls, so nothing is matched."
    : running ? "matching the visits …"
    : withdrawn && is_current ? "What was matched contradicts itself, so none is kept. Draw more strokes."
    : factors.length ? `${many(factors.length, "place")} matched${is_current ? "" : ", before the last change"}.`
    : is_current ? "Nothing else fits." : "Visits that come near each other can be matched by themselves.";
  $("match-said").textContent = said;
  $<HTMLButtonElement>("match-now").disabled = running || is_current || footprints;
  const key = `${revision} ${factors.length}`;
  if (key === shown) return;
  shown = key;
  // What was unfolded stays so.
  const unfolded = new Set([...$("matches").querySelectorAll<HTMLDetailsElement>("details[open]")].map((d) => d.dataset["section"]));
  const bad = factors.filter((f) => !f.agrees).sort((p, q) => q.chi2 - p.chi2);
  $("matches").replaceChildren(
    ...section("Disagree with the rest", bad.map(match_), true, "One of each two is wrong: look, and refuse it or draw a stroke there."),
    ...section("Near, but not matched", near_passes.map(pass), unfolded.has("Near, but not matched"), "Here the next stroke may go: the same room seen twice?"),
    ...section("Agree", factors.filter((f) => f.agrees).sort((p, q) => p.inliers - q.inliers).map(match_), unfolded.has("Agree"), "What fits worst comes first."),
    ...section("Refused by you", refused.map((r) => row(r, [r.name], el("button", { class: "small", "aria-label": `Allow ${r.name}`, onclick: () => void act({ event: "allow", name: r.name }) }, "Allow"))), unfolded.has("Refused by you")));
}
