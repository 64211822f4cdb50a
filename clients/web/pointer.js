// Cursor, EBL and VRM by mouse, finger or keys on the picture.

import { placeText } from "./overlay.js";
import { speak } from "./status.js";
import { wrap } from "./view.js";

const DEGREE = Math.PI / 180;

/** Lets the user move the scope's cursor and set its marker; moved() is called after each change. */
export function bindPointer(scope, moved) {
  const { place } = scope;
  const under = (event) => {
    const box = place.getBoundingClientRect();
    const spot = scope.view.fromScreen(event.clientX - box.left, event.clientY - box.top);
    return spot.range <= scope.view.range ? spot : null;
  };
  const update = (change) => {
    Object.assign(scope, change);
    scope.changed = true;
    moved();
  };
  place.addEventListener("pointermove", (event) => update({ cursor: under(event) }));
  place.addEventListener("pointerleave", () => update({ cursor: null }));
  place.addEventListener("click", (event) => {
    const spot = under(event);
    if (spot) update({ cursor: spot, marker: spot });
  });
  place.addEventListener("keydown", (event) => {
    const change = keyed(scope, event);
    if (!change) return;
    event.preventDefault();
    update(change);
    if (change.cursor) speak(placeText(change.cursor, scope.ship.heading, scope.settings.unit));
  });
}

/** What a key on the picture changes: left and right turn the cursor, up and down move it out and in. */
function keyed(scope, { key, shiftKey }) {
  const cursor = scope.cursor ?? { bearing: scope.view.up, range: scope.view.range / 2 };
  const [turn, reach] = { ArrowRight: [1, 0], ArrowLeft: [-1, 0], ArrowUp: [0, 1], ArrowDown: [0, -1] }[key] ?? [0, 0];
  if (turn || reach) {
    const bearing = wrap(cursor.bearing + turn * (shiftKey ? 0.1 : 1) * DEGREE);
    const range = cursor.range + reach * scope.view.range * (shiftKey ? 0.001 : 0.01);
    return { cursor: { bearing, range: Math.min(Math.max(range, 0), scope.view.range) } };
  }
  if (key === "Enter") return { cursor, marker: cursor };
  if (key === "Escape") return { cursor: null, marker: null };
  return null;
}
