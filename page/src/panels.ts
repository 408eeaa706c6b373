// Dialogs: layers, solver, export, summary, keys.

import { download, picture, post, type Point } from "./api";
import { act } from "./act";
import { align, backdrop, openBackdrop, toImage } from "./backdrop";
import { $, complain, el, length, many, toast } from "./dom";
import { allLayers, onFailure, switchLayer } from "./layers/registry";
import { changed, model, on } from "./model";
import { setPlanStep } from "./tool";

const dialog = () => $<HTMLDialogElement>("panel");

function open(title: string, ...body: (Node | string)[]): void {
  $("panel-body").replaceChildren(el("h2", {}, title), ...body);
  dialog().setAttribute("aria-label", title);
  if (!dialog().open) dialog().showModal();
}

export function startPanels(): void {
  $("layers").onclick = layers;
  $("more").onclick = solver;
  $("export").onclick = exports_;
  $("help").onclick = keys;
  $("menu").onclick = () => void session();
  dialog().addEventListener("click", (e) => { if (e.target === dialog()) dialog().close(); });
  setPlanStep(() => `Plan: click ${["a point of the plan", "where it is on the map", "a second point of the plan", "where that is on the map"][plan.length]}.`);
  on(["layers"], noteLayers);
  onFailure((name, error) => { model.layers[name] = false; changed("layers"); complain(error); });
  on(["state"], () => { $("name").textContent = model.state?.map?.name ?? ""; document.title = model.state?.map ? `${model.state.map.name} · hitl` : "hitl-slam"; });
}

function tick(name: string, label: string, note = ""): HTMLElement {
  const box = el("input", { type: "checkbox", checked: model.layers[name], id: `layer-${name}`, onchange: (e) => switchLayer(name, (e.target as HTMLInputElement).checked) });
  return el("label", { class: "line" }, box, label, el("span", { class: "faint", id: `note-${name}` }, note));
}

/** What is known of the layers by now. */
function noteLayers(): void {
  if (!dialog().open) return;
  for (const { name, note } of allLayers()) {
    const said = document.getElementById(`note-${name}`), box = document.getElementById(`layer-${name}`) as HTMLInputElement | null;
    if (said && note) said.textContent = note();
    if (box) box.checked = model.layers[name];
  }
}

function layers(): void {
  const theme = el("select", { "aria-label": "Colours", onchange: (e) => setTheme((e.target as HTMLSelectElement).value) },
    ...["as the system", "light", "dark"].map((name) => el("option", { value: name, selected: (localStorage.getItem("theme") ?? "as the system") === name }, name)));
  const file = el("input", { type: "file", multiple: true, id: "backdrop-file", accept: ".pgm,.yaml,.yml,image/*", onchange: (e) => {
    openBackdrop([...((e.target as HTMLInputElement).files ?? [])]).then(layers, complain);
  } });
  open("Layers",
    ...allLayers().flatMap(({ name, label, note, controls }) => [tick(name, label, note?.() ?? ""), ...(controls?.() ?? [])]),
    el("h3", {}, "Under the map"),
    el("p", { class: "faint" }, "An existing map (choose .pgm and .yaml together) or any floor plan as a picture."),
    file,
    ...(backdrop.image ? placed() : []),
    el("h3", {}, "Colours"), theme);
}

function placed(): HTMLElement[] {
  const { place } = backdrop;
  const number = (label: string, value: number, set: (v: number) => void) => el("label", {}, el("span", { class: "faint" }, label), el("input", { type: "number", step: "any", value: +value.toFixed(4), onchange: (e) => {
    const v = Number((e.target as HTMLInputElement).value);
    if (Number.isFinite(v)) { set(v); changed("layers"); }
  } }));
  return [
    tick("backdrop", backdrop.name),
    el("label", { class: "line" }, "opacity", el("input", { type: "range", min: "0", max: "1", step: "0.05", value: backdrop.opacity, oninput: (e) => { backdrop.opacity = Number((e.target as HTMLInputElement).value); changed("layers"); } })),
    el("div", { class: "numbers" },
      number("x, m", place.x, (v) => { place.x = v; }), number("y, m", place.y, (v) => { place.y = v; }),
      number("m per pixel", place.metres, (v) => { if (v > 0) place.metres = v; }), number("turn, °", (place.turn * 180) / Math.PI, (v) => { place.turn = (v * Math.PI) / 180; })),
    el("p", {}, el("button", { onclick: () => { dialog().close(); plan = []; model.tool = "plan"; changed("tool"); } }, "Lay it by two points …")),
  ];
}

let plan: Point[] = [];

/** A click while the plan is being laid: plan, map, plan, map. */
export function planPoint(at: Point): void {
  plan.push(plan.length % 2 === 0 ? toImage(at) : at);
  if (plan.length === 4) {
    try { align([plan[0], plan[2]], [plan[1], plan[3]]); } catch (error) { complain(error); }
    plan = [];
    model.tool = "none";
  }
  changed("tool");
}

export function setTheme(name: string): void {
  name === "as the system" ? localStorage.removeItem("theme") : localStorage.setItem("theme", name);
  const dark = name === "dark" || (name !== "light" && matchMedia("(prefers-color-scheme: dark)").matches);
  document.documentElement.dataset["theme"] = dark ? "dark" : "light";
  changed("theme");
}

function solver(): void {
  const { settings, solvers } = model.state!;
  const choose = (name: string, values: string[], value: string, disabled: string[] = []) => el("select", { id: `set-${name}`, onchange: (e) => void set(name, (e.target as HTMLSelectElement).value) },
    ...values.map((v) => el("option", { value: v, selected: v === value, disabled: disabled.includes(v) }, v)));
  const set = async (name: string, value: string | number) => {
    const { solver, formulation, drawing_sigma_m } = model.state!.settings;
    await act({ event: "settings", solver, formulation, drawing_sigma_m, [name]: value });
  };
  const sigma = el("input", { type: "number", min: "0.005", max: "1", step: "0.005", value: settings.drawing_sigma_m, onchange: (e) => {
    const v = Number((e.target as HTMLInputElement).value);
    if (v > 0) void set("drawing_sigma_m", v);
  } });
  const paper = el("input", { type: "checkbox", checked: model.paperKeys, id: "paper-keys", onchange: (e) => {
    model.paperKeys = (e.target as HTMLInputElement).checked;
    localStorage.setItem("paper-keys", model.paperKeys ? "1" : "0");
  } });
  const result = el("div", { id: "crosscheck-result" });
  const both = solvers.includes("ceres");
  open("Solver",
    el("label", { class: "line" }, "Who solves", choose("solver", ["rust", "ceres"], settings.solver, both ? [] : ["ceres"]), el("span", { class: "faint" }, both ? "the same result, to 1e-6 m" : "Ceres is not in this build")),
    el("label", { class: "line" }, "Objective", choose("formulation", ["smooth", "paper"], settings.formulation), el("span", { class: "faint" }, "paper: to the letter; see docs/RESULTS.md")),
    el("label", { class: "line" }, "Drawing accuracy, m", sigma, el("span", { class: "faint" }, "how far a stroke may lie from its wall")),
    el("label", { class: "line" }, paper, "Keys of the paper", el("span", { class: "faint" }, "p, then drag with Ctrl, Shift, Shift+Alt, Shift+Ctrl; p")),
    el("h3", {}, "Cross-check"),
    el("p", { class: "faint" }, "Solves every correction with both solvers and compares them."),
    el("button", { id: "crosscheck", disabled: !both || model.state!.corrections.length === 0, onclick: () => void crosscheck(result) }, "Cross-check now"), result);
}

interface Totals { max_residual_difference: number; max_pose_difference_m: number; max_angle_difference_rad: number; relative_cost_difference: number; rust_ms: number; ceres_ms: number }

async function crosscheck(box: HTMLElement): Promise<void> {
  box.replaceChildren("Solving …");
  try {
    const found = await post<{ agree: boolean; total: Totals; corrections: { id: string; agree: boolean; rejected: string | null; totals: Totals }[] }>("/api/crosscheck", {});
    const row = (name: string, t: Totals, verdict: string) => el("tr", {}, el("td", {}, name), ...[t.max_pose_difference_m.toExponential(1), t.max_angle_difference_rad.toExponential(1), t.relative_cost_difference.toExponential(1), t.rust_ms.toFixed(1), t.ceres_ms.toFixed(1)].map((v) => el("td", { class: "number" }, v)), el("td", {}, verdict));
    box.replaceChildren(
      el("p", { class: found.agree ? "good" : "bad" }, el("b", {}, found.agree ? "The two solvers agree." : "The two solvers disagree.")),
      el("table", {}, el("tr", {}, ...["", "poses, m", "angles, rad", "cost, rel", "rust ms", "ceres ms", ""].map((h) => el("th", {}, h))),
        ...found.corrections.filter((c) => !c.rejected).map((c) => row(c.id, c.totals, c.agree ? "agree" : "differ")), row("all", found.total, "")));
  } catch (error) { box.replaceChildren(el("p", { class: "bad" }, (error as Error).message)); }
}

const FORMATS: [string, string, string][] = [
  ["npz", "Map (.npz)", "everything, for hitl and numpy"],
  ["pgm", "Occupancy grid (.pgm + .yaml)", "for the ROS map server, zipped"],
  ["tum", "Trajectory (.tum)", "a pose for every scan of the log"],
  ["g2o", "Pose graph (.g2o)", "poses and relative factors"],
  ["clf", "CARMEN log (.clf)", "scans on the corrected poses"],
  ["ply", "Point cloud (.ply)", "with normals"],
  ["toro", "TORO graph (.graph)", "poses and relative factors"],
  ["stfs", "HitL-SLAM text (.stfs.covars)", "of the released implementation"],
  ["corrections", "Corrections (.jsonl)", "for hitl correct"],
  ["session", "Session (.jsonl)", "for hitl replay"],
];

function exports_(): void {
  const buttons = FORMATS.map(([format, name, note]) => el("button", { "data-format": format, onclick: () => {
    download(`/api/export?format=${format}`).then((file) => { said.textContent = `Saved ${file}`; }, (e: Error) => { said.textContent = ""; toast(e.message); });
  } }, name, el("span", {}, note)));
  const said = el("p", { class: "good", role: "status", id: "export-said" });
  open("Export the map as it stands", el("div", { class: "grid" }, ...buttons), said,
    el("p", {}, el("button", { onclick: () => void session() }, "Summary of this session …")));
}

async function session(): Promise<void> {
  const { map, summary, remarks } = model.state!;
  const figures = el("div", { class: "big" });
  const figure = (value: string, what: string) => figures.append(el("div", {}, el("b", {}, value), el("span", { class: "faint" }, what)));
  figure(String(summary.corrections), summary.corrections === 1 ? "correction" : "corrections");
  figure(summary.minutes < 0.95 ? "< 1 min" : `${summary.minutes.toFixed(0)} min`, "of work");
  figure(length(summary.moved_m), "moved at most");
  if (summary.worst_offset_m !== null) figure(length(summary.worst_offset_m), "largest offset left");
  const image = el("img", { alt: "The map before and after", id: "summary-picture" }) as HTMLImageElement;
  image.hidden = true;
  open(map!.name, figures, image,
    el("p", {}, el("button", { onclick: () => void download("/api/picture").catch(complain) }, "Save the picture"), " ",
      el("button", { id: "open-other", onclick: () => { dialog().close(); $("first").hidden = false; $("first-back").hidden = false; $("first-back").focus(); } }, "Open another map …")),
    el("p", { class: "faint" }, `${many(map!.poses, "pose")}, ${many(map!.points, "point")} · ${map!.path} · session ${map!.session}`),
    ...remarks.map((r) => el("p", { class: "faint" }, r)));
  picture("/api/picture").then((url) => { image.src = url; image.hidden = false; }, complain);
  try {
    const { inconsistency_m2: { before, after } } = await post<{ inconsistency_m2: { before: number | null; after: number | null } }>("/api/summary", {});
    if (before !== null && after !== null) figure(`${before.toFixed(0)} → ${after.toFixed(0)} m²`, "inconsistency");
  } catch (error) { complain(error); }
}

export function keys(): void {
  const rows: [string, string][] = [
    ["1 2 3 4", "same place, same line, parallel, right angle: then drag twice"], ["5", "straighten by one stroke"],
    ["Enter · Esc", "apply · one step back"], ["B (hold)", "the map as it came"], ["Ctrl+Z · Ctrl+Y", "undo, redo, without end"],
    ["wheel, + −", "zoom at the cursor"], ["drag, Space+drag, middle", "pan (while drawing: with Space or the middle button)"], ["F", "fit the map"],
    ["arrows", "pan; while drawing: move the pen (Shift: far, Alt: fine), Space sets an end"], ["W", "where next: the stroke that would help most, to look at"], ["M", "match visits that come near each other"], ["L · E · ?", "layers, export, keys"], ["Delete", "on a correction in the list: delete it"],
    ["p …", "keys of the paper, if switched on under Solver"],
  ];
  open("Keys", el("table", {}, ...rows.map(([key, what]) => el("tr", {}, el("td", {}, el("kbd", {}, key)), el("td", {}, what)))));
}

export const openLayers = layers, openExports = exports_;
