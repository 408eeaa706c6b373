// The page of `hitl serve`: what is on screen follows what the server says; everything else is in its own file.

import { commitTimes, follow } from "./act";
import { listen, post, type State } from "./api";
import { $, complain } from "./dom";
import { startFirst } from "./first";
import { fit, startInput } from "./input";
import { startList } from "./list";
import { changed, model, on } from "./model";
import { startOverlay } from "./overlay";
import { startLayers } from "./layers/all";
import { startMatches } from "./matches";
import { startMatching } from "./matching";
import { startSuggest } from "./suggest";
import { setTheme, startPanels } from "./panels";
import { drawn, frames, startRaster } from "./raster";
import { forget, startTool, times } from "./tool";

function resize(): void {
  model.view.width = innerWidth;
  model.view.height = innerHeight;
  changed("view");
}

// What lies below the bar must know how high it is.
new ResizeObserver(() => document.documentElement.style.setProperty("--bar", `${$("bar").offsetHeight}px`)).observe($("bar"));

let waiting = 0, first = { id: 0, at: 0 };
/** What is over sooner is not worth a word, ms. */
const MOMENT = 300;

/** What takes longer than a moment is shown, and can be given up. */
function showWork(state: State): void {
  const work = state.works[0];
  clearTimeout(waiting);
  if (!work) { $("work").hidden = true; return; }
  if (first.id !== work.id) first = { id: work.id, at: performance.now() };
  const show = () => {
    $("work").hidden = false;
    $("work-text").textContent = work.of > 1 ? `${work.what}: ${Math.floor((100 * work.done) / work.of)} %` : `${work.what} …`;
    const share = $("work-share");
    share.classList.toggle("waiting", work.of < 2);
    share.style.width = work.of < 2 ? "" : `${(100 * work.done) / work.of}%`;
    $("cancel").onclick = () => void post("/api/cancel", { id: work.id }).catch(complain);
  };
  const wait = MOMENT - (performance.now() - first.at);
  if ($("work").hidden && wait > 0) waiting = setTimeout(show, wait) as unknown as number; else show();
}

function news(state: State): void {
  const before = model.state;
  model.state = state;
  if (before?.map?.number !== state.map?.number) forget();
  const undo = $<HTMLButtonElement>("undo"), redo = $<HTMLButtonElement>("redo");
  undo.disabled = !state.undo;
  redo.disabled = !state.redo;
  undo.dataset["tip"] = state.undo ? `Undo: ${state.undo} (Ctrl+Z)` : "Nothing to undo";
  redo.dataset["tip"] = state.redo ? `Redo: ${state.redo} (Ctrl+Y)` : "Nothing to redo";
  showWork(state);
  changed("state");
  void follow();
}

setTheme(localStorage.getItem("theme") ?? "as the system");
matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => setTheme(localStorage.getItem("theme") ?? "as the system"));
startRaster();
startLayers();
startOverlay();
startTool();
startList();
startMatching();
startSuggest();
startMatches();
startPanels();
startFirst();
startInput();
window.addEventListener("resize", resize);
resize();

let fitted = 0;
on(["state"], () => { if (model.map && model.map !== fitted) { fitted = model.map; fit(); } });
void listen(news, (alive) => { model.alive = alive; changed("tool"); });

// For the tests and the measurements.
Object.assign(window, { hitl: { model, frames, times, commitTimes, drawn, fit } });
