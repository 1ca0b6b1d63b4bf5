// Markers and lines above the shapes, as SVG: crisp, and never hidden by what lies in front.

const NS = "http://www.w3.org/2000/svg";

export function element(name, attributes, parent) {
  const node = document.createElementNS(NS, name);
  for (const [key, value] of Object.entries(attributes)) node.setAttribute(key, value);
  if (parent) parent.append(node);
  return node;
}

export class Overlay {
  constructor(svg) {
    this.svg = svg;
  }

  // landmarks: [{ label, full: {x, y, hidden} | null, part: ... }]; brush: { x, y, radius } | null.
  // pairs: [{ kind: "anchor" | "hover" | "pinned", full: {x, y, hidden} | null, part: ... }] in stage pixels.
  draw(pairs, { showLines, landmarks, brush }) {
    this.svg.replaceChildren();
    if (brush) element("circle", { cx: brush.x, cy: brush.y, r: brush.radius, class: "brush" }, this.svg);
    for (const pair of pairs) {
      const { full, part, kind } = pair;
      if (full && part && (kind !== "anchor" || showLines)) {
        const bow = Math.min(60, Math.abs(full.x - part.x) / 6 + Math.abs(full.y - part.y) / 6);
        const path = `M${full.x} ${full.y} C${full.x + (part.x - full.x) / 3} ${full.y - bow} ` +
          `${part.x - (part.x - full.x) / 3} ${part.y - bow} ${part.x} ${part.y}`;
        const faint = full.hidden || part.hidden ? " faint" : "";
        if (kind !== "anchor") element("path", { d: path, class: `halo` }, this.svg);
        element("path", { d: path, class: `line ${kind}${faint}` }, this.svg);
      }
      if (kind === "anchor" && !showLines) continue;
      for (const place of [full, part]) {
        if (!place) continue;
        const faint = place.hidden ? " faint" : "";
        const radius = kind === "anchor" ? 3.2 : 8;
        if (kind !== "anchor") element("circle", { cx: place.x, cy: place.y, r: radius, class: "halo" }, this.svg);
        element("circle", { cx: place.x, cy: place.y, r: radius, class: `ring ${kind}${faint}` }, this.svg);
        if (kind !== "anchor") element("circle", { cx: place.x, cy: place.y, r: 2.4, class: "dot" }, this.svg);
      }
    }
    for (const { label, full, part } of landmarks) {
      for (const place of [full, part]) {
        if (!place) continue;
        element("circle", { cx: place.x, cy: place.y, r: 9, class: `landmark${place.hidden ? " faint" : ""}` }, this.svg);
        element("text", { x: place.x, y: place.y + 4, class: "landmark-number" }, this.svg).textContent = label;
      }
    }
  }
}
