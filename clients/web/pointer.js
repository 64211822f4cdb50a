// The hand on the picture: cursor, EBL and VRM by mouse, finger or keys; dragging moves it, wheel and pinch zoom it.

import { placeText } from "./overlay.js";
import { speak } from "./status.js";
import { wrap } from "./view.js";

const DEGREE = Math.PI / 180;
const STILL = 6; // CSS pixels that a finger may slip in a tap
const NOTCH = 400; // CSS pixels of the wheel that double the zoom; a notch is a hundred
const LINE = 33; // CSS pixels of a line, in which some browsers count the wheel

/** Lets the user move the scope's cursor, set its marker, and frame its picture; moved() is called after each change. */
export function bindPointer(scope, moved) {
  const update = (change) => {
    Object.assign(scope, change);
    scope.changed = true;
    moved();
  };
  bindHand(scope, update);
  scope.place.addEventListener("wheel", (event) => {
    event.preventDefault();
    const pixels = event.deltaY * (event.deltaMode ? LINE : 1);
    scope.framing.zoomBy(2 ** (-pixels / NOTCH), scope.view, onPlace(scope, event));
    update({});
  }, { passive: false });
  scope.place.addEventListener("keydown", (event) => {
    const change = keyed(scope, event);
    if (!change) return;
    event.preventDefault();
    update(change);
    if (change.cursor) speak(placeText(change.cursor, scope.ship.heading, scope.settings.unit));
  });
}

/** Screen place [x, y] of an event, from the scope's corner. */
function onPlace(scope, { clientX, clientY }) {
  const box = scope.place.getBoundingClientRect();
  return [clientX - box.left, clientY - box.top];
}

/** What stands under an event; null beyond the picture and the radar's range. */
function under(scope, event) {
  const [x, y] = onPlace(scope, event);
  const spot = scope.view.fromScreen(x, y);
  return scope.view.holds(x, y) && spot.range <= scope.view.range ? spot : null;
}

function bindHand(scope, update) {
  const { place } = scope;
  const hand = new Hand();
  place.addEventListener("pointerdown", (event) => {
    if (event.button === 0) hand.press(event.pointerId, onPlace(scope, event));
  });
  place.addEventListener("pointermove", (event) => {
    if (!hand.holds(event.pointerId)) return update({ cursor: under(scope, event) });
    const pull = hand.move(event.pointerId, onPlace(scope, event));
    if (!pull) return;
    place.setPointerCapture(event.pointerId);
    scope.framing.dragBy(...pull.by, scope.view);
    scope.framing.zoomBy(pull.spread, scope.view, pull.middle);
    update({ cursor: null });
  });
  place.addEventListener("pointerup", (event) => {
    const spot = under(scope, event);
    if (hand.lift(event.pointerId) && spot) update({ cursor: spot, marker: spot });
  });
  place.addEventListener("pointercancel", (event) => hand.lift(event.pointerId));
  place.addEventListener("pointerleave", (event) => hand.holds(event.pointerId) || update({ cursor: null }));
}

/** One or two fingers on the picture. Places are [x, y] in CSS pixels. */
class Hand {
  constructor() {
    this.fingers = new Map();
    this.isStill = true;
  }

  holds(finger) {
    return this.fingers.has(finger);
  }

  press(finger, at) {
    this.isStill = this.fingers.size === 0;
    this.fingers.set(finger, at);
    this.start = at;
  }

  /** How a finger's move pulls the picture: {by, spread, middle}; null for one that holds still. */
  move(finger, at) {
    if (this.isStill && Math.hypot(at[0] - this.start[0], at[1] - this.start[1]) < STILL) return null;
    this.isStill = false;
    const before = this.grip();
    this.fingers.set(finger, at);
    const after = this.grip();
    const by = [0, 1].map((k) => after.middle[k] - before.middle[k]);
    return { by, spread: before.width ? after.width / before.width : 1, middle: after.middle };
  }

  /** A finger goes: true where it was a tap. */
  lift(finger) {
    const isTap = this.fingers.delete(finger) && this.isStill;
    if (this.fingers.size === 0) this.isStill = true;
    return isTap;
  }

  grip() {
    const [a, b = a] = [...this.fingers.values()];
    return { middle: [0, 1].map((k) => (a[k] + b[k]) / 2), width: Math.hypot(a[0] - b[0], a[1] - b[1]) };
  }
}

/** What a key on the picture changes: left and right turn the cursor, up and down move it out and in. */
function keyed(scope, { key, shiftKey }) {
  const { view } = scope;
  const cursor = scope.cursor ?? { bearing: view.up, range: view.range / 2 };
  const [turn, reach] = { ArrowRight: [1, 0], ArrowLeft: [-1, 0], ArrowUp: [0, 1], ArrowDown: [0, -1] }[key] ?? [0, 0];
  if (turn || reach) {
    const bearing = wrap(cursor.bearing + turn * (shiftKey ? 0.1 : 1) * DEGREE);
    const range = cursor.range + reach * view.span * (shiftKey ? 0.001 : 0.01);
    return { cursor: { bearing, range: Math.min(Math.max(range, 0), view.range) } };
  }
  if (key === "Enter") return { cursor, marker: cursor };
  if (key === "Escape") return { cursor: null, marker: null };
  return null;
}
