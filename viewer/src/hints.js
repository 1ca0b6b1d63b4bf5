// What the reader knows better: landmarks, and regions of the part to ignore; as files and as a command.
import { fileCount, numberOf, shownVertex, vertexPoint } from "./shape.js";

const COLUMNS = { part: "part_vertex", full: "full_vertex" };

export class Hints {
  // landmarks hold numbers of the files; `ignored` marks vertices that are shown.
  constructor(shapes, { landmarks, ignored }) {
    this.shapes = shapes;
    this.landmarks = landmarks.map(([part, full]) => ({ part, full }));
    this.ignored = new Uint8Array(shapes.part.count);
    for (const number of ignored) this.ignored[shownVertex(shapes.part, number)] = 1;
    this.pending = { part: null, full: null };
  }

  // One end of a pair, a vertex that is shown; true when it completes a pair.
  pick(side, vertex) {
    this.pending[side] = numberOf(this.shapes[side], vertex);
    const { part, full } = this.pending;
    if (part === null || full === null) return false;
    this.add(part, full);
    return true;
  }

  // A vertex of the part has one partner, and a landmark is not ignored: sherd refuses both.
  add(part, full) {
    const pair = { part, full };
    const known = this.landmarks.findIndex((other) => other.part === part);
    if (known < 0) this.landmarks.push(pair);
    else this.landmarks[known] = pair;
    this.ignored[shownVertex(this.shapes.part, part)] = 0;
    this.pending = { part: null, full: null };
  }

  remove(index) {
    this.landmarks.splice(index, 1);
  }

  // Marks what hangs together with `vertex` inside the ball around it, so that a leg does not mark the other.
  brush(vertex, radius, erase) {
    const { part } = this.shapes;
    const kept = new Set(this.landmarks.map((pair) => shownVertex(part, pair.part)));
    const { starts, ends } = neighbors(part);
    const [x, y, z] = vertexPoint(part, vertex);
    const p = part.positions;
    const seen = new Set([vertex]);
    const waiting = [vertex];
    while (waiting.length) {
      const here = waiting.pop();
      if (erase || !kept.has(here)) this.ignored[here] = erase ? 0 : 1;
      for (let k = starts[here]; k < starts[here + 1]; k++) {
        const next = ends[k];
        if (seen.has(next)) continue;
        if (Math.hypot(p[3 * next] - x, p[3 * next + 1] - y, p[3 * next + 2] - z) > radius) continue;
        seen.add(next);
        waiting.push(next);
      }
    }
  }

  ignoreNothing() {
    this.ignored.fill(0);
  }

  // Vertices of the file, ascending: with a decimated view all whose nearest shown vertex is marked.
  get ignoredNumbers() {
    const { part } = this.shapes;
    const pinned = new Set(this.landmarks.map((pair) => pair.part));
    const numbers = [];
    for (let number = 0; number < fileCount(part); number++) {
      if (this.ignored[shownVertex(part, number)] && !pinned.has(number)) numbers.push(number);
    }
    return numbers;
  }

  get landmarksCsv() {
    return csv([COLUMNS.part, COLUMNS.full], this.landmarks.map(({ part, full }) => [part, full]));
  }

  get ignoredCsv() {
    return csv([COLUMNS.part], this.ignoredNumbers.map((number) => [number]));
  }

  // Takes a file that was saved here or written by hand; a sentence on what was read.
  load(name, text) {
    const { header, rows } = table(name, text);
    const column = (side) => {
      const index = header.indexOf(COLUMNS[side]);
      if (index < 0) return null;
      return rows.map((row, k) => this.vertex(side, row[index], `${name}: row ${k + 2}`));
    };
    const part = column("part"), full = column("full");
    if (!part) throw new Error(`${name}: has no column ${COLUMNS.part}`);
    if (full) {
      part.forEach((number, k) => this.add(number, full[k]));
      return `${part.length} landmarks from ${name}`;
    }
    const kept = new Set(this.landmarks.map((pair) => pair.part));
    for (const number of part) if (!kept.has(number)) this.ignored[shownVertex(this.shapes.part, number)] = 1;
    return `${part.length} vertices to ignore from ${name}`;
  }

  // The number in `text` if the file has such a vertex.
  vertex(side, text, where = "") {
    const count = fileCount(this.shapes[side]);
    const number = /^\s*\d+(\.0*)?\s*$/.test(text) ? Number(text) : NaN;
    if (!(number < count)) {
      const shape = side === "part" ? "part" : "full shape";
      throw new Error(`${where ? `${where}: ` : ""}${String(text).trim() || "nothing"} is no vertex of the ${shape}, which has 0..${count - 1}`);
    }
    return number;
  }

  // The stored command with these files in place of those that it named.
  command(stored, names) {
    const asked = /^sherd match\s/.test(stored);
    const words = asked ? withoutHints(stored) : ["sherd", "match", quoted(names.full), quoted(names.part), "-o", "out/"];
    if (this.landmarks.length) words.push("--landmarks", "landmarks.csv");
    if (this.ignored.includes(1)) words.push("--ignore", "ignore.csv");
    return words.join(" ");
  }
}

function csv(header, rows) {
  return [header, ...rows].map((row) => `${row.join(",")}\n`).join("");
}

function table(name, text) {
  const lines = text.replace(/^\ufeff/, "").split(/\r?\n/).filter((line) => line.trim());
  if (!lines.length) throw new Error(`${name}: is empty`);
  const [header, ...rows] = lines.map((line) => line.split(",").map((cell) => cell.trim().replace(/^"(.*)"$/, "$1")));
  const odd = rows.findIndex((row) => row.length !== header.length);
  if (odd >= 0) throw new Error(`${name}: row ${odd + 2} has ${rows[odd].length} values, but the header names ${header.length}`);
  return { header, rows };
}

const WORD = /(?:'[^']*'|"[^"]*"|\\.|[^\s'"\\])+/g;

function withoutHints(command) {
  const kept = [];
  let skip = false;
  for (const word of command.match(WORD) ?? []) {
    const plain = word.replace(/['"]/g, "");
    if (skip) skip = false;
    else if (plain === "--landmarks" || plain === "--ignore") skip = true;
    else if (!/^--(landmarks|ignore)=/.test(plain)) kept.push(word);
  }
  return kept;
}

function quoted(name) {
  return /^[\w@%+=:,./-]+$/.test(name) ? name : `'${name.replaceAll("'", `'"'"'`)}'`;
}

// Vertices that share a face, each face's corners after one another; made once.
function neighbors(shape) {
  if (shape.neighbors) return shape.neighbors;
  const { faces, count } = shape;
  const starts = new Uint32Array(count + 1);
  for (const corner of faces) starts[corner + 1] += 2;
  for (let i = 0; i < count; i++) starts[i + 1] += starts[i];
  const place = starts.slice();
  const ends = new Uint32Array(2 * faces.length);
  for (let f = 0; f < faces.length; f += 3) {
    for (let k = 0; k < 3; k++) {
      const here = faces[f + k];
      ends[place[here]++] = faces[f + ((k + 1) % 3)];
      ends[place[here]++] = faces[f + ((k + 2) % 3)];
    }
  }
  shape.neighbors = { starts, ends };
  return shape.neighbors;
}
