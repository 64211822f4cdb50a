// The colours of the current palette: lines and words from the style sheet (custom properties on :root), echoes from palettes.js.

import { PALETTES } from "./palettes.js";

/** The value of a custom property of the current palette, e.g. colour("--ring"). */
export function colour(name) {
  return getComputedStyle(document.documentElement).getPropertyValue(name).trim();
}

function rgb(name) {
  const hex = colour(name);
  if (!/^#[0-9a-f]{6}$/i.test(hex)) throw new Error(`${name}: "${hex}" is not a colour such as #20c0ff; correct style.css`);
  return channels(hex);
}

const channels = (hex) => [1, 3, 5].map((i) => parseInt(hex.slice(i, i + 2), 16));

/** The colour of new trails: three shares of full brightness. */
export const trailTint = () => rgb("--trail").map((channel) => channel / 255);

/** 256 RGBA colours by level: 0 is the sea, then faint to strong echoes of rising lightness. */
export function echoColours() {
  const [sea, ...stops] = PALETTES[document.documentElement.dataset.palette];
  const table = new Uint8Array(256 * 4).fill(255);
  table.set(channels(sea[1]), 0);
  for (let k = 1; k < stops.length; k++) {
    const [[low, from], [high, to]] = stops.slice(k - 1, k + 1).map(([level, hex]) => [level, channels(hex)]);
    for (let level = low; level <= high; level++) {
      const share = (level - low) / (high - low);
      table.set(from.map((c, i) => Math.round(c + share * (to[i] - c))), level * 4);
    }
  }
  return table;
}
