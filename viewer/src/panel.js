// The controls beside and below the views. All text goes in as text, never as markup.
import { coordinates, integer, number, percent, ticks } from "./words.js";

const $ = (id) => document.getElementById(id);

export function make(tag, { text, ...attributes }, parent) {
  const node = document.createElement(tag);
  for (const [key, value] of Object.entries(attributes)) node.setAttribute(key, value);
  if (text !== undefined) node.textContent = text;
  if (parent) parent.append(node);
  return node;
}

export function choices(holder, group, entries, chosen) {
  entries.forEach(({ title, note, tail }, index) => {
    const label = make("label", { class: "choice" }, holder);
    const input = make("input", { type: "radio", name: group, value: index }, label);
    const words = make("span", { class: "words" }, label);
    make("span", { class: "title", text: title }, words);
    if (note) make("span", { class: "note", text: note }, words);
    if (tail) make("span", { class: "tail", text: tail }, label);
    input.addEventListener("change", () => chosen(index));
  });
}

export class Panel {
  constructor(act) {
    this.act = act;
  }

  fill({ layerNames, placements, scoreName, hasPartner, anchorCount }) {
    choices($("layers"), "layer", layerNames.map((title) => ({ title })), (index) => this.act.setLayer(layerNames[index]));
    if (placements.length > 1) {
      $("placements-card").hidden = false;
      $("score-name").textContent = scoreName;
      choices($("placements"), "placement", placements.map((place) => ({
        title: place.name, note: place.description, tail: place.score === null ? "" : number(place.score, 3),
      })), (index) => this.act.setPlacement(index));
    }
    $("threshold").addEventListener("input", (event) => this.act.setThreshold(Number(event.target.value)));
    $("vertex-form").addEventListener("submit", (event) => {
      event.preventDefault();
      const said = this.act.selectNumber($("vertex-side").value, $("vertex-number").value);
      $("vertex-message").textContent = said;
      $("vertex-number").setAttribute("aria-invalid", String(said !== ""));
    });
    $("vertex-form").noValidate = true; // the message stands beside the field
    $("vertex-number").setAttribute("aria-describedby", "vertex-message");
    $("anchors-row").hidden = anchorCount === 0;
    $("anchors-count").textContent = integer(anchorCount);
    $("show-anchors").addEventListener("change", (event) => this.act.setAnchors(event.target.checked));
    $("linked").addEventListener("change", (event) => this.act.setLinked(event.target.checked));
    $("reset").addEventListener("click", () => this.act.reset());
    this.hint(hasPartner ? "Click a point to see its partner." : "Click a point to read its values.");
  }

  hint(words) {
    $("hint-partner").textContent = words;
  }

  check(group, index) {
    const input = document.querySelector(`input[name="${group}"][value="${index}"]`);
    if (input) input.checked = true;
  }

  legend(layer, palette, { threshold, covered, marks, beside = null }) {
    $("legend-name").textContent = layer ? layer.name + (layer.unit ? ` [${layer.unit}]` : "") : "no layer";
    $("legend-text").textContent = layer?.description ?? "";
    const scalar = layer?.kind === "scalar";
    $("bar-row").hidden = !scalar;
    $("swatches").hidden = scalar || !layer || layer.kind === "color";
    $("coverage").textContent = covered;
    if (scalar) this.bar(layer, palette.tables[layer.colorMap], threshold, marks);
    else if (layer && layer.kind !== "color") this.swatches(layer, palette, beside);
  }

  bar(layer, table, threshold, marks) {
    const [low, high] = layer.limits;
    const stops = [];
    for (let i = 0; i <= 32; i++) {
      const row = 3 * Math.round((255 * i) / 32);
      stops.push(`rgb(${table[row]} ${table[row + 1]} ${table[row + 2]})`);
    }
    $("bar").style.background = `linear-gradient(to right, ${stops.join(",")})`;
    const share = (value) => `${100 * Math.min(1, Math.max(0, (value - low) / (high - low)))}%`;
    $("bar-off").style.width = threshold === null ? "0" : share(threshold);
    const slider = $("threshold");
    slider.min = low;
    slider.max = high;
    slider.step = (high - low) / 200;
    slider.value = threshold ?? low;
    slider.setAttribute("aria-valuetext", threshold === null ? "off" : number(threshold, 3));
    $("ticks").replaceChildren();
    for (const value of ticks(low, high)) {
      make("span", { text: number(value, 4) }, $("ticks")).style.left = share(value);
    }
    $("marks").replaceChildren();
    for (const value of marks) {
      if (!Number.isNaN(value)) make("span", {}, $("marks")).style.left = share(value);
    }
  }

  swatches(layer, palette, beside) {
    const entries = layer.kind === "mask"
      ? [["outside", palette.mask[0]], ["inside", palette.mask[1]]]
      : [...new Set([...layer.values, ...(beside?.values ?? [])])].filter((k) => k >= 0).sort((a, b) => a - b).slice(0, 24)
        .map((k) => [layer.labels[k] ?? String(k), palette.category[k % palette.category.length]]);
    $("swatches").replaceChildren();
    for (const [name, color] of entries) {
      const entry = make("span", { class: "swatch" }, $("swatches"));
      make("i", {}, entry).style.background = `rgb(${color.join(" ")})`;
      make("span", { text: name }, entry);
    }
  }

  // rows: [[term, value, id]]; an empty list shows what to do.
  point(heading, rows) {
    $("point-heading").textContent = heading;
    $("point-empty").hidden = rows.length > 0;
    const list = $("point-rows");
    list.replaceChildren();
    for (const [term, value, id] of rows) {
      make("dt", { text: term }, list);
      make("dd", id ? { text: value, id } : { text: value }, list);
    }
  }
}

export function coverageWords(layer, covered, threshold) {
  const { count, of, areaShare } = covered;
  const words = `${integer(count)} of ${integer(of)} vertices, ${percent(areaShare)} of the area`;
  return layer.kind === "mask" ? `${words}, are inside.` : `${words}, at or above ${number(threshold, 3)}.`;
}

export { coordinates, integer, number };
