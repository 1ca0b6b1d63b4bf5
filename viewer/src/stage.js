// The two three-dimensional views: one canvas, two scenes, drawn only when something changed.
import {
  BufferAttribute, BufferGeometry, DataTexture, DoubleSide, LinearFilter, Matrix4, Mesh, PerspectiveCamera,
  Raycaster, Scene, ShaderMaterial, Vector2, Vector3, WebGLRenderer,
} from "three";
import { acceleratedRaycast, CENTER, MeshBVH } from "three-mesh-bvh";
import { paint } from "./layers.js";
import { vertexPoint } from "./shape.js";

const FIELD_OF_VIEW = 22;
// A part smaller than this share of the full shape is drawn larger, as in the printed picture.
const LEAST_EXTENT_SHARE = 0.55;

// No color map holds this one.
const IGNORED = [226, 38, 146];

// The same light as in raster.py, number for number.
const vertexShader = `
  attribute vec4 color;
  attribute float value;
  attribute float marked;
  varying vec4 tint;
  varying float share;
  varying float mark;
  varying vec3 bend;
  void main() {
    tint = color;
    share = value;
    mark = marked;
    bend = normalMatrix * normal;
    gl_Position = projectionMatrix * modelViewMatrix * vec4(position, 1.0);
  }`;
const fragmentShader = `
  uniform float orientation;
  uniform bool scalar;
  uniform float threshold;
  uniform sampler2D table;
  uniform vec3 neutral;
  uniform vec3 unknown;
  uniform vec3 ignored;
  varying vec4 tint;
  varying float share;
  varying float mark;
  varying vec3 bend;
  // Scalars are looked up here and not at the vertices, so that a threshold cuts a clean line.
  vec3 paint() {
    if (!scalar) return tint.rgb;
    float edge = max(fwidth(share), 1e-6);
    float above = clamp((share - threshold) / edge + 0.5, 0.0, 1.0);
    vec3 color = texture2D(table, vec2(share * 255.0 / 256.0 + 0.5 / 256.0, 0.5)).rgb;
    return mix(unknown, mix(neutral, color, above), smoothstep(0.5, 1.0, tint.a));
  }
  void main() {
    vec3 n = normalize(bend);
    bool inside = orientation != 0.0 && gl_FrontFacing != (orientation > 0.0);
    // orientation 0: the faces do not agree on what is outside, so no side is drawn as the inside
    if (orientation == 0.0) n *= n.z < 0.0 ? -1.0 : 1.0;
    else n *= orientation * (inside ? -1.0 : 1.0);
    n.z = max(n.z, 0.0);
    float key = max(0.0, 0.5 + 0.5 * dot(vec3(-0.42, 0.62, 0.66), n));
    float shade = (0.48 + 0.60 * key * key) * (0.82 + 0.18 * n.z);
    float gloss = 0.063 * pow(max(0.0, dot(vec3(-0.23, 0.34, 0.91), n)), 24.0);
    vec3 base = mark > 0.5 ? ignored : paint();
    if (inside) {
      base = 0.35 * base + 0.4 * dot(base, vec3(0.3, 0.6, 0.1));
      gloss = 0.0;
    }
    gl_FragColor = vec4(base * shade + gloss, 1.0);
  }`;

// What is laid over a shape: one color, half of it, so that what lies behind shines through.
const overlaidVertexShader = `
  varying vec3 bend;
  void main() {
    bend = normalMatrix * normal;
    gl_Position = projectionMatrix * modelViewMatrix * vec4(position, 1.0);
  }`;
const overlaidShader = `
  uniform vec3 tone;
  varying vec3 bend;
  void main() {
    float light = 0.55 + 0.45 * abs(normalize(bend).z);
    gl_FragColor = vec4(tone * light, 0.5);
  }`;
const OVERLAID = [86, 104, 180];

function texture(rgb) {
  const bytes = new Uint8Array(1024);
  for (let i = 0; i < 256; i++) bytes.set([rgb[3 * i], rgb[3 * i + 1], rgb[3 * i + 2], 255], 4 * i);
  const made = new DataTexture(bytes, 256, 1);
  made.magFilter = made.minFilter = LinearFilter;
  made.needsUpdate = true;
  return made;
}

class View {
  constructor(shape, element, orbit, palette) {
    this.shape = shape;
    this.element = element;
    this.orbit = orbit;
    this.pan = new Vector2();
    this.camera = new PerspectiveCamera(FIELD_OF_VIEW, 1, 0.01, 1000);
    this.camera.up.copy(orbit.up);
    this.geometry = new BufferGeometry();
    this.geometry.setAttribute("position", new BufferAttribute(shape.positions, 3));
    this.geometry.setAttribute("normal", new BufferAttribute(shape.normals, 3));
    this.colors = new Uint8Array(4 * shape.count);
    this.geometry.setAttribute("color", new BufferAttribute(this.colors, 4, true));
    this.values = new Float32Array(shape.count);
    this.geometry.setAttribute("value", new BufferAttribute(this.values, 1));
    this.geometry.setAttribute("marked", new BufferAttribute(new Float32Array(shape.count), 1));
    this.geometry.setIndex(new BufferAttribute(shape.faces.slice(), 1)); // the search tree reorders it
    const tone = (rgb) => new Vector3(...rgb).divideScalar(255);
    this.uniforms = {
      orientation: { value: shape.orientation }, scalar: { value: false }, threshold: { value: -1 },
      table: { value: null }, neutral: { value: tone(palette.neutral) }, unknown: { value: tone(palette.unknown) },
      ignored: { value: tone(IGNORED) },
    };
    this.tables = Object.fromEntries(Object.entries(palette.tables).map(([name, rgb]) => [name, texture(rgb)]));
    const material = new ShaderMaterial({ vertexShader, fragmentShader, side: DoubleSide, uniforms: this.uniforms });
    this.mesh = new Mesh(this.geometry, material);
    this.mesh.raycast = acceleratedRaycast;
    const r = shape.rotation;
    const turn = new Matrix4().set(r[0], r[1], r[2], 0, r[3], r[4], r[5], 0, r[6], r[7], r[8], 0, 0, 0, 0, 1);
    this.mesh.matrixAutoUpdate = false;
    this.mesh.matrix.copy(turn);
    this.mesh.updateMatrixWorld(true);
    this.scene = new Scene();
    this.scene.add(this.mesh);
    this.raycaster = new Raycaster();
    this.raycaster.firstHitOnly = true;
  }

  // Shows a layer, or neutral clay if there is none.
  show(layer, palette) {
    const scalar = layer?.kind === "scalar";
    this.uniforms.scalar.value = scalar;
    this.uniforms.table.value = scalar ? this.tables[layer.colorMap] : null;
    paint(this.colors, this.values, layer, palette);
    this.geometry.attributes.color.needsUpdate = true;
    this.geometry.attributes.value.needsUpdate = true;
  }

  // The positions of the shape have changed.
  moved() {
    this.geometry.attributes.position.needsUpdate = true;
    this.geometry.attributes.normal.array.set(this.shape.normals);
    this.geometry.attributes.normal.needsUpdate = true;
    this.geometry.boundsTree?.refit();
    this.geometry.computeBoundingSphere();
  }

  // Another shape in the coordinates of this one's file is drawn over it; none if null.
  overlay(shape) {
    if (this.overlaid) this.scene.remove(this.overlaid);
    this.overlaid = null;
    if (!shape) return;
    const geometry = new BufferGeometry();
    geometry.setAttribute("position", new BufferAttribute(shape.positions, 3));
    geometry.setAttribute("normal", new BufferAttribute(shape.normals, 3));
    geometry.setIndex(new BufferAttribute(shape.faces, 1));
    const material = new ShaderMaterial({
      vertexShader: overlaidVertexShader, fragmentShader: overlaidShader, side: DoubleSide, transparent: true,
      uniforms: { tone: { value: new Vector3(...OVERLAID).divideScalar(255) } },
    });
    this.overlaid = new Mesh(geometry, material);
    this.overlaid.matrixAutoUpdate = false;
    const apart = shape.center.map((middle, axis) => middle - this.shape.center[axis]);
    this.overlaid.matrix.copy(this.mesh.matrix).multiply(new Matrix4().makeTranslation(...apart));
    this.overlaid.updateMatrixWorld(true);
    this.scene.add(this.overlaid);
  }

  // Vertices that are drawn in a color of their own whatever the layer, (n,) of 0 or 1.
  mark(marked) {
    this.geometry.attributes.marked.array.set(marked);
    this.geometry.attributes.marked.needsUpdate = true;
  }

  // So many pixels does a length have in the middle of the shape.
  pixels(length) {
    const away = this.distance / this.orbit.zoom;
    return (length * this.size().height) / (2 * away * Math.tan((FIELD_OF_VIEW * Math.PI) / 360));
  }

  cut(layer, threshold) {
    const [low, high] = layer?.limits ?? [0, 1];
    this.uniforms.threshold.value = threshold === null ? -1e9 : (threshold - low) / (high - low);
  }

  // Set up what makes clicks fast; until then nothing can be hit.
  makeTree() {
    if (!this.geometry.boundsTree) this.geometry.boundsTree = new MeshBVH(this.geometry, { strategy: CENTER });
  }

  // Distance at which every vertex fits into the panel, from the present side; and the middle.
  fit() {
    const toward = this.orbit.toward();
    const right = new Vector3().crossVectors(this.orbit.up, toward).normalize();
    const up = new Vector3().crossVectors(toward, right);
    const frame = [right, up, toward].map((axis) => axis.clone().applyMatrix4(this.mesh.matrix.clone().transpose()));
    const low = [Infinity, Infinity, Infinity], high = [-Infinity, -Infinity, -Infinity];
    const p = this.shape.positions;
    for (let i = 0; i < p.length; i += 3) {
      for (let k = 0; k < 3; k++) {
        const value = p[i] * frame[k].x + p[i + 1] * frame[k].y + p[i + 2] * frame[k].z;
        if (value < low[k]) low[k] = value;
        if (value > high[k]) high[k] = value;
      }
    }
    const half = low.map((value, k) => (high[k] - value) / 2);
    this.extent = 2 * Math.max(half[0], half[1]);
    this.target = [right, up, toward].reduce(
      (sum, axis, k) => sum.addScaledVector(axis, (low[k] + high[k]) / 2), new Vector3());
    this.radius = Math.hypot(...half);
    const { width, height } = this.size();
    const slope = Math.tan((FIELD_OF_VIEW * Math.PI) / 360);
    // Room for the caption above and the axis of the eye below.
    this.distance = half[2] + Math.max(half[1] / (slope * 0.88), (half[0] / (slope * 0.95)) * (height / width));
  }

  size() {
    return { width: this.element.clientWidth || 1, height: this.element.clientHeight || 1 };
  }

  place() {
    const { width, height } = this.size();
    const away = this.distance / this.orbit.zoom;
    const toward = this.orbit.toward();
    const right = new Vector3().crossVectors(this.orbit.up, toward).normalize();
    const up = new Vector3().crossVectors(toward, right);
    const perPixel = (2 * away * Math.tan((FIELD_OF_VIEW * Math.PI) / 360)) / height;
    const target = this.target.clone()
      .addScaledVector(right, -this.pan.x * perPixel).addScaledVector(up, this.pan.y * perPixel);
    this.camera.aspect = width / height;
    this.camera.near = Math.max(away - 4 * this.radius, away / 200);
    this.camera.far = away + 4 * this.radius;
    this.camera.position.copy(target).addScaledVector(toward, away);
    this.camera.lookAt(target);
    this.camera.updateProjectionMatrix();
    this.camera.updateMatrixWorld(true);
  }

  // Pixel of a point of the shape, in the view's own panel, and whether it faces a free line of sight.
  project(point) {
    const world = new Vector3(...point).applyMatrix4(this.mesh.matrix);
    const { width, height } = this.size();
    const seen = world.clone().project(this.camera);
    let hidden = false;
    if (this.geometry.boundsTree) {
      const sight = world.clone().sub(this.camera.position);
      const far = sight.length();
      this.raycaster.set(this.camera.position, sight.normalize());
      const [hit] = this.raycaster.intersectObject(this.mesh, false);
      hidden = Boolean(hit) && hit.distance < far - 0.01 * this.radius;
    }
    return { x: ((seen.x + 1) / 2) * width, y: ((1 - seen.y) / 2) * height, hidden };
  }

  // The vertex under a pixel of the panel, or null.
  pick(x, y) {
    this.makeTree();
    const { width, height } = this.size();
    this.raycaster.setFromCamera(new Vector2((2 * x) / width - 1, 1 - (2 * y) / height), this.camera);
    const [hit] = this.raycaster.intersectObject(this.mesh, false);
    if (!hit) return null;
    const local = hit.point.clone().applyMatrix4(this.mesh.matrix.clone().invert());
    let best = null, least = Infinity;
    for (const vertex of [hit.face.a, hit.face.b, hit.face.c]) {
      const gap = new Vector3(...vertexPoint(this.shape, vertex)).distanceToSquared(local);
      if (gap < least) [best, least] = [vertex, gap];
    }
    return best;
  }
}

export class Stage {
  constructor(canvas, shapes, elements, { orbits, palette, drawn }) {
    this.canvas = canvas;
    this.drawn = drawn;
    this.renderer = new WebGLRenderer({ canvas, antialias: true, alpha: true, preserveDrawingBuffer: true });
    this.renderer.setClearColor(0x000000, 0);
    this.renderer.setScissorTest(true);
    this.views = {
      full: new View(shapes.full, elements.full, orbits.full, palette),
      part: new View(shapes.part, elements.part, orbits.part, palette),
    };
    this.waiting = false;
    new ResizeObserver(() => this.resize()).observe(canvas.parentElement);
    this.resize();
  }

  resize() {
    const box = this.canvas.parentElement;
    this.renderer.setPixelRatio(Math.min(2, window.devicePixelRatio || 1));
    this.renderer.setSize(box.clientWidth, box.clientHeight, false);
    const { full, part } = this.views;
    full.fit();
    part.fit();
    // one scale for both, unless the part would be tiny or would not fit
    const wanted = Math.max(1, (LEAST_EXTENT_SHARE * full.extent) / part.extent);
    const common = full.distance / wanted;
    part.distance = Math.max(part.distance, common);
    this.draw();
  }

  request() {
    if (this.waiting) return;
    this.waiting = true;
    requestAnimationFrame(() => {
      this.waiting = false;
      this.draw();
    });
  }

  draw() {
    const box = this.canvas.parentElement.getBoundingClientRect();
    for (const view of Object.values(this.views)) {
      view.place();
      const area = view.element.getBoundingClientRect();
      const left = area.left - box.left;
      const bottom = box.bottom - area.bottom;
      this.renderer.setViewport(left, bottom, area.width, area.height);
      this.renderer.setScissor(left, bottom, area.width, area.height);
      this.renderer.render(view.scene, view.camera);
    }
    this.drawn();
  }
}
