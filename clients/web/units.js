// Text for ranges and bearings, and round steps for rings and range scales.

import { wrap } from "./view.js";

const NAUTICAL_MILE = 1852; // m, exact
const NAUTICAL = [0.125, 0.25, 0.5, 0.75, 1.5, 3, 6, 12, 24, 48, 96]; // NM; 0.25 to 24 are mandatory (IMO MSC.192(79))
const METRIC = [125, 250, 500, 750, 1500, 3000, 6000, 12_000, 24_000, 48_000, 96_000, 192_000]; // m
const COVERED = 0.9; // of the radar's range: a little more than a scale stays beyond the rim, where dragging shows it

const UNITS = {
  nm: { metres: NAUTICAL_MILE, digits: 2, scales: NAUTICAL.map((nm) => nm * NAUTICAL_MILE), text: (m) => `${trim(m / NAUTICAL_MILE, m < NAUTICAL_MILE / 2 ? 3 : 2)} NM` },
  m: { metres: 1, digits: 0, scales: METRIC, text: (m) => (m >= 10_000 ? `${trim(m / 1000, 2)} km` : `${trim(m, m < 100 ? 1 : 0)} m`) },
};

function trim(value, digits) {
  return String(Number(value.toFixed(digits)));
}

/** Text of a range [m] without its unit, for a column whose head has unitName(unit). */
export const rangeNumber = (metres, unit) => trim(metres / UNITS[unit].metres, UNITS[unit].digits);
export const unitName = (unit) => (unit === "nm" ? "NM" : unit);

/** Text of a range [m] in a unit, "nm" or "m". */
export const rangeText = (metres, unit) => UNITS[unit].text(metres);

/** Text of a bearing [rad]: three digits and a tenth of a degree, 007.5°, or with digits = 0, 008°. */
export function bearingText(angle, digits = 1) {
  const steps = 10 ** digits;
  const rounded = Math.round((wrap(angle) * 180 * steps) / Math.PI) % (360 * steps);
  return `${(rounded / steps).toFixed(digits).padStart(digits ? 5 : 3, "0")}°`;
}

const SLACK = 1 - 1e-3; // the last cell ends up to one cell before a round range: 4999.3 m is a picture of 5 km

/** Distance [m] between range rings: a round number that gives three to six rings out to `range` [m]. */
export function ringStep(range, unit) {
  const { metres } = UNITS[unit];
  const minimum = (range / metres / 6) * SLACK;
  if (unit === "nm") return 2 ** Math.ceil(Math.log2(minimum)) * metres; // nautical miles: 1/4, 1/2, 1, 2
  const decade = 10 ** Math.floor(Math.log10(minimum));
  return [1, 2, 5, 10].find((step) => step * decade >= minimum) * decade * metres;
}

/** The standard range scales [m] of a radar that sees to `longest` [m]; the last one shows nine tenths of it or more. */
export function rangeScales(longest, unit) {
  const { scales } = UNITS[unit];
  const last = scales.findIndex((scale) => scale >= longest * COVERED);
  return last < 0 ? scales : scales.slice(0, last + 1);
}

/** The standard scale [m] on which a picture out to `range` [m] is shown. */
export const scaleFor = (range, unit) => rangeScales(range, unit).at(-1);
