// The page's data: JSON that describes arrays, and the arrays in one deflated block.
// src/sherd/report/payload.py writes what is read here.

export async function readPayload() {
  const meta = JSON.parse(document.getElementById("sherd-meta").textContent);
  const text = atob(document.getElementById("sherd-data").textContent.trim());
  const packed = new Uint8Array(text.length);
  for (let i = 0; i < text.length; i++) packed[i] = text.charCodeAt(i);
  const stream = new Blob([packed]).stream().pipeThrough(new DecompressionStream("deflate"));
  const block = new Uint8Array(await new Response(stream).arrayBuffer());
  return { meta, read: (array) => unpack(block, array) };
}

// Byte planes, lowest byte first; with `delta` each entry is the zigzag difference to the one before.
export function unpack(block, { offset, count, bytes, delta }) {
  const types = { 1: Uint8Array, 2: Uint16Array, 4: Uint32Array };
  const out = new types[bytes](count);
  for (let plane = 0; plane < bytes; plane++) {
    const start = offset + plane * count;
    const shift = 8 * plane;
    for (let i = 0; i < count; i++) out[i] |= block[start + i] << shift;
  }
  if (delta) {
    let value = 0;
    for (let i = 0; i < count; i++) {
      const code = out[i];
      value += (code >>> 1) ^ -(code & 1);
      out[i] = value; // the array's type wraps around as the writer did
    }
  }
  return out;
}

const UNKNOWN = 65535;

// 16 bits between `low` and `high`; the last code is NaN.
export function dequantize(codes, low, high) {
  const values = new Float32Array(codes.length);
  const step = (high - low) / (UNKNOWN - 1);
  for (let i = 0; i < codes.length; i++) values[i] = codes[i] === UNKNOWN ? NaN : low + codes[i] * step;
  return values;
}
