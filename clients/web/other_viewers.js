// Finds what other viewers have changed on the radar, and says it in words.

import { rangeText, scaleFor } from "./units.js";

const ROUNDING = 1e-6; // of a value, relative

/** Sentences about controls that have changed, although this page has not sent their values. definitions: of the controls;
 *  before, after: their values by name; sent: the values that this page has sent; unit: "nm" or "m". */
export function changesByOthers(definitions, before, after, sent, unit) {
  const changed = definitions.filter(({ name }) => name in before && name in after && differs(before[name], after[name]));
  const expected = ({ name, kind }) => (kind === "pace" ? { ...before[name], ...sent[name] } : sent[name]);
  const others = changed.filter((control) => differs(expected(control), after[control.name]));
  return others.map((control) => `${sentence(control, before[control.name], after[control.name], unit)} by another viewer`);
}

/** Whether two values of a control differ to the eye: a step is a pause. */
function differs(one, other) {
  if (one === null || other === null) return one !== other;
  if (typeof one === "number") return Math.abs(one - other) > ROUNDING * Math.abs(one);
  if (typeof one !== "object") return one !== other;
  return isRunning(one) !== isRunning(other) || (one.factor ?? other.factor) !== (other.factor ?? one.factor);
}

const isRunning = (pace) => (pace.state ?? "run") === "run";

function sentence({ name, kind, label, label_off, unit: own }, before, after, unit) {
  if (name === "range_m") return `Range set to ${rangeText(scaleFor(after, unit), unit)}`;
  if (kind === "switch") return after ? `${label} switched on` : label_off ? `${label_off} set` : `${label} switched off`;
  if (kind !== "pace") return `${label} set to ${Number(after.toPrecision(4))}${own === "%" ? " %" : own ? ` ${own}` : ""}`;
  if (isRunning(before) !== isRunning(after)) return isRunning(after) ? "Simulation resumed" : "Simulation paused";
  return after.factor === "max" ? "Speed set to as fast as possible" : `Speed set to ${after.factor}×`;
}
