// Layers: values per vertex, and the colors they become.
import { dequantize } from "./decode.js";

export function readLayer(meta, read) {
  const layer = { ...meta };
  if (meta.kind === "scalar") layer.values = dequantize(read(meta.values), meta.low, meta.high);
  else if (meta.kind === "category") layer.values = Int32Array.from(read(meta.values), (code) => code - 1);
  else layer.values = read(meta.values); // mask: 0 or 1; color: red, green, blue of each vertex
  return layer;
}

// What the part shows for a layer of the full shape that is carried over by the map.
export function carriedLayer(layer, full, partner) {
  const count = partner.matched.length;
  const width = layer.kind === "color" ? 3 : 1;
  const values = new Float32Array(count * width).fill(NaN);
  for (let i = 0; i < count; i++) {
    if (!partner.matched[i]) continue;
    const f = 3 * partner.faces[i];
    const u = partner.weights[3 * i], v = partner.weights[3 * i + 1], w = partner.weights[3 * i + 2];
    const a = full.faces[f], b = full.faces[f + 1], c = full.faces[f + 2];
    if (layer.kind === "scalar" || layer.kind === "color") {
      for (let k = 0; k < width; k++) {
        values[width * i + k] =
          u * layer.values[width * a + k] + v * layer.values[width * b + k] + w * layer.values[width * c + k];
      }
    } else {
      values[i] = layer.values[u >= v && u >= w ? a : v >= w ? b : c];
    }
  }
  return { ...layer, values };
}

// What the full shape shows for a carried layer of colors: nothing where the part does not lie.
export function placedLayer(layer, region) {
  const values = Float32Array.from(layer.values);
  for (let i = 0; i < region.length; i++) if (!region[i]) values.fill(NaN, 3 * i, 3 * i + 3);
  return { ...layer, values };
}

// Fills RGBA bytes (alpha 0 is unknown) and, for scalars, places between the limits (0 to 1).
export function paint(colors, values, layer, palette) {
  const scalar = layer?.kind === "scalar";
  const [low, high] = layer?.limits ?? [0, 1];
  for (let i = 0; i < values.length; i++) {
    const known = !scalar || !Number.isNaN(layer.values[i]);
    values[i] = scalar && known ? Math.min(1, Math.max(0, (layer.values[i] - low) / (high - low))) : 0;
    const rgb = layer && !scalar ? colorAt(layer, i, palette) : palette.neutral;
    colors[4 * i] = rgb[0];
    colors[4 * i + 1] = rgb[1];
    colors[4 * i + 2] = rgb[2];
    colors[4 * i + 3] = known ? 255 : 0;
  }
}

const pixel = [0, 0, 0];

function colorAt(layer, i, palette) {
  if (layer.kind === "color") {
    if (Number.isNaN(layer.values[3 * i])) return palette.unknown;
    for (let k = 0; k < 3; k++) pixel[k] = Math.round(layer.values[3 * i + k]);
    return pixel;
  }
  const value = layer.values[i];
  if (Number.isNaN(value)) return palette.unknown;
  if (layer.kind === "mask") return palette.mask[value ? 1 : 0];
  return value < 0 ? palette.unknown : palette.category[value % palette.category.length];
}

// How much of a shape lies at or above the threshold (scalars) or inside (masks).
export function coverage(layer, shape, threshold) {
  let count = 0, area = 0, total = 0;
  for (let i = 0; i < shape.count; i++) {
    total += shape.areas[i];
    const inside = layer.kind === "mask" ? layer.values[i] > 0 : layer.values[i] >= threshold;
    if (inside) {
      count += 1;
      area += shape.areas[i];
    }
  }
  return { count, of: shape.count, areaShare: total > 0 ? area / total : 0 };
}
