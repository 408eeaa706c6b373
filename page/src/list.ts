// The corrections: how far each is from what the person said, and what can be done about it.

import { act } from "./act";
import type { Correction } from "./api";
import { $, angle, el, icon, length, many } from "./dom";
import { changed, model, on } from "./model";
import { MODES } from "./tool";

let sorted = false;

export function startList(): void {
  $("sort").onclick = () => { sorted = !sorted; $("sort").setAttribute("aria-pressed", String(sorted)); show(); };
  $("turn-back").onclick = () => void act({ event: "straighten", along: null });
  $("list-toggle").onclick = () => {
    const open = $("list-toggle").getAttribute("aria-expanded") !== "true";
    $("list-toggle").setAttribute("aria-expanded", String(open));
    show();
  };
  if (innerWidth <= 720) $("list-toggle").setAttribute("aria-expanded", "false");
  on(["state"], show);
}

/** Yellow beyond two standard deviations of the relation, red beyond five. */
const verdict = (value: number, sigma: number): string => (value > 5 * sigma ? "bad" : value > 2 * sigma ? "warn" : "good");

function left(c: Correction): HTMLElement {
  const box = el("span", { class: "left" });
  if (!c.enabled) box.append(el("span", { class: "faint" }, "off"));
  else if (c.rejection) box.append(el("span", { class: "bad" }, "not applied"));
  else {
    if (c.offset_m !== null) box.append(el("span", { class: verdict(c.offset_m, 0.02), title: `offset left; it was ${c.offset_before_m === null ? "–" : length(c.offset_before_m)}` }, length(c.offset_m)), " ");
    if (c.angle_rad !== null) box.append(el("span", { class: verdict(c.angle_rad, 0.01), title: `angle left; it was ${c.angle_before_rad === null ? "–" : angle(c.angle_before_rad)}` }, angle(c.angle_rad)));
  }
  return box;
}

function item(c: Correction): HTMLElement {
  const name = MODES.find((m) => m.mode === c.mode)?.name ?? c.mode;
  const toggle = el("input", { type: "checkbox", "aria-label": `${c.id} on`, checked: c.enabled, onchange: (e) => void change(c, e.target as HTMLInputElement, { event: "enable", id: c.id, enabled: (e.target as HTMLInputElement).checked }) });
  const weight = el("input", { type: "number", min: "0.01", max: "1000", step: "any", value: c.weight, "aria-label": `${c.id} weight`, onchange: (e) => void reweigh(c, e.target as HTMLInputElement) });
  const remove = el("button", { class: "small", "aria-label": `Delete ${c.id}`, onclick: () => void act({ event: "delete", id: c.id }) }, "Delete");
  const chi2 = c.chi2 === null ? "" : `χ² ${c.chi2 < 10 ? c.chi2.toFixed(1) : Math.round(c.chi2).toLocaleString("en")}`;
  const look = (id: string | null) => () => { if (model.hovered !== id) { model.hovered = id; changed("view"); } };
  const row = el("li", { class: c.enabled ? "" : "off", "data-id": c.id, tabindex: "0", onmouseenter: look(c.id), onmouseleave: look(null), onfocusin: look(c.id), onfocusout: look(null), onkeydown: (e) => {
    if (e.target === e.currentTarget && ["Delete", "Backspace"].includes((e as KeyboardEvent).key)) void act({ event: "delete", id: c.id });
  } },
    el("div", { class: "row" }, toggle, icon(c.mode), el("span", { title: c.id }, `${name} `, el("span", { class: "faint" }, c.id)), left(c)),
    el("div", { class: "tools row" }, el("span", { title: "the factor's own share of the objective; how hard it is to satisfy" }, chi2), el("label", {}, "weight ", weight), remove));
  if (c.rejection) row.append(el("div", { class: "why" }, c.rejection));
  if (c.conflicts?.length) row.append(el("div", { class: "why" }, `contradicts ${c.conflicts.join(", ")}`));
  return row;
}

/** If it fails, the control shows again what is true. */
async function change(c: Correction, input: HTMLInputElement, event: Record<string, unknown>): Promise<void> {
  if (!(await act(event))) input.checked = c.enabled;
}

async function reweigh(c: Correction, input: HTMLInputElement): Promise<void> {
  const weight = Number(input.value);
  if (!(weight > 0) || !(await act({ event: "reweight", id: c.id, weight }))) input.value = String(c.weight);
}

function show(): void {
  const state = model.state, open = $("list-toggle").getAttribute("aria-expanded") === "true";
  $("side").hidden = !state?.map || !open;
  document.body.classList.toggle("listing", !$("side").hidden);
  if (!state?.map) return;
  const list = [...state.corrections];
  if (sorted) list.sort((p, q) => (q.chi2 ?? -1) - (p.chi2 ?? -1));
  $("count").textContent = list.length ? `${list.length}` : "";
  $("list-toggle").textContent = list.length ? `List ${list.length}` : "List";
  $("empty").hidden = list.length > 0;
  $("sort").hidden = list.length < 2;
  $("unjudged").hidden = !state.unjudged || list.length === 0;
  $("unjudged").textContent = state.unjudged ?? "";
  $("straightened").hidden = !state.straightened;
  // What is typed into, or focused, stays so.
  const focused = document.activeElement?.closest("#list") ? [...$("list").querySelectorAll("input,button,li")].indexOf(document.activeElement) : -1;
  $("list").replaceChildren(...list.map(item));
  if (focused >= 0) ($("list").querySelectorAll("input,button,li")[focused] as HTMLElement | undefined)?.focus();
  $("saved").textContent = `${many(state.summary.events, "step")} saved in ${state.map.session.split(/[\\/]/).pop()}`;
  $("saved").title = state.map.session;
}
