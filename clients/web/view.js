// Where things stand on the screen. The one place that says which way is up; the renderers and the furniture all ask here.

export const TURN = 2 * Math.PI;

/** The same angle in [0, 2 pi). */
export const wrap = (angle) => ((angle % TURN) + TURN) % TURN;

export class View {
  /** centre and radius [CSS pixels]; range: at the rim [m]; up: true bearing at the top of the screen [rad]. */
  constructor({ x, y, radius, range, up }) {
    Object.assign(this, { x, y, radius, range, up });
  }

  /** Screen place [x, y] of a true bearing [rad] and a range [m]. */
  toScreen(bearing, range) {
    const r = (range / this.range) * this.radius;
    const angle = bearing - this.up; // clockwise from the top
    return [this.x + r * Math.sin(angle), this.y - r * Math.cos(angle)];
  }

  /** True bearing [rad] and range [m] of a screen place. */
  fromScreen(x, y) {
    const east = x - this.x;
    const north = this.y - y;
    return { bearing: wrap(Math.atan2(east, north) + this.up), range: (Math.hypot(east, north) / this.radius) * this.range };
  }
}

/** The true bearing that stands at the top: north-up 0, head-up the heading, course-up the course [rad]. */
export function upOf(orientation, heading, course) {
  return { "north-up": 0, "head-up": heading, "course-up": course }[orientation];
}
