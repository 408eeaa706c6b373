// The first screen: a map, please.

import { post, upload } from "./api";
import { $ } from "./dom";
import { model, on } from "./model";

let current: AbortController | null = null;

export function startFirst(): void {
  const drop = $("drop"), file = $<HTMLInputElement>("file");
  file.onchange = () => { const chosen = file.files?.[0]; file.value = ""; if (chosen) void take(chosen); };
  drop.onkeydown = (e) => { if (e.key === "Enter" || e.key === " ") { e.preventDefault(); file.click(); } };
  $("demo").onclick = () => void work("opening the demo", () => post("/api/demo", {}));
  $("first-back").onclick = () => { current?.abort(); $("first").hidden = true; };
  window.addEventListener("dragover", (e) => { e.preventDefault(); drop.classList.add("over"); });
  window.addEventListener("dragleave", () => drop.classList.remove("over"));
  window.addEventListener("drop", (e) => {
    e.preventDefault();
    drop.classList.remove("over");
    const dropped = e.dataTransfer?.files[0];
    if (!dropped) return;
    $("first").hidden = false;
    $("first-back").hidden = !model.state?.map;
    void take(dropped);
  });
  let shown = 0;
  on(["state"], () => {
    const map = model.state?.map;
    if (!map) $("first").hidden = false;
    else if (map.number !== shown) { shown = map.number; $("first").hidden = true; }
    $("bar").hidden = $("scale").hidden = !map;
  });
}

function take(file: File): Promise<void> {
  return work(`reading ${file.name}`, (signal) => upload(file, $<HTMLInputElement>("start-odometry").checked ? "odometry" : "scan-match", (share) => {
    $("first-share").style.setProperty("--share", `${100 * share}%`);
    if (share === 1) $("drop").querySelector("b")!.textContent = `opening ${file.name} …`;
  }, signal));
}

/** Whatever is open stays open if this fails. */
async function work(what: string, run: (signal: AbortSignal) => Promise<unknown>): Promise<void> {
  current?.abort();
  const mine = (current = new AbortController());
  const fault = $("first-fault"), text = $("drop").querySelector("b")!, said = text.textContent;
  fault.hidden = true;
  text.textContent = `${what} …`;
  $("first-share").style.visibility = "visible";
  try {
    await run(mine.signal);
    $("first").hidden = true;
  } catch (error) {
    if (!mine.signal.aborted) { fault.textContent = (error as Error).message; fault.hidden = false; }
  }
  text.textContent = said?.endsWith("…") ? "Drop a map or a log here" : said;
  $("first-share").style.visibility = "hidden";
}
