// The page: reads its data, shows it, and listens.
import { readPayload } from "./decode.js";
import { Fitting } from "./fitting.js";
import { Hints } from "./hints.js";
import { copyOnClick, HintsPanel, MODES } from "./hints_panel.js";
import { carriedLayer, coverage, placedLayer, readLayer } from "./layers.js";
import { listen, Orbit } from "./orbit.js";
import { Overlay } from "./overlay.js";
import { coordinates, coverageWords, integer, number, Panel } from "./panel.js";
import { readPartner, toFull, toPart } from "./partner.js";
import { coordinatesOf, fileCount, numberOf, readShape, shownVertex, vertexPoint } from "./shape.js";
import { Stage } from "./stage.js";
import { theme } from "./theme.js";

// More lines than this hide what they connect.
const MOST_ANCHORS = 60;
const SIDES = ["full", "part"];

class Page {
  constructor(meta, read) {
    this.meta = meta;
    this.shapes = { full: readShape(meta.shapes.full, read), part: readShape(meta.shapes.part, read) };
    this.palette = { ...meta.colors, tables: {} };
    for (const [name, array] of Object.entries(meta.tables)) this.palette.tables[name] = read(array);
    this.read = read;
    this.own = {
      full: meta.layers.full.map((layer) => readLayer(layer, read)),
      part: meta.layers.part.map((layer) => readLayer(layer, read)),
    };
    this.layerNames = [...new Set([...this.own.full, ...this.own.part].map((layer) => layer.name))];
    this.placements = meta.placements.map(() => null);
    this.state = { layer: this.layerNames[0] ?? null, placement: 0, thresholds: {}, linked: true, anchors: false, pinned: null, hover: null, mode: "look", brush: { percent: 5, erase: false } };
    this.hints = new Hints(this.shapes, meta);
    this.anchors = meta.anchors.filter((_, i) => i % Math.ceil(meta.anchors.length / MOST_ANCHORS || 1) === 0);
    this.timings = {};
    this.shown = {};
  }

  start(elements) {
    const { up, toward } = this.meta.camera;
    this.orbits = { full: new Orbit(up, toward), part: new Orbit(up, toward) };
    this.overlay = new Overlay(elements.svg);
    this.panel = new Panel(this);
    this.panel.fill({
      layerNames: this.layerNames, placements: this.meta.placements, scoreName: this.meta.scoreName,
      hasPartner: this.meta.placements.some((place) => place.partner), anchorCount: this.meta.anchors.length,
    });
    this.hintsPanel = this.meta.takesHints ? new HintsPanel(this) : null;
    this.hintsPanel?.fill();
    this.stage = new Stage(elements.canvas, this.shapes, elements, {
      orbits: this.orbits, palette: this.palette, drawn: () => this.redrawOverlay(),
    });
    if (this.shapes.full.before) {
      const overlaid = this.meta.overlaid ? this.shapes.part : null;
      this.fitting = new Fitting(this.stage.views.full, this.shapes.full, overlaid, () => this.stage.request());
    }
    for (const side of SIDES) this.listen(side, elements[side]);
    this.refresh();
    this.changeHints(() => {});
    this.stage.draw();
    // hits need search trees; they are built when the first picture stands
    setTimeout(() => SIDES.forEach((side) => this.stage.views[side].makeTree()), 30);
  }

  listen(side, element) {
    const view = this.stage.views[side];
    const both = (change) => {
      change(this.orbits[side]);
      const other = side === "full" ? "part" : "full";
      if (this.state.linked) this.orbits[other].copy(this.orbits[side]);
      this.stage.request();
    };
    const at = (event) => {
      const box = element.getBoundingClientRect();
      return [event.clientX - box.left, event.clientY - box.top];
    };
    let waiting = null;
    listen(element, {
      turn: (dx, dy) => both((orbit) => orbit.turn(dx, dy)),
      scale: (factor) => both((orbit) => orbit.scale(factor)),
      pan: (dx, dy) => {
        view.pan.x += dx;
        view.pan.y += dy;
        this.stage.request();
      },
      click: (event) => {
        const vertex = view.pick(...at(event));
        if (vertex === null) this.clear();
        else if (this.state.mode === "landmarks") this.pickLandmark(side, vertex);
        else this.select(side, vertex);
      },
      grab: (event) => {
        if (side !== "part" || this.state.mode !== "ignore") return false;
        const vertex = view.pick(...at(event));
        this.painted = vertex === null ? null : at(event);
        if (vertex !== null) this.brush(vertex);
        return vertex !== null;
      },
      paint: (event) => this.paint(...at(event)),
      hover: (event) => {
        if (!waiting) requestAnimationFrame(() => {
          const vertex = waiting && view.pick(...at(waiting));
          waiting = null;
          this.setHover(vertex === null ? null : { side, vertex });
        });
        waiting = event;
      },
      leave: () => {
        waiting = null;
        this.setHover(null);
      },
    });
  }

  // ---- what is shown

  placement(index = this.state.placement) {
    if (!this.placements[index]) {
      const meta = this.meta.placements[index];
      const changed = meta.layers.map((layer) => readLayer(layer, this.read));
      const layers = this.own.full.map((layer) => changed.find((other) => other.name === layer.name) ?? layer);
      const partner = readPartner(meta.partner, this.read, this.shapes.full);
      const region = meta.region && this.read(meta.region);
      const partLayers = meta.partLayers.map((layer) => readLayer(layer, this.read));
      this.placements[index] = { layers, partLayers, partner, region, carried: {}, placed: {} };
    }
    return this.placements[index];
  }

  layerOn(side, name = this.state.layer) {
    const place = this.placement();
    const full = place.layers.find((layer) => layer.name === name) ?? null;
    if (side === "full") {
      if (full?.kind !== "color" || !full.carried || !place.partner || !place.region) return full;
      place.placed[name] ??= placedLayer(full, place.region);
      return place.placed[name];
    }
    const named = (layer) => layer.name === name;
    const own = place.partLayers.find(named) ?? this.own.part.find(named);
    if (own) return own;
    if (!full || !full.carried || !place.partner) return null;
    place.carried[name] ??= carriedLayer(full, this.shapes.full, place.partner);
    return place.carried[name];
  }

  get threshold() {
    return this.state.thresholds[this.state.layer] ?? null;
  }

  refresh() {
    for (const side of SIDES) {
      this.shown[side] = this.layerOn(side);
      this.stage.views[side].show(this.shown[side], this.palette);
      this.stage.views[side].cut(this.shown[side], this.threshold);
    }
    this.panel.check("layer", this.layerNames.indexOf(this.state.layer));
    this.panel.check("placement", this.state.placement);
    this.refreshLegend();
    this.refreshPoint();
    this.stage.request();
  }

  refreshLegend() {
    const layer = this.shown.full ?? this.shown.part;
    const side = this.shown.full ? "full" : "part";
    let covered = "";
    this.covered = null;
    if (layer && (layer.kind === "mask" || (layer.kind === "scalar" && this.threshold !== null))) {
      this.covered = coverage(layer, this.shapes[side], this.threshold);
      covered = `${this.meta.names[side]}: ` + coverageWords(layer, this.covered, this.threshold);
    }
    if (layer?.kind === "scalar" && !covered) covered = "Slide to turn values below a threshold gray.";
    const beside = this.shown.part?.name === layer?.name ? this.shown.part : null; // may have kinds that the full shape lacks
    this.panel.legend(layer, this.palette, { threshold: this.threshold, covered, marks: this.marks(), beside });
  }

  marks() {
    const pair = this.resolve(this.state.hover ?? this.state.pinned);
    if (!pair) return [];
    return SIDES.filter((side) => pair[side] && this.shown[side]?.kind === "scalar")
      .map((side) => this.shown[side].values[pair[side].vertex]);
  }

  // Both ends of a chosen point.
  resolve(chosen) {
    if (!chosen) return null;
    const { full, part } = this.shapes;
    const { partner } = this.placement();
    const pair = { from: chosen.side, full: null, part: null, confidence: NaN };
    if (chosen.side === "part") {
      pair.part = { vertex: chosen.vertex, point: vertexPoint(part, chosen.vertex) };
      pair.full = toFull(partner, full, chosen.vertex);
    } else {
      const point = vertexPoint(full, chosen.vertex);
      pair.full = { vertex: chosen.vertex, point };
      const vertex = toPart(partner, point);
      if (vertex !== null) pair.part = { vertex, point: vertexPoint(part, vertex) };
    }
    if (pair.part && partner) pair.confidence = partner.confidence[pair.part.vertex];
    return pair;
  }

  refreshPoint() {
    const chosen = this.state.hover ?? this.state.pinned;
    const pair = this.resolve(chosen);
    if (!pair) {
      this.panel.point("Point", []);
      return;
    }
    const rows = [];
    for (const side of chosen.side === "part" ? ["part", "full"] : ["full", "part"]) {
      const name = this.meta.names[side];
      const end = pair[side];
      if (!end) {
        rows.push([name, this.placement().partner ? "no partner" : "no map in this result", `point-${side}`]);
        continue;
      }
      const shape = this.shapes[side];
      const vertex = `vertex ${integer(numberOf(shape, end.vertex))}`;
      rows.push([name, end.face === undefined ? vertex : `near ${vertex}`, `point-${side}`]);
      rows.push(["at", coordinates(coordinatesOf(shape, end.point), shape.extent), `point-${side}-at`]);
      const layer = this.shown[side];
      if (layer && layer.kind !== "color") rows.push([layer.name, valueWords(layer, end.vertex), `point-${side}-value`]);
    }
    if (pair.full && pair.part) rows.push(["Confidence", number(pair.confidence, 3), "point-confidence"]);
    this.panel.point(this.state.hover ? "Point under the pointer" : "Selected point", rows);
  }

  redrawOverlay() {
    if (!this.stage) return;
    const box = this.stage.canvas.parentElement.getBoundingClientRect();
    const offsets = {};
    for (const side of SIDES) {
      const area = this.stage.views[side].element.getBoundingClientRect();
      offsets[side] = [area.left - box.left, area.top - box.top];
    }
    const place = (side, point) => {
      const pixel = this.stage.views[side].project(point);
      return { x: pixel.x + offsets[side][0], y: pixel.y + offsets[side][1], hidden: pixel.hidden };
    };
    const ends = (kind, pair) => ({
      kind, full: pair.full && place("full", pair.full.point), part: pair.part && place("part", pair.part.point),
    });
    const pairs = [];
    if (this.state.anchors) {
      // anchors belong to the best placement; another one leads the same points elsewhere
      const { partner } = this.placement();
      for (const [part, full] of this.anchors) {
        const end = this.state.placement === 0
          ? { point: vertexPoint(this.shapes.full, full) } : toFull(partner, this.shapes.full, part);
        if (end) pairs.push(ends("anchor", { part: { point: vertexPoint(this.shapes.part, part) }, full: end }));
      }
    }
    for (const kind of ["pinned", "hover"]) {
      const pair = this.resolve(this.state[kind]);
      if (pair) pairs.push(ends(kind, pair));
    }
    const spot = (side, number) => number === null ? null
      : place(side, vertexPoint(this.shapes[side], shownVertex(this.shapes[side], number)));
    const { pending } = this.hints;
    const landmarks = [...this.hints.landmarks, ...(pending.part === null && pending.full === null ? [] : [pending])]
      .map(({ part, full }, index) => ({ label: String(index + 1), part: spot("part", part), full: spot("full", full) }));
    const under = this.state.mode === "ignore" && this.state.hover?.side === "part" ? this.state.hover : null;
    const brush = under && { ...place("part", vertexPoint(this.shapes.part, under.vertex)), radius: this.stage.views.part.pixels(this.brushRadius) };
    this.overlay.draw(pairs, { showLines: this.state.anchors, landmarks, brush });
  }

  // ---- what can be done; tests and the console use the same functions

  select(side, vertex) {
    const start = performance.now();
    this.state.pinned = { side, vertex };
    this.state.hover = null;
    this.refreshPoint();
    this.refreshLegend();
    this.redrawOverlay();
    this.timings.select = performance.now() - start;
    this.stage.request();
    return this.resolve(this.state.pinned);
  }

  // The vertex with this number in the file; what is to be said about it, or nothing.
  selectNumber(side, wanted) {
    let number;
    try {
      number = this.hints.vertex(side, String(wanted));
    } catch (error) {
      return `${error.message}.`;
    }
    const shape = this.shapes[side];
    // in a decimated view a vertex may have the number of another one of the file
    const exact = shape.numbers ? shape.numbers.indexOf(number) : number;
    const vertex = exact < 0 ? shownVertex(shape, number) : exact;
    this.select(side, vertex);
    return exact < 0 ? `The decimated view does not show ${integer(number)}; ${integer(numberOf(shape, vertex))} is near it.` : "";
  }

  // ---- landmarks and regions to ignore

  setMode(mode) {
    if (!this.hintsPanel || !MODES.includes(mode)) return;
    this.state.mode = mode;
    this.hints.pending = { part: null, full: null };
    this.stage.views.part.element.classList.toggle("painting", mode === "ignore");
    this.changeHints(() => {});
  }

  setBrush(change) {
    Object.assign(this.state.brush, change);
    this.changeHints(() => {});
  }

  fileCount(side) {
    return fileCount(this.shapes[side]);
  }

  get brushRadius() {
    return (this.state.brush.percent / 100) * this.shapes.part.extent;
  }

  hintsCommand() {
    return this.hints.command(this.meta.command, { full: this.shapes.full.name, part: this.shapes.part.name });
  }

  changeHints(change) {
    change();
    this.stage.views.part.mark(this.hints.ignored);
    this.hintsPanel?.refresh();
    this.stage.request();
  }

  pickLandmark(side, vertex) {
    this.state.pinned = null;
    this.changeHints(() => this.hints.pick(side, vertex));
  }

  brush(vertex) {
    this.changeHints(() => this.hints.brush(vertex, this.brushRadius, this.state.brush.erase));
  }

  brushNumber(number) {
    this.brush(shownVertex(this.shapes.part, number));
  }

  // Brushes along the way from the last pixel to this one.
  paint(x, y) {
    const [fromX, fromY] = this.painted ?? [x, y];
    const view = this.stage.views.part;
    const steps = Math.max(1, Math.ceil(Math.hypot(x - fromX, y - fromY) / Math.max(4, view.pixels(this.brushRadius) / 2)));
    let vertex = null;
    for (let k = 1; k <= steps; k++) {
      vertex = view.pick(fromX + ((x - fromX) * k) / steps, fromY + ((y - fromY) * k) / steps);
      if (vertex !== null) this.hints.brush(vertex, this.brushRadius, this.state.brush.erase);
    }
    this.painted = [x, y];
    this.setHover(vertex === null ? null : { side: "part", vertex });
    this.changeHints(() => {});
  }

  clear() {
    if (this.hints.pending.part !== null || this.hints.pending.full !== null) {
      this.changeHints(() => (this.hints.pending = { part: null, full: null }));
    }
    this.state.pinned = null;
    this.state.hover = null;
    this.refreshPoint();
    this.refreshLegend();
    this.redrawOverlay();
  }

  setHover(chosen) {
    const before = this.state.hover;
    if (before?.side === chosen?.side && before?.vertex === chosen?.vertex) return;
    this.state.hover = chosen;
    this.refreshPoint();
    this.refreshLegend();
    this.redrawOverlay();
  }

  setLayer(name) {
    if (!this.layerNames.includes(name)) return;
    this.state.layer = name;
    this.refresh();
  }

  setPlacement(index) {
    if (!this.meta.placements[index]) return;
    this.state.placement = index;
    this.refresh();
  }

  setThreshold(value) {
    const layer = this.shown.full ?? this.shown.part;
    if (layer?.kind !== "scalar") return;
    this.state.thresholds[this.state.layer] = value > layer.limits[0] ? value : null;
    for (const side of SIDES) this.stage.views[side].cut(this.shown[side], this.threshold);
    this.refreshLegend();
    this.stage.request();
  }

  setAnchors(shown) {
    this.state.anchors = shown;
    document.getElementById("show-anchors").checked = shown;
    this.stage.request();
  }

  setLinked(linked) {
    this.state.linked = linked;
    document.getElementById("linked").checked = linked;
    if (linked) this.orbits.part.copy(this.orbits.full);
    this.stage.request();
  }

  reset() {
    for (const side of SIDES) {
      this.orbits[side].reset();
      this.stage.views[side].pan.set(0, 0);
    }
    this.stage.request();
  }

  key(event) {
    const typing = event.target.matches?.("input[type=number], select");
    if (typing || event.ctrlKey || event.metaKey || event.altKey) return;
    const layer = this.layerNames[Number(event.key) - 1];
    if (layer) this.setLayer(layer);
    else if (event.key === "a") this.setPlacement((this.state.placement + 1) % this.placements.length);
    else if (event.key === "l") this.setLinked(!this.state.linked);
    else if (event.key === "m") this.setAnchors(!this.state.anchors && this.anchors.length > 0);
    else if (event.key === "r") this.reset();
    else if (event.key === "t") theme.toggle();
    else if (event.key === "p") this.setMode(this.state.mode === "landmarks" ? "look" : "landmarks");
    else if (event.key === "i") this.setMode(this.state.mode === "ignore" ? "look" : "ignore");
    else if (event.key === "Escape") this.clear();
  }
}

function valueWords(layer, vertex) {
  const value = layer.values[vertex];
  if (layer.kind === "mask") return Number.isNaN(value) ? "unknown" : value ? "inside" : "outside";
  if (layer.kind === "category") return value < 0 ? "none" : layer.labels[value] ?? String(value);
  return number(value, 4) + (layer.unit && !Number.isNaN(value) ? ` ${layer.unit}` : "");
}

async function main() {
  const begin = performance.now();
  theme.start();
  copyOnClick(document.getElementById("copy"), document.getElementById("command"));
  try {
    const { meta, read } = await readPayload();
    const page = new Page(meta, read);
    document.documentElement.dataset.view = "live";
    page.start({
      canvas: document.getElementById("canvas"), svg: document.getElementById("overlay"),
      full: document.getElementById("view-full"), part: document.getElementById("view-part"),
    });
    document.addEventListener("keydown", (event) => page.key(event));
    page.timings.ready = performance.now() - begin;
    page.timings.sinceNavigation = performance.now();
    window.sherd.page = page;
    return page;
  } catch (error) {
    // no WebGL, or a browser without DecompressionStream: the picture stays
    document.documentElement.dataset.view = "still";
    document.getElementById("still-reason").textContent = /webgl/i.test(error?.message) ? "WebGL is missing or switched off" : String(error?.message ?? error);
    window.sherd.error = error;
    return null;
  }
}

// For tests and for the curious: window.sherd.page has state, shapes, select, setLayer, ...
window.sherd = { page: null, error: null };
window.sherd.ready = main();
