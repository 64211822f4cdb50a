// What a radar screen shows beside the echoes: bearing scale, range rings, heading line, sweep, cursor, EBL and VRM.

import { colour } from "./palette.js";
import { bearingText, rangeText, ringStep } from "./units.js";
import { TURN } from "./view.js";

const DEGREE = Math.PI / 180;
const NAMES = ["ring", "scale", "heading", "sweep", "marker", "cursor", "blind"];

/** The colours of the furniture in the present palette. */
export function furnitureColours() {
  return Object.fromEntries(NAMES.map((name) => [name, colour(`--${name}`)]));
}

/** Clears a layer and sets it to CSS pixels. */
export function begin(canvas, scale) {
  const context = canvas.getContext("2d");
  context.setTransform(1, 0, 0, 1, 0, 0);
  context.clearRect(0, 0, canvas.width, canvas.height);
  context.setTransform(scale, 0, 0, scale, 0, 0);
  context.lineWidth = 1;
  context.textAlign = "center";
  context.textBaseline = "middle";
  return context;
}

/** Rings, bearing scale, blind sectors and heading line. options: {unit, rings, headline, relative, blindSectors}. */
export function drawFurniture(context, view, ship, colours, options) {
  drawScale(context, view, options.relative ? ship.heading : 0, colours.scale);
  for (const sector of options.blindSectors) drawBlind(context, view, ship.heading, sector, colours.blind);
  if (options.rings) drawRings(context, view, options.unit, colours);
  if (options.headline) drawHeading(context, view, ship.heading, colours.heading);
  drawNorth(context, view, colours.heading);
}

function ray(context, view, bearing, from, to) {
  context.beginPath();
  context.moveTo(...view.toScreen(bearing, from * view.range));
  context.lineTo(...view.toScreen(bearing, to * view.range));
  context.stroke();
}

function ring(context, view, range) {
  context.beginPath();
  context.arc(view.x, view.y, (range / view.range) * view.radius, 0, TURN);
  context.stroke();
}

function drawScale(context, view, zero, paint) {
  const px = 1 / view.radius;
  context.strokeStyle = context.fillStyle = paint;
  ring(context, view, view.range);
  const fine = view.radius > 230 ? 1 : 5; // ticks closer than 4 px run together
  for (let degree = 0; degree < 360; degree += fine) {
    const length = degree % 10 === 0 ? 9 : degree % 5 === 0 ? 6 : 3;
    ray(context, view, zero + degree * DEGREE, 1, 1 + length * px);
  }
  context.font = `${view.radius > 230 ? 11 : 9}px system-ui, sans-serif`;
  const apart = view.radius > 230 ? 10 : 30;
  for (let degree = 0; degree < 360; degree += apart) {
    const place = view.toScreen(zero + degree * DEGREE, view.range * (1 + 19 * px));
    context.fillText(String(degree).padStart(3, "0"), ...place);
  }
}

function drawRings(context, view, unit, colours) {
  const step = ringStep(view.range, unit);
  const room = (step / view.range) * view.radius > 52; // pixels that the longest label needs; without them only the last has one
  context.font = "11px system-ui, sans-serif";
  context.strokeStyle = context.fillStyle = colours.ring;
  for (let range = step; range < view.range * 0.985; range += step) {
    ring(context, view, range);
    if (!room && range + step < view.range * 0.985) continue;
    const [x, y] = view.toScreen(view.up + 90 * DEGREE, range);
    context.textAlign = "right";
    context.fillText(rangeText(range, unit), x - 4, y - 8);
  }
  context.textAlign = "center";
}

function drawHeading(context, view, heading, paint) {
  context.strokeStyle = paint;
  context.lineWidth = 1.5;
  ray(context, view, heading, 0, 1 + 9 / view.radius);
  context.lineWidth = 1;
}

/** An arrow just inside the rim that points north: in head-up the figures count from the bow. */
function drawNorth(context, view, paint) {
  context.save();
  context.translate(...view.toScreen(0, view.range * (1 - 3 / view.radius)));
  context.rotate(-view.up);
  context.fillStyle = paint;
  context.beginPath();
  context.moveTo(0, 0);
  context.lineTo(5, 11);
  context.lineTo(-5, 11);
  context.fill();
  context.restore();
}

/** sector: [from, to] in degrees clockwise from the bow, where the radar does not transmit. */
function drawBlind(context, view, heading, [from, to], paint) {
  const start = heading - view.up + from * DEGREE - TURN / 4;
  const width = (((to - from) % 360) + 360) % 360;
  context.strokeStyle = paint;
  context.lineWidth = 4;
  context.beginPath();
  context.arc(view.x, view.y, view.radius - 3, start, start + width * DEGREE);
  context.stroke();
  context.lineWidth = 1;
}

/** Sweep line, EBL/VRM and cursor; each of them {bearing, range} or null. */
export function drawMarks(context, view, { sweep, marker, cursor }, colours) {
  context.strokeStyle = colours.sweep;
  if (sweep !== null) ray(context, view, sweep, 0, 1);
  if (marker) drawMarker(context, view, marker, colours.marker);
  if (cursor) drawCursor(context, view, cursor, colours.cursor);
}

function drawMarker(context, view, marker, paint) {
  context.strokeStyle = paint;
  context.setLineDash([8, 5]);
  ray(context, view, marker.bearing, 0, 1);
  context.setLineDash([2, 4]);
  if (marker.range <= view.range) ring(context, view, marker.range);
  context.setLineDash([]);
}

function drawCursor(context, view, cursor, paint) {
  const [x, y] = view.toScreen(cursor.bearing, cursor.range);
  context.strokeStyle = paint;
  context.beginPath();
  for (const [dx, dy] of [[1, 0], [-1, 0], [0, 1], [0, -1]]) {
    context.moveTo(x + 4 * dx, y + 4 * dy);
    context.lineTo(x + 12 * dx, y + 12 * dy);
  }
  context.stroke();
}

/** Range and bearing of a place in words: "1.25 NM  045.0° T  335.0° R". */
export function placeText(place, heading, unit) {
  const { bearing, range } = place;
  return `${rangeText(range, unit)}  ${bearingText(bearing)} T  ${bearingText(bearing - heading)} R`;
}
