// Positions on the screen. Renderers and overlay take the orientation of the picture from here only.

export const TURN = 2 * Math.PI;

/** The same angle in [0, 2 pi). */
export const wrap = (angle) => ((angle % TURN) + TURN) % TURN;

export class View {
  /** rim {x, y, radius}: the circle that the picture fills [CSS pixels]; range: of the radar [m]; scale: the range [m] at the
   *  rim at zoom 1; centre {x, y}: the point in the middle, right of and above own ship [m]; up: true bearing at the top
   *  [rad]. */
  constructor({ rim, range, scale = range, up, zoom = 1, centre = { x: 0, y: 0 } }) {
    const metre = (rim.radius / scale) * zoom; // CSS pixels
    const reach = Math.max(range, scale); // m: marks and rings end there
    Object.assign(this, { rim, range, reach, up, metre, x: rim.x - centre.x * metre, y: rim.y + centre.y * metre });
  }

  /** Distance from the middle of the picture to its rim [m]. */
  get span() {
    return this.rim.radius / this.metre;
  }

  /** The greatest range in the picture [m]. */
  get maxRange() {
    const { rim, x, y, metre, reach } = this;
    return Math.min((Math.hypot(x - rim.x, y - rim.y) + rim.radius) / metre, reach);
  }

  /** Screen point [x, y] of a true bearing [rad] and a range [m]. */
  toScreen(bearing, range) {
    return this.along(bearing, range * this.metre);
  }

  /** Screen point [x, y] at a true bearing [rad] and a distance [CSS pixels] from own ship. */
  along(bearing, distance) {
    const angle = bearing - this.up; // clockwise from the top
    return [this.x + distance * Math.sin(angle), this.y - distance * Math.cos(angle)];
  }

  /** Distance [CSS pixels] from own ship at which a true bearing [rad] leaves the picture; NaN if it does not cross it. */
  toRim(bearing) {
    const angle = bearing - this.up;
    const [east, south] = [this.x - this.rim.x, this.y - this.rim.y];
    const ahead = east * Math.sin(angle) - south * Math.cos(angle);
    const far = Math.sqrt(ahead ** 2 + this.rim.radius ** 2 - east ** 2 - south ** 2) - ahead;
    return far > 0 ? far : NaN;
  }

  /** Whether a screen point is in the picture. */
  contains(x, y) {
    return Math.hypot(x - this.rim.x, y - this.rim.y) <= this.rim.radius;
  }

  /** True bearing [rad] and range [m] of a screen point. */
  fromScreen(x, y) {
    const east = x - this.x;
    const north = this.y - y;
    return { bearing: wrap(Math.atan2(east, north) + this.up), range: Math.hypot(east, north) / this.metre };
  }
}

/** The true bearing at the top: north-up 0, head-up the heading, course-up the course [rad]. */
export function upOf(orientation, heading, course) {
  return { "north-up": 0, "head-up": heading, "course-up": course }[orientation];
}
