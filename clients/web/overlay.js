// Draws the lines and numbers over the echoes: bearing scale, range rings, heading line, sweep, cursor, EBL and VRM.

import { colour } from "./palette.js";
import { bearingText, rangeText, ringStep } from "./units.js";
import { TURN } from "./view.js";

const DEGREE = Math.PI / 180;
const NAMES = ["ring", "ring-text", "scale", "heading", "sweep", "marker", "cursor", "blind", "truth", "halo"];
const FONT = 'system-ui, "Segoe UI", Roboto, sans-serif';
const LABEL_FONT = `600 12px ${FONT}`;
const LABEL_SIZE = [58, 16]; // CSS pixels of the longest ring label
const SHORT_LABEL = 44; // CSS pixels of a label such as 2.5 NM
const BIG_RADIUS = 230; // CSS pixels; a larger scale has a number every ten degrees

/** The colours of the overlay in the current palette. */
export function overlayColours() {
  return Object.fromEntries(NAMES.map((name) => [name, colour(`--${name}`)]));
}

/** Clears a canvas and sets its unit to CSS pixels; returns its context. */
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

/** Calls `draw` with drawing clipped to the picture. */
export function inside(context, view, draw) {
  context.save();
  context.beginPath();
  context.arc(view.rim.x, view.rim.y, view.rim.radius, 0, TURN);
  context.clip();
  draw();
  context.restore();
}

/** Width [CSS pixels] of a text that `label` writes. */
export function labelWidth(context, text) {
  context.font = LABEL_FONT;
  return context.measureText(text).width + 4; // with its outline
}

/** Writes text with an outline in the background colour, so that it is readable over echoes. */
export function label(context, text, x, y, colours, paint) {
  context.font = LABEL_FONT;
  context.lineJoin = "round";
  context.lineWidth = 4;
  context.strokeStyle = colours.halo;
  context.strokeText(text, x, y);
  context.lineWidth = 1;
  context.fillStyle = paint;
  context.fillText(text, x, y);
}

/** Draws rings, bearing scale, blind sectors and heading line. options: {unit, rings, headline, relative, blindSectors}.
 *  Returns the boxes [x, y, width, height] of the ring labels. */
export function drawOverlay(context, view, ship, colours, options) {
  let labels = [];
  drawScale(context, view, options.relative ? ship.heading : 0, colours.scale);
  inside(context, view, () => {
    for (const sector of options.blindSectors) drawBlind(context, view, ship.heading, sector, colours.blind);
    if (options.rings) labels = drawRings(context, view, options.unit, colours);
  });
  if (options.headline) drawHeading(context, view, ship.heading, colours.heading);
  drawNorth(context, view, colours.heading);
  return labels;
}

function line(context, from, to) {
  context.beginPath();
  context.moveTo(...from);
  context.lineTo(...to);
  context.stroke();
}

/** Draws a line from own ship along a bearing to the rim. */
function ray(context, view, bearing, beyond = 0) {
  const far = view.toRim(bearing);
  if (far) line(context, view.along(bearing, 0), view.along(bearing, far + beyond));
}

function ring(context, view, range) {
  context.beginPath();
  context.arc(view.x, view.y, range * view.metre, 0, TURN);
  context.stroke();
}

/** Draws the bearing scale on the rim as seen from own ship; marks that are too close to each other are omitted. */
function drawScale(context, view, zero, paint) {
  const { rim } = view;
  const isBig = rim.radius > BIG_RADIUS;
  context.strokeStyle = context.fillStyle = paint;
  context.font = `${isBig ? 11 : 10}px ${FONT}`;
  context.beginPath();
  context.arc(rim.x, rim.y, rim.radius, 0, TURN);
  context.stroke();
  let drawn = [];
  for (let degree = 0; degree < 360; degree++) {
    const far = view.toRim(zero + degree * DEGREE);
    const spacing = far * DEGREE; // CSS pixels from degree to degree, NaN if the bearing is not in the picture
    if (!(spacing > (degree % 10 === 0 ? 0 : degree % 5 === 0 ? 0.6 : 4))) continue;
    const out = outwardFrom(view, view.along(zero + degree * DEGREE, far));
    line(context, out(0), out(degree % 10 === 0 ? 9 : degree % 5 === 0 ? 6 : 3));
    if (degree % (isBig ? 10 : 30) === 0) drawn = drawNumber(context, degree, out(isBig ? 19 : 18), drawn);
  }
}

/** Returns a function of CSS pixels: the point that far outside a point [x, y] on the rim. */
function outwardFrom({ rim }, [x, y]) {
  return (pixels) => [x + (pixels / rim.radius) * (x - rim.x), y + (pixels / rim.radius) * (y - rim.y)];
}

/** Writes a number of the scale if there is room; returns the points of all numbers so far. */
function drawNumber(context, degree, [x, y], drawn) {
  if (drawn.some((other) => Math.hypot(other[0] - x, other[1] - y) < 27)) return drawn; // three digits and a gap
  context.fillText(String(degree).padStart(3, "0"), x, y);
  return [...drawn, [x, y]];
}

function drawRings(context, view, unit, colours) {
  const step = ringStep(view.span, unit);
  const spacing = step * view.metre; // CSS pixels
  const every = spacing > LABEL_SIZE[0] ? 1 : Math.max(2, Math.ceil(SHORT_LABEL / spacing)); // of so many rings, one has a label
  const boxes = [];
  for (let number = 1; number * step < view.maxRange * 0.985; number++) {
    context.strokeStyle = colours.ring;
    ring(context, view, number * step);
    const point = ringLabel(view, number * step);
    if (!point || number % every) continue;
    label(context, rangeText(number * step, unit), ...point, colours, colours["ring-text"]);
    boxes.push([point[0] - LABEL_SIZE[0] / 2, point[1] - LABEL_SIZE[1] / 2, ...LABEL_SIZE]);
  }
  return boxes;
}

/** The point of a ring's label: right of own ship, or elsewhere on the visible ring. null: the ring is not visible. */
function ringLabel(view, range) {
  for (const turn of [90, 270, 0, 180, 60, 120, 240, 300]) {
    const [x, y] = view.toScreen(view.up + turn * DEGREE, range);
    if (Math.hypot(x - view.rim.x, y - view.rim.y) < view.rim.radius - LABEL_SIZE[0] / 2) return [x, y];
  }
  return null;
}

function drawHeading(context, view, heading, paint) {
  context.strokeStyle = paint;
  context.lineWidth = 1.5;
  ray(context, view, heading, 9);
  context.lineWidth = 1;
}

/** Draws an arrow just inside the rim that points north: in head-up the numbers count from the bow. */
function drawNorth(context, view, paint) {
  const far = view.toRim(0);
  if (!far) return;
  context.save();
  context.translate(...view.along(0, far - 3));
  context.rotate(-view.up);
  context.fillStyle = paint;
  context.beginPath();
  context.moveTo(0, 0);
  context.lineTo(5, 11);
  context.lineTo(-5, 11);
  context.fill();
  context.restore();
}

/** Draws a sector without transmission. sector: [from, to] in degrees clockwise from the bow. */
function drawBlind(context, view, heading, [from, to], paint) {
  const start = heading - view.up + from * DEGREE - TURN / 4;
  const width = (((to - from) % 360) + 360) % 360;
  context.strokeStyle = paint;
  context.lineWidth = 4;
  context.beginPath();
  context.arc(view.x, view.y, view.range * view.metre - 3, start, start + width * DEGREE);
  context.stroke();
  context.lineWidth = 1;
}

/** Draws sweep line (bearing or null), EBL/VRM and cursor ({bearing, range} or null). */
export function drawMarks(context, view, { sweep, marker, cursor }, colours) {
  context.strokeStyle = colours.sweep;
  if (sweep !== null) ray(context, view, sweep);
  if (marker) drawMarker(context, view, marker, colours.marker);
  if (cursor) drawCursor(context, view, cursor, colours.cursor);
}

function drawMarker(context, view, marker, paint) {
  context.strokeStyle = paint;
  context.setLineDash([8, 5]);
  ray(context, view, marker.bearing);
  context.setLineDash([2, 4]);
  inside(context, view, () => ring(context, view, marker.range));
  context.setLineDash([]);
}

function drawCursor(context, view, cursor, paint) {
  const [x, y] = view.toScreen(cursor.bearing, cursor.range);
  if (!view.contains(x, y)) return;
  context.strokeStyle = paint;
  for (const [dx, dy] of [[1, 0], [-1, 0], [0, 1], [0, -1]]) {
    line(context, [x + 4 * dx, y + 4 * dy], [x + 12 * dx, y + 12 * dy]);
  }
}

/** Text of range and bearing: "1.25 NM  045.0° T  335.0° R". */
export function rangeAndBearingText({ bearing, range }, heading, unit) {
  return `${rangeText(range, unit)}  ${bearingText(bearing)} T  ${bearingText(bearing - heading)} R`;
}
