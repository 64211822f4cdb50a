// Reads colours from the style sheet (custom properties on :root): one block of CSS is one palette.

/** The value of a custom property of the current palette, e.g. colour("--ring"). */
export function colour(name) {
  return getComputedStyle(document.documentElement).getPropertyValue(name).trim();
}

function rgb(name) {
  const hex = colour(name);
  if (!/^#[0-9a-f]{6}$/i.test(hex)) throw new Error(`${name}: "${hex}" is not a colour such as #20c0ff; correct style.css`);
  return [1, 3, 5].map((i) => parseInt(hex.slice(i, i + 2), 16));
}

/** The colour of new trails: three shares of full brightness. */
export const trailTint = () => rgb("--trail").map((channel) => channel / 255);

/** 256 RGBA colours by level: 0 is the background, then faint to strong echoes of rising brightness. */
export function echoColours() {
  const stops = [[1, rgb("--echo-faint")], [110, rgb("--echo")], [255, rgb("--echo-strong")]];
  const table = new Uint8Array(256 * 4).fill(255);
  table.set(rgb("--scope"), 0);
  for (let level = 1; level < 256; level++) {
    const [low, high] = level <= 110 ? stops.slice(0, 2) : stops.slice(1);
    const share = (level - low[0]) / (high[0] - low[0]);
    table.set(low[1].map((c, i) => Math.round(c + share * (high[1][i] - c))), level * 4);
  }
  return table;
}
