// The page's address names what the page shows and follows it, so that a reload or a link shows the same.

const WRITE_MS = 300; // between changes: browsers allow some hundred in 30 s
let waiting = null;

/** The value of an option in the address; null if it is absent. */
export const addressValue = (name) => new URLSearchParams(location.search).get(name);

/** Sets options in the address; null removes one. */
export function setAddress(values) {
  if (!waiting) setTimeout(write, WRITE_MS);
  waiting = { ...waiting, ...values };
}

function write() {
  const options = new URLSearchParams(location.search);
  for (const [name, value] of Object.entries(waiting)) value === null ? options.delete(name) : options.set(name, value);
  waiting = null;
  const query = options.toString().replaceAll("%2C", ",");
  history.replaceState(history.state, "", `${location.pathname}${query && `?${query}`}${location.hash}`);
}

/** Writes framing, EBL and VRM of the scope to the address. longest: the scale of the radar's whole range [m]. */
export function followScope({ scale, framing, marker, isTrueMotion }, longest) {
  const { zoom, centre } = framing;
  const isCentred = isTrueMotion || (centre.x === 0 && centre.y === 0); // in true motion the centre moves
  setAddress({
    range: scale === longest ? null : short(scale),
    zoom: zoom === 1 ? null : short(zoom),
    centre: isCentred ? null : `${short(centre.x)},${short(centre.y)}`,
    ebl: marker && `${short((marker.bearing * 180) / Math.PI)},${short(marker.range)}`,
  });
}

/** Sets the scope to framing, EBL and VRM of the address. A shorter range is shown by zoom: a link commands no radar. */
export function adoptAddress(scope) {
  const [zoom = 1] = numbers("zoom");
  const [range = scope.scale] = numbers("range");
  const [x = 0, y = 0] = numbers("centre");
  const [bearing, far] = numbers("ebl");
  scope.framing.zoomBy((zoom * scope.scale) / range, scope.view);
  scope.framing.moveTo({ x, y }, scope.view.reach);
  if (far > 0) scope.marker = { bearing: (bearing * Math.PI) / 180, range: far };
  scope.changed = true;
}

const short = (value) => String(Number(value.toFixed(2)));

/** The numbers of an option such as "45,1852"; none if it has anything else, or a leading zero or negative value of a size. */
function numbers(name) {
  const values = (addressValue(name) ?? "").split(",").map((text) => (text.trim() ? Number(text) : NaN));
  const isSize = name === "zoom" || name === "range";
  return values.every((value) => Number.isFinite(value) && (!isSize || value > 0)) ? values : [];
}
