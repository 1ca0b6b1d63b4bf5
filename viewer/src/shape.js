// One shape: positions, faces, normals, areas, as plain arrays.
import { dequantize } from "./decode.js";

export function readShape(meta, read) {
  const count = meta.shown;
  const positions = new Float32Array(3 * count);
  const center = meta.low.map((low, axis) => (low + meta.high[axis]) / 2);
  for (let axis = 0; axis < 3; axis++) {
    // relative to the center, so that float32 keeps its digits far from the origin
    const low = meta.low[axis] - center[axis];
    const column = dequantize(read(meta.positions[axis]), low, low + meta.extent);
    for (let i = 0; i < count; i++) positions[3 * i + axis] = column[i];
  }
  const faces = read(meta.faces);
  const shape = { ...meta, count, center, positions, faces };
  shape.numbers = meta.numbers ? read(meta.numbers) : null;
  shape.owners = meta.owners ? read(meta.owners) : null;
  shape.before = meta.before ? readBefore(meta, read, center) : null;
  Object.assign(shape, normalsAndAreas(positions, faces));
  return shape;
}

function readBefore(meta, read, center) {
  const before = new Float32Array(3 * meta.shown);
  for (let axis = 0; axis < 3; axis++) {
    const low = meta.before.low[axis] - center[axis];
    const column = dequantize(read(meta.before.positions[axis]), low, low + meta.before.extent);
    for (let i = 0; i < meta.shown; i++) before[3 * i + axis] = column[i];
  }
  return before;
}

// The user's number of a vertex that is shown.
export const numberOf = (shape, vertex) => (shape.numbers ? shape.numbers[vertex] : vertex);

// How many vertices the user's file has, and the shown one that stands for one of them.
export const fileCount = (shape) => shape.owners?.length ?? shape.count;
export const shownVertex = (shape, number) => (shape.owners ? shape.owners[number] : number);

// Coordinates as in the user's file.
export function coordinatesOf(shape, point) {
  return [0, 1, 2].map((axis) => point[axis] + shape.center[axis]);
}

export function vertexPoint(shape, vertex) {
  return [shape.positions[3 * vertex], shape.positions[3 * vertex + 1], shape.positions[3 * vertex + 2]];
}

export function normalsAndAreas(p, faces) {
  const normals = new Float32Array(p.length);
  const areas = new Float32Array(p.length / 3);
  for (let f = 0; f < faces.length; f += 3) {
    const a = 3 * faces[f], b = 3 * faces[f + 1], c = 3 * faces[f + 2];
    const ux = p[b] - p[a], uy = p[b + 1] - p[a + 1], uz = p[b + 2] - p[a + 2];
    const vx = p[c] - p[a], vy = p[c + 1] - p[a + 1], vz = p[c + 2] - p[a + 2];
    const x = uy * vz - uz * vy, y = uz * vx - ux * vz, z = ux * vy - uy * vx;
    const third = Math.sqrt(x * x + y * y + z * z) / 6;
    for (const corner of [a, b, c]) {
      normals[corner] += x;
      normals[corner + 1] += y;
      normals[corner + 2] += z;
      areas[corner / 3] += third;
    }
  }
  for (let i = 0; i < normals.length; i += 3) {
    const length = Math.hypot(normals[i], normals[i + 1], normals[i + 2]) || 1;
    normals[i] /= length;
    normals[i + 1] /= length;
    normals[i + 2] /= length;
  }
  return { normals, areas };
}
