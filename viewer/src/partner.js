// The map from part to full, and back by the nearest partner.

export function readPartner(meta, read, full) {
  if (!meta) return null;
  const faces = read(meta.faces);
  const first = read(meta.first), second = read(meta.second), codes = read(meta.confidence);
  const count = faces.length;
  const weights = new Float32Array(3 * count);
  const confidence = new Float32Array(count);
  const positions = new Float32Array(3 * count);
  const p = full.positions;
  for (let i = 0; i < count; i++) {
    const u = first[i] / 65535, v = second[i] / 65535, w = Math.max(0, 1 - u - v);
    weights.set([u, v, w], 3 * i);
    confidence[i] = codes[i] === 65535 ? NaN : codes[i] / 65534;
    const a = 3 * full.faces[3 * faces[i]], b = 3 * full.faces[3 * faces[i] + 1], c = 3 * full.faces[3 * faces[i] + 2];
    for (let k = 0; k < 3; k++) positions[3 * i + k] = u * p[a + k] + v * p[b + k] + w * p[c + k];
  }
  return { faces, weights, confidence, positions, matched: read(meta.matched), reach: meta.reach };
}

// From a part vertex: its point on the full shape, or null.
export function toFull(partner, full, vertex) {
  if (!partner || !partner.matched[vertex]) return null;
  const w = [0, 1, 2].map((k) => partner.weights[3 * vertex + k]);
  const corner = w.indexOf(Math.max(...w));
  return {
    face: partner.faces[vertex],
    weights: w,
    vertex: full.faces[3 * partner.faces[vertex] + corner],
    point: [0, 1, 2].map((k) => partner.positions[3 * vertex + k]),
  };
}

// From a point of the full shape: the part vertex whose partner is nearest, if any is near.
export function toPart(partner, point) {
  if (!partner) return null;
  let best = -1, least = partner.reach * partner.reach;
  const p = partner.positions;
  for (let i = 0; i < partner.matched.length; i++) {
    if (!partner.matched[i]) continue;
    const x = p[3 * i] - point[0], y = p[3 * i + 1] - point[1], z = p[3 * i + 2] - point[2];
    const squared = x * x + y * y + z * z;
    if (squared < least) {
      least = squared;
      best = i;
    }
  }
  return best < 0 ? null : best;
}
