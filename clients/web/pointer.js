// Mouse, touch and keys for the picture: cursor, EBL and VRM; dragging moves the picture, wheel and pinch zoom.

import { rangeAndBearingText } from "./overlay.js";
import { announce } from "./status.js";
import { wrap } from "./view.js";

const DEGREE = Math.PI / 180;
const TAP_SLIP = 6; // CSS pixels that a finger may move during a tap
const ZOOM_PIXELS = 400; // of the wheel that double the zoom; one notch is a hundred
const LINE_PIXELS = 33; // in a line; some browsers measure the wheel in lines

/** Lets the user move the scope's cursor, set its marker, and move and zoom its picture. Calls changed() after each change. */
export function bindPointer(scope, changed) {
  const update = (change) => {
    Object.assign(scope, change);
    scope.changed = true;
    changed();
  };
  bindGestures(scope, update);
  scope.container.addEventListener("wheel", (event) => {
    event.preventDefault();
    const pixels = event.deltaY * (event.deltaMode ? LINE_PIXELS : 1);
    scope.framing.zoomBy(2 ** (-pixels / ZOOM_PIXELS), scope.view, screenPoint(scope, event));
    update({});
  }, { passive: false });
  scope.container.addEventListener("keydown", (event) => {
    const change = keyChange(scope, event);
    if (!change) return;
    event.preventDefault();
    update(change);
    if (change.cursor) announce(rangeAndBearingText(change.cursor, scope.ship.heading, scope.settings.unit));
  });
}

/** Screen point [x, y] of an event, from the scope's corner. */
function screenPoint(scope, { clientX, clientY }) {
  const box = scope.container.getBoundingClientRect();
  return [clientX - box.left, clientY - box.top];
}

/** Bearing and range at the pointer; null outside the picture and beyond the radar's range. */
function positionUnder(scope, event) {
  const [x, y] = screenPoint(scope, event);
  const position = scope.view.fromScreen(x, y);
  return scope.view.contains(x, y) && position.range <= scope.view.reach ? position : null;
}

function bindGestures(scope, update) {
  const { container } = scope;
  const gesture = new Gesture();
  container.addEventListener("pointerdown", (event) => {
    if (event.button === 0) gesture.press(event.pointerId, screenPoint(scope, event));
  });
  container.addEventListener("pointermove", (event) => {
    if (!gesture.holds(event.pointerId)) return update({ cursor: positionUnder(scope, event) });
    const motion = gesture.move(event.pointerId, screenPoint(scope, event));
    if (!motion) return;
    container.setPointerCapture(event.pointerId);
    scope.framing.dragBy(...motion.shift, scope.view);
    scope.framing.zoomBy(motion.spread, scope.view, motion.middle);
    update({ cursor: null });
  });
  container.addEventListener("pointerup", (event) => {
    const position = positionUnder(scope, event);
    if (gesture.lift(event.pointerId) && position) update({ cursor: position, marker: position });
  });
  container.addEventListener("pointercancel", (event) => gesture.lift(event.pointerId));
  container.addEventListener("pointerleave", (event) => gesture.holds(event.pointerId) || update({ cursor: null }));
}

/** A tap, drag or pinch with one or two fingers. Points are [x, y] in CSS pixels. */
class Gesture {
  constructor() {
    this.fingers = new Map();
    this.isStill = true;
  }

  holds(finger) {
    return this.fingers.has(finger);
  }

  press(finger, point) {
    this.isStill = this.fingers.size === 0;
    this.fingers.set(finger, point);
    this.start = point;
  }

  /** Moves a finger; returns the motion of the picture {shift, spread, middle}, or null for a tap. */
  move(finger, point) {
    if (this.isStill && Math.hypot(point[0] - this.start[0], point[1] - this.start[1]) < TAP_SLIP) return null;
    this.isStill = false;
    const before = this.pinch();
    this.fingers.set(finger, point);
    const after = this.pinch();
    const shift = [0, 1].map((k) => after.middle[k] - before.middle[k]);
    return { shift, spread: before.width ? after.width / before.width : 1, middle: after.middle };
  }

  /** Lifts a finger; returns true if it was a tap. */
  lift(finger) {
    const isTap = this.fingers.delete(finger) && this.isStill;
    if (this.fingers.size === 0) this.isStill = true;
    return isTap;
  }

  pinch() {
    const [a, b = a] = [...this.fingers.values()];
    return { middle: [0, 1].map((k) => (a[k] + b[k]) / 2), width: Math.hypot(a[0] - b[0], a[1] - b[1]) };
  }
}

/** The change that a key makes: left and right turn the cursor, up and down move it out and in. */
function keyChange(scope, { key, shiftKey }) {
  const { view } = scope;
  const cursor = scope.cursor ?? { bearing: view.up, range: view.reach / 2 };
  const [turn, outward] = { ArrowRight: [1, 0], ArrowLeft: [-1, 0], ArrowUp: [0, 1], ArrowDown: [0, -1] }[key] ?? [0, 0];
  if (turn || outward) {
    const bearing = wrap(cursor.bearing + turn * (shiftKey ? 0.1 : 1) * DEGREE);
    const range = cursor.range + outward * view.span * (shiftKey ? 0.001 : 0.01);
    return { cursor: { bearing, range: Math.min(Math.max(range, 0), view.reach) } };
  }
  if (key === "Enter") return { cursor, marker: cursor };
  if (key === "Escape") return { cursor: null, marker: null };
  return null;
}
