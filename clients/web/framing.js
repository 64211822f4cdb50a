// The part of the radar's picture that is on the screen: zoom and centre, in screen axes.

export const MAX_ZOOM = 16; // a cell of the feed then covers about ten pixels; more zoom shows no more detail

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
    this.moveTo(centre, view.range);
  }

  /** Moves the picture by CSS pixels. */
  dragBy(right, down, view) {
    this.moveTo({ x: this.centre.x - right / view.metre, y: this.centre.y + down / view.metre }, view.range);
  }

  /** Moves own ship half a radius behind the middle, to show more ahead. bow: clockwise from the top [rad]. */
  lookAhead(bow, view) {
    const ahead = view.span / 2;
    this.moveTo({ x: ahead * Math.sin(bow), y: ahead * Math.cos(bow) }, view.range);
  }

  /** Moves the middle, which stays within `range` [m] of own ship. */
  moveTo({ x, y }, range) {
    const share = Math.min(1, range / Math.hypot(x, y) || 1);
    this.centre = { x: x * share, y: y * share };
  }
}
