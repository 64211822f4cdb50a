// Shows true positions on the picture and in a table, whether or not the radar detects the bodies.

import { inside, label } from "./overlay.js";
import { bearingText, rangeNumber, unitName } from "./units.js";
import { TURN } from "./view.js";

const KNOT = 1852 / 3600; // m/s
const VECTOR_TIME = 60; // s; a line ahead of a body shows its motion in this time
const UNDERWAY = 0.05; // m/s; slower bodies show no course
const RADIUS = 6; // CSS pixels, of a mark
const LONGEST_SHIP = 460; // m; what reaches farther from its own position is land
const [LETTER, LINE] = [7, 15]; // CSS pixels, of a name: width of a letter on average, height

/** Whether own ship is within the circle of the body's extent: the direction to its position means nothing. */
const isAround = (body) => body.extent >= body.range;
const isLand = (body) => isAround(body) || body.extent > LONGEST_SHIP;

/** Marks every body of a `truth` message with a ring, dashed if the radar cannot see it, a vector for its motion, and its
 *  name if there is room. occupied: boxes [x, y, width, height] of other labels. */
export function drawTruth(context, view, truth, colours, occupied) {
  const shown = fastestFirst(truth.bodies.filter((body) => !isAround(body)))
    .filter((body) => body.range <= view.reach && view.contains(...view.toScreen(body.azimuth, body.range)))
    .map((body) => ({ body, point: view.toScreen(body.azimuth, body.range) }));
  inside(context, view, () => {
    for (const { body, point } of shown) drawBody(context, view, body, point, truth.own_ship, colours);
    drawNames(context, view, shown, colours, occupied);
  });
}

const fastestFirst = (bodies) => [...bodies].sort((a, b) => b.speed - a.speed);

/** Writes names right of the bodies, or left of them, if there is room. */
function drawNames(context, view, shown, colours, others) {
  const occupied = [...others, ...shown.map(({ point: [x, y] }) => [x - RADIUS, y - RADIUS, 2 * RADIUS, 2 * RADIUS])];
  const isInside = ([x, y, width]) => view.contains(x, y) && view.contains(x + width, y);
  const fits = (box) => isInside(box) && !occupied.some((other) => overlap(box, other));
  for (const { body, point: [x, y] } of shown) {
    if (Math.hypot(x - view.x, y - view.y) < 3 * RADIUS) continue; // too close to own ship
    const name = body.visible ? body.name : `${body.name} (${body.reason})`;
    const width = LETTER * name.length;
    const boxes = [x + RADIUS + 1, x - RADIUS - 1 - width].map((left) => [left, y - LINE / 2, width, LINE]);
    const free = boxes.find(fits);
    if (!free) continue;
    occupied.push(free);
    context.textAlign = free === boxes[0] ? "left" : "right";
    label(context, name, free === boxes[0] ? x + RADIUS + 4 : x - RADIUS - 4, y, colours, colours.truth);
  }
}

const overlap = ([x, y, w, h], [u, v, width, height]) => x < u + width && u < x + w && y < v + height && v < y + h;

function drawBody(context, view, body, point, own, colours) {
  context.strokeStyle = colours.truth;
  context.lineWidth = 1.5;
  context.setLineDash(body.visible ? [] : [3, 3]);
  context.beginPath();
  context.arc(...point, RADIUS, 0, TURN);
  if (body.speed > UNDERWAY) {
    const [east, north] = [0, 1].map((k) => body.position[k] - own.position[k] + VECTOR_TIME * body.velocity[k]);
    context.moveTo(...point);
    context.lineTo(...view.toScreen(Math.atan2(east, north), Math.hypot(east, north)));
  }
  context.stroke();
  context.setLineDash([]);
  context.lineWidth = 1;
}

/** Fills the table with all bodies: ships and buoys, the nearest first, then land. */
export function listTruth(table, truth, unit) {
  const near = [...truth.bodies].sort((a, b) => isLand(a) - isLand(b) || a.range - b.range);
  table.querySelector(".unit").textContent = unitName(unit);
  table.querySelector("tbody").replaceChildren(...near.map((body) => row(cells(body, unit))));
}

function cells(body, unit) {
  const motion = body.speed > UNDERWAY ? `${bearingText(body.course, 0)} ${(body.speed / KNOT).toFixed(0)}` : "–";
  const place = isAround(body) ? ["around", "–"] : [rangeNumber(body.range, unit), bearingText(body.azimuth)];
  return [body.name, ...place, motion, body.visible ? "yes" : body.reason];
}

function row(texts) {
  const made = document.createElement("tr");
  made.append(...texts.map((text, k) => cell(text, k === 0)));
  return made;
}

function cell(text, isName) {
  const made = document.createElement(isName ? "th" : "td");
  if (isName) made.scope = "row";
  made.textContent = text;
  return made;
}
