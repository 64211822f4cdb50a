// The table of all bodies by the truth, whether or not the radar detects them.

import { UNDERWAY, isAround, isLand } from "./truth.js";
import { bearingText, rangeNumber, unitName } from "./units.js";

const KNOT = 1852 / 3600; // m/s

export function targetsPanel(page) {
  const targets = document.getElementById("targets");
  const showOrHide = () => (targets.hidden = !(page.givesTruth && page.settings.truth === "on"));
  return {
    hello: showOrHide,
    settingChanged: showOrHide,
    second() {
      const { truth } = page.scope;
      if (truth && targets.open) listTruth(targets.querySelector("table"), truth, page.settings.unit);
    },
  };
}

/** Fills the table with all bodies: ships and buoys, the nearest first, then land. */
function listTruth(table, truth, unit) {
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
