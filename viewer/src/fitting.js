// A fit in the first view: a slider from the full shape as it was to the fit, and the scan laid over it.
import { normalsAndAreas } from "./shape.js";

const $ = (id) => document.getElementById(id);

export class Fitting {
  // `shape` has `before`, positions of the full shape as it was, in the frame of its own.
  constructor(view, shape, overlaid, changed) {
    this.view = view;
    this.shape = shape;
    this.after = shape.positions.slice();
    this.changed = changed;
    $("fitting-card").hidden = false;
    $("morph").addEventListener("input", (event) => this.morph(Number(event.target.value)));
    $("overlaid-row").hidden = overlaid === null;
    if (overlaid) $("overlaid").addEventListener("change", (event) => {
      view.overlay(event.target.checked ? overlaid : null);
      changed();
    });
  }

  morph(share) {
    const { positions, before, faces } = this.shape;
    for (let i = 0; i < positions.length; i++) positions[i] = before[i] + share * (this.after[i] - before[i]);
    Object.assign(this.shape, normalsAndAreas(positions, faces));
    this.view.moved();
    this.changed();
  }
}
