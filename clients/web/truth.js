// Shows true positions on the picture, whether or not the radar detects the bodies.

import { placeLabels } from "./labels.js";
import { inside, label, labelWidth } from "./overlay.js";

const VECTOR_TIME = 60; // s; a line ahead of a body shows its motion in this time
export const UNDERWAY = 0.05; // m/s; slower bodies show no course
const [HALF, SMALL_HALF, MAX_HALF] = [9, 7, 80]; // CSS pixels, half the side of a mark: the echo inside stays free
const SMALL_RADIUS = 230; // CSS pixels; a smaller picture has smaller marks
const CORNER = 0.5; // length of the legs of a mark's corners over half its side
const MAX_CORNER = 8; // CSS pixels
const LONGEST_SHIP = 460; // m; what reaches farther from its own position is land
const MAX_NAMES = 80; // on the picture
const MAX_LETTERS = 28; // of a name on the picture

/** Whether own ship is within the circle of the body's extent: the direction to its position means nothing. */
export const isAround = (body) => body.extent >= body.range;
export const isLand = (body) => isAround(body) || body.extent > LONGEST_SHIP;

/** Lays the marks and names of a `truth` message out: {marks, unnamed}, where unnamed is the number of names without room.
 *  taken: boxes [x, y, width, height] of other labels; drift: of the picture [east, north] [m/s]. */
export function layTruth(context, view, truth, taken, drift = [0, 0]) {
  const shown = fastestFirst(truth.bodies.filter((body) => !isAround(body)))
    .filter((body) => body.range <= view.reach && view.contains(...view.toScreen(body.azimuth, body.range)))
    .map((body) => markOf(context, view, body, truth.own_ship, drift));
  const isInside = ([x, y, width, height]) => {
    return [[x, y], [x + width, y], [x, y + height], [x + width, y + height]].every((corner) => view.contains(...corner));
  };
  const places = placeLabels(shown.slice(0, MAX_NAMES), isInside, taken);
  const marks = shown.map((mark, k) => ({ ...mark, place: places[k] ?? null }));
  return { marks, unnamed: marks.filter(({ place }) => !place).length };
}

function markOf(context, view, body, own, drift) {
  const [x, y] = view.toScreen(body.azimuth, body.range);
  const least = view.rim.radius < SMALL_RADIUS ? SMALL_HALF : HALF;
  const half = isLand(body) ? least : Math.min(Math.max(least, body.extent * view.metre + 4), MAX_HALF);
  const name = body.name.length > MAX_LETTERS ? `${body.name.slice(0, MAX_LETTERS - 1)}…` : body.name;
  const text = body.visible ? name : `${name} (${body.reason})`;
  return { x, y, half, text, width: labelWidth(context, text), visible: body.visible, ahead: aheadOf(view, body, own, drift) };
}

/** The point of the screen where a body will be after VECTOR_TIME; null for one at rest. drift: of the
 *  picture: a buoy in a stream moves through the water. */
function aheadOf(view, body, own, drift) {
  const velocity = [0, 1].map((k) => body.velocity[k] - drift[k]);
  if (Math.hypot(...velocity) <= UNDERWAY) return null;
  const [east, north] = [0, 1].map((k) => body.position[k] - own.position[k] + VECTOR_TIME * velocity[k]);
  return view.toScreen(Math.atan2(east, north), Math.hypot(east, north));
}

/** Draws what `layTruth` has laid out: the corners of a square about every body, dotted if the radar cannot see it, a line for
 *  its motion from the edge of the square on, and its name. */
export function drawTruth(context, view, { marks }, colours) {
  inside(context, view, () => {
    context.strokeStyle = colours.truth;
    for (const mark of marks) drawMark(context, mark);
    for (const { text, place } of marks) {
      if (!place) continue;
      context.textAlign = place.align;
      label(context, text, place.x, place.y, colours, colours.truth);
    }
  });
}

const fastestFirst = (bodies) => [...bodies].sort((a, b) => b.speed - a.speed);

function drawMark(context, { x, y, half, visible, ahead, place }) {
  context.lineWidth = 1.5;
  context.setLineDash(visible ? [] : [1.5, 1.5]);
  context.beginPath();
  const inner = half - Math.min(CORNER * half, MAX_CORNER);
  for (const [right, down] of [[-1, -1], [1, -1], [1, 1], [-1, 1]]) {
    context.moveTo(x + right * half, y + down * inner);
    context.lineTo(x + right * half, y + down * half);
    context.lineTo(x + right * inner, y + down * half);
  }
  if (ahead) line(context, x, y, half, ahead);
  context.stroke();
  context.setLineDash([]);
  context.lineWidth = 1;
  if (!place?.leader) return;
  context.beginPath();
  context.moveTo(...place.leader[0]);
  context.lineTo(...place.leader[1]);
  context.stroke();
}

/** Adds the line to the point ahead, from the edge of the mark on. */
function line(context, x, y, half, [u, v]) {
  const edge = half / Math.max(Math.abs(u - x), Math.abs(v - y)); // share of the line within the mark
  if (edge >= 1) return;
  context.moveTo(x + edge * (u - x), y + edge * (v - y));
  context.lineTo(u, v);
}
