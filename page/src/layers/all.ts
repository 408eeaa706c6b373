// Every layer, bottom to top. The list in the dialog has the same order, after the points.

import { many } from "../dom";
import { model, on } from "../model";
import { addFactors } from "./factors";
import { addEllipses } from "./ellipses";
import { addHeat } from "./heat";
import { addMatches } from "./matches";
import { addPoses } from "./poses";
import { addLayer, bringAll } from "./registry";
import { addStrokes } from "./strokes";
import { addWalks } from "./walks";

export function startLayers(): void {
  // Drawn by the worker (raster.ts).
  addLayer({ name: "points", label: "Points", on: true, note: () => many(model.state?.map?.points ?? 0, "point") });
  addWalks();
  addHeat();
  addFactors();
  addMatches();
  addEllipses();
  addPoses();
  addStrokes();
  on(["poses"], bringAll);
}
