// Who walks: where the eye is and looks, moved by keys, mouse and fingers.

const STEEPEST = Math.PI / 2 - 1e-3;
// Radians a second.
const TURNING = 1.2;
const FASTER = 3;
// What each key does: forward, right, up, and turns to the right and up.
const MOVES = {
  KeyW: [1, 0, 0, 0, 0], KeyS: [-1, 0, 0, 0, 0], KeyD: [0, 1, 0, 0, 0], KeyA: [0, -1, 0, 0, 0],
  ArrowUp: [1, 0, 0, 0, 0], ArrowDown: [-1, 0, 0, 0, 0], ArrowRight: [0, 1, 0, 0, 0], ArrowLeft: [0, -1, 0, 0, 0],
  KeyE: [0, 0, 1, 0, 0], KeyQ: [0, 0, -1, 0, 0],
  KeyL: [0, 0, 0, 1, 0], KeyJ: [0, 0, 0, -1, 0], KeyI: [0, 0, 0, 0, 1], KeyK: [0, 0, 0, 0, -1],
};

class Walker {
  constructor(three, size) {
    const vector = () => new three.Vector3();
    this.three = three;
    this.size = size;
    this.isFlying = false;
    this.speed = 1;
    this.eye = vector();
    this.up = vector();
    // Where a yaw of 0 looks, level, and what is to the right then.
    this.ahead = vector();
    this.aside = vector();
    this.held = new Set();
    this.isHurried = false;
  }

  /** Stands and looks as a camera does. */
  goTo(camera) {
    const { Vector3 } = this.three;
    this.eye.fromArray(camera.eye);
    this.up.fromArray(camera.up);
    const way = new Vector3().fromArray(camera.target).sub(this.eye);
    this.reach = Math.max(way.length(), 1e-4 * this.size);
    way.normalize();
    this.pitch = Math.asin(Math.min(Math.max(way.dot(this.up), -1), 1));
    this.ahead.copy(way).addScaledVector(this.up, -way.dot(this.up)).normalize();
    this.aside.crossVectors(this.ahead, this.up);
    this.yaw = 0;
  }

  /** Unit vector. */
  direction() {
    const level = Math.cos(this.pitch);
    return this.up.clone().multiplyScalar(Math.sin(this.pitch))
      .addScaledVector(this.ahead, level * Math.cos(this.yaw))
      .addScaledVector(this.aside, level * Math.sin(this.yaw));
  }

  right() {
    return this.aside.clone().multiplyScalar(Math.cos(this.yaw)).addScaledVector(this.ahead, -Math.sin(this.yaw));
  }

  /** What it goes around. */
  pivot() {
    return this.eye.clone().addScaledVector(this.direction(), this.reach);
  }

  /** Turns by radians where it stands. */
  look(right, up) {
    this.yaw += right;
    this.pitch = Math.min(Math.max(this.pitch + up, -STEEPEST), STEEPEST);
  }

  /** The same around the pivot. */
  goAround(right, up) {
    const pivot = this.pivot();
    this.look(right, up);
    this.eye.copy(pivot).addScaledVector(this.direction(), -this.reach);
  }

  /** Nearer to the pivot by this factor of the distance, or as far ahead. */
  approach(factor) {
    const pivot = this.pivot();
    if (this.isFlying) {
      this.eye.addScaledVector(this.direction(), -0.15 * this.size * this.speed * Math.log(factor));
    } else {
      this.reach = Math.min(Math.max(this.reach * factor, 1e-4 * this.size), 10 * this.size);
      this.eye.copy(pivot).addScaledVector(this.direction(), -this.reach);
    }
  }

  /** Sideways and upwards, in parts of the distance. */
  shift(right, up) {
    const above = new this.three.Vector3().crossVectors(this.right(), this.direction());
    this.eye.addScaledVector(this.right(), right * this.reach).addScaledVector(above, up * this.reach);
  }

  /** As the keys that are held say, for so many seconds; whether any is. */
  walk(seconds) {
    if (this.held.size === 0) return false;
    const sum = [0, 0, 0, 0, 0];
    for (const key of this.held) MOVES[key].forEach((value, i) => { sum[i] += value; });
    const [forward, right, up, turn, tilt] = sum.map(value => value * seconds * (this.isHurried ? FASTER : 1));
    if (this.isFlying) {
      const step = 0.1 * this.size * this.speed;
      this.eye.addScaledVector(this.direction(), forward * step).addScaledVector(this.right(), right * step)
        .addScaledVector(this.up, up * step);
      this.look(turn * TURNING, tilt * TURNING);
    } else {
      this.goAround(-right * TURNING, -forward * TURNING);
      this.look(turn * TURNING, tilt * TURNING);
      if (up !== 0) this.approach(Math.exp(-up));
    }
    return true;
  }

  /** The camera of the library that sees what it sees. */
  aim(camera) {
    camera.position.copy(this.eye);
    camera.up.copy(this.up);
    camera.lookAt(this.eye.clone().add(this.direction()));
  }
}

/** Lets mouse and fingers on an element move the walker; `moved` is called when it has. */
function followPointers(element, walker, moved) {
  const pointers = new Map();
  const middle = () => {
    const all = [...pointers.values()];
    const [x, y] = ["x", "y"].map(axis => all.reduce((sum, pointer) => sum + pointer[axis], 0) / all.length);
    return { x, y, spread: all.reduce((sum, pointer) => sum + Math.hypot(pointer.x - x, pointer.y - y), 0) };
  };
  element.addEventListener("pointerdown", event => {
    element.setPointerCapture(event.pointerId);
    pointers.set(event.pointerId, { x: event.clientX, y: event.clientY, isSide: event.button !== 0 || event.shiftKey });
    element.focus({ preventScroll: true });
  });
  element.addEventListener("pointermove", event => {
    const pointer = pointers.get(event.pointerId);
    if (!pointer) return;
    const before = middle();
    Object.assign(pointer, { x: event.clientX, y: event.clientY });
    const after = middle();
    const [x, y] = [after.x - before.x, after.y - before.y].map(pixels => pixels / element.clientHeight);
    if (pointers.size > 1 || pointer.isSide) {
      walker.shift(-x, y);
      if (pointers.size > 1 && before.spread > 0 && after.spread > 0) walker.approach(before.spread / after.spread);
    } else if (walker.isFlying) {
      walker.look(-1.5 * x, 1.5 * y);
    } else {
      walker.goAround(3 * x, -3 * y);
    }
    moved();
  });
  for (const name of ["pointerup", "pointercancel"]) {
    element.addEventListener(name, event => pointers.delete(event.pointerId));
  }
  element.addEventListener("contextmenu", event => event.preventDefault());
  element.addEventListener("wheel", event => {
    event.preventDefault();
    // Lines and pages of some mice, and pixels.
    const pixels = event.deltaY * [1, 20, 400][event.deltaMode];
    walker.approach(Math.exp(0.001 * Math.min(Math.max(pixels, -500), 500)));
    moved();
  }, { passive: false });
}
