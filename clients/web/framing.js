// What part of the radar's picture is on the screen: zoom and off-centre. Angles and places as the screen has them.

export const MOST_ZOOM = 16; // a cell of the feed is then some ten pixels: beyond it nothing is gained

export class Framing {
  constructor() {
    this.zoom = 1;
    this.centre = { x: 0, y: 0 }; // what stands in the middle, right of and above own ship [m]
  }

  get isPlain() {
    return this.zoom === 1 && this.centre.x === 0 && this.centre.y === 0;
  }

  /** Own ship in the middle, the whole range on the screen. */
  reset() {
    this.zoom = 1;
    this.centre = { x: 0, y: 0 };
  }

  /** Zooms by `factor` while what is at the screen place [x, y] stays there; by default the middle. */
  zoomBy(factor, view, [x, y] = [view.rim.x, view.rim.y]) {
    const zoom = Math.min(Math.max(this.zoom * factor, 1), MOST_ZOOM);
    const gain = (1 - this.zoom / zoom) / view.metre;
    const centre = { x: this.centre.x + (x - view.rim.x) * gain, y: this.centre.y - (y - view.rim.y) * gain };
    this.zoom = zoom;
    this.moveTo(centre, view.range);
  }

  /** Moves the picture by CSS pixels, as a hand would. */
  dragBy(right, down, view) {
    this.moveTo({ x: this.centre.x - right / view.metre, y: this.centre.y + down / view.metre }, view.range);
  }

  /** Puts own ship half a radius behind the middle, for more sight ahead. bow: clockwise from the top [rad]. */
  lookAhead(bow, view) {
    const ahead = view.span / 2;
    this.moveTo({ x: ahead * Math.sin(bow), y: ahead * Math.cos(bow) }, view.range);
  }

  /** The middle stays within `range` [m] of own ship: beyond it there is nothing to see. */
  moveTo({ x, y }, range) {
    const share = Math.min(1, range / Math.hypot(x, y) || 1);
    this.centre = { x: x * share, y: y * share };
  }
}
