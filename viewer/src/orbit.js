// Turning a shape with pointer, wheel and keys. Angles go around the direction that is up.
import { Vector3 } from "three";

export class Orbit {
  constructor(up, toward) {
    this.up = new Vector3(...up).normalize();
    const helper = Math.abs(this.up.x) < 0.7 ? new Vector3(1, 0, 0) : new Vector3(0, 1, 0);
    this.first = new Vector3().crossVectors(this.up, helper).normalize();
    this.second = new Vector3().crossVectors(this.up, this.first);
    const start = new Vector3(...toward).normalize();
    this.home = {
      azimuth: Math.atan2(start.dot(this.second), start.dot(this.first)),
      elevation: Math.asin(Math.max(-1, Math.min(1, start.dot(this.up)))),
      zoom: 1,
    };
    this.reset();
  }

  reset() {
    Object.assign(this, this.home);
  }

  copy(other) {
    this.azimuth = other.azimuth;
    this.elevation = other.elevation;
    this.zoom = other.zoom;
  }

  turn(azimuth, elevation) {
    const limit = Math.PI / 2 - 0.01;
    this.azimuth += azimuth;
    this.elevation = Math.max(-limit, Math.min(limit, this.elevation + elevation));
  }

  scale(factor) {
    this.zoom = Math.max(0.3, Math.min(40, this.zoom * factor));
  }

  // Unit vector from the shape toward the viewer.
  toward() {
    const flat = Math.cos(this.elevation);
    return new Vector3()
      .addScaledVector(this.first, flat * Math.cos(this.azimuth))
      .addScaledVector(this.second, flat * Math.sin(this.azimuth))
      .addScaledVector(this.up, Math.sin(this.elevation));
  }
}

// grab(event) says whether a drag that begins there paints instead of turning; then paint(event) follows.
// Calls back: turn(dx, dy) in radians, pan(dx, dy) in pixels, scale(factor), hover(event), click(event), leave().
export function listen(element, act) {
  const pointers = new Map();
  let moved = 0;
  let painting = false;
  let spread = 0;
  element.addEventListener("pointerdown", (event) => {
    element.setPointerCapture(event.pointerId);
    pointers.set(event.pointerId, [event.clientX, event.clientY]);
    moved = pointers.size > 1 ? 99 : 0;
    spread = 0;
    painting = pointers.size === 1 && event.button === 0 && !event.shiftKey && act.grab(event);
  });
  element.addEventListener("pointermove", (event) => {
    const last = pointers.get(event.pointerId);
    if (!last) {
      act.hover(event);
      return;
    }
    const dx = event.clientX - last[0], dy = event.clientY - last[1];
    pointers.set(event.pointerId, [event.clientX, event.clientY]);
    if (painting) {
      act.paint(event);
      return;
    }
    moved += Math.abs(dx) + Math.abs(dy);
    if (pointers.size === 2) {
      const [a, b] = [...pointers.values()];
      const now = Math.hypot(a[0] - b[0], a[1] - b[1]);
      if (spread > 0) act.scale(now / spread);
      spread = now;
    } else if (moved > 3) {
      if (event.shiftKey || event.buttons & 6) act.pan(dx, dy);
      else act.turn(-dx * 0.008, dy * 0.008);
    }
  });
  const lift = (event) => {
    const held = pointers.delete(event.pointerId);
    const painted = painting;
    painting = false;
    if (held && !painted && event.type === "pointerup" && moved <= 3 && event.button === 0) act.click(event);
  };
  element.addEventListener("pointerup", lift);
  element.addEventListener("pointercancel", lift);
  element.addEventListener("pointerleave", () => act.leave());
  element.addEventListener("contextmenu", (event) => event.preventDefault());
  element.addEventListener("wheel", (event) => {
    event.preventDefault();
    act.scale(Math.exp(-event.deltaY * (event.deltaMode ? 0.04 : 0.0015)));
  }, { passive: false });
  element.addEventListener("keydown", (event) => {
    const turns = { ArrowLeft: [-0.12, 0], ArrowRight: [0.12, 0], ArrowUp: [0, 0.12], ArrowDown: [0, -0.12] };
    if (turns[event.key]) act.turn(...turns[event.key]);
    else if (event.key === "+" || event.key === "=") act.scale(1.15);
    else if (event.key === "-") act.scale(1 / 1.15);
    else return;
    event.preventDefault();
  });
}
