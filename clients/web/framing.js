// The part of the radar's picture that is on the screen: zoom and centre, in screen axes.

export const MAX_ZOOM = 16; // a cell of the feed then covers about ten pixels; more zoom shows no more detail
const TURN_BACK = 0.75; // of the radius: own ship resets between half and three quarters of it (IMO MSC.192(79), 5.22)

export class Framing {
  constructor() {
    this.zoom = 1;
    this.centre = { x: 0, y: 0 }; // the point in the middle, right of and above own ship [m]
  }

  get isPlain() {
    return this.zoom === 1 && this.centre.x === 0 && this.centre.y === 0;
  }

  /** Shows the whole range with own ship in the middle. */
  reset() {
    this.zoom = 1;
    this.centre = { x: 0, y: 0 };
  }

  /** Zooms by `factor` about the screen point [x, y], by default the middle. */
  zoomBy(factor, view, [x, y] = [view.rim.x, view.rim.y]) {
    const zoom = Math.min(Math.max(this.zoom * factor, 1), MAX_ZOOM);
    const gain = (1 - this.zoom / zoom) / view.metre;
    const centre = { x: this.centre.x + (x - view.rim.x) * gain, y: this.centre.y - (y - view.rim.y) * gain };
    this.zoom = zoom;
    this.moveTo(centre, view.reach);
  }

  /** Moves the picture by CSS pixels. */
  dragBy(right, down, view) {
    this.moveTo({ x: this.centre.x - right / view.metre, y: this.centre.y + down / view.metre }, view.reach);
  }

  /** Moves own ship half a radius behind the middle, to show more ahead. bow: clockwise from the top [rad]. */
  lookAhead(bow, view) {
    const ahead = view.span / 2;
    this.moveTo({ x: ahead * Math.sin(bow), y: ahead * Math.cos(bow) }, view.reach);
  }

  /** Keeps the map where it is while own ship moves by [east, north] [m]. When own ship nears the rim, it starts again on the
   *  other side, on its course: with half a radius of water more ahead. */
  follow([east, north], course, view) {
    const [sin, cos] = [Math.sin(view.up), Math.cos(view.up)];
    const moved = { x: east * cos - north * sin, y: east * sin + north * cos };
    this.moveTo({ x: this.centre.x - moved.x, y: this.centre.y - moved.y }, view.reach);
    if (Math.hypot(this.centre.x, this.centre.y) > TURN_BACK * view.span) this.lookAhead(course - view.up, view);
  }

  /** Moves the middle, which stays within `range` [m] of own ship. */
  moveTo({ x, y }, range) {
    const share = Math.min(1, range / Math.hypot(x, y) || 1);
    this.centre = { x: x * share, y: y * share };
  }
}
