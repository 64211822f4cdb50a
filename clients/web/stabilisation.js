// Ground and sea stabilisation: what course, speed, true motion and true trails are measured against. A tidal stream is the
// velocity of the water over ground [east, north] [m/s]. The currents of a scene are {stream, streams}, as hello has them: a
// stream everywhere, and areas whose streams add to it (world/currents.py).

/** The currents of a hello's scene; null: it has none. */
export function currentsOf({ stream, streams }) {
  return stream ? { stream, streams: streams ?? [] } : null;
}

/** The stream at a position [m]. */
export function streamAt(position, { stream, streams }) {
  return streams.reduce((sum, area) => {
    const u = Math.min(Math.max(depthIn(area, position) / area.border + 0.5, 0), 1);
    return sum.map((speed, axis) => speed + u * u * (3 - 2 * u) * area.stream[axis]);
  }, stream);
}

/** How deep [m] a position lies behind the border of an area; below 0 outside. */
function depthIn({ corners, radius }, [east, north]) {
  if (radius) return radius - Math.hypot(east - corners[0][0], north - corners[0][1]);
  let [nearest, inside] = [Infinity, false];
  corners.forEach(([x, y], k) => {
    const [dx, dy] = [corners[(k + 1) % corners.length][0] - x, corners[(k + 1) % corners.length][1] - y];
    const share = Math.min(Math.max(((east - x) * dx + (north - y) * dy) / (dx * dx + dy * dy || 1), 0), 1);
    nearest = Math.min(nearest, Math.hypot(east - x - share * dx, north - y - share * dy));
    if (north < y !== north < y + dy && east - x < ((north - y) * dx) / dy) inside = !inside;
  });
  return inside ? nearest : -nearest;
}

/** The way of the water at own ship, summed from spoke to spoke. */
export class WaterTrack {
  constructor() {
    this.way = [0, 0]; // [m]
    this.time = null; // of the last spoke [s]
  }

  /** A position [m] of own ship at a time [s] as the water has it. */
  through(position, time, currents) {
    const stream = streamAt(position, currents);
    this.way = this.way.map((metres, axis) => metres + stream[axis] * (time - (this.time ?? time)));
    this.time = time;
    return position.map((metres, axis) => metres - this.way[axis]);
  }
}

/** Course [rad] and speed [m/s] through the water of own ship, whose course and speed are over ground; stream: null leaves
 *  them as they are. */
export function throughWater({ course, speed, heading }, stream) {
  if (!stream) return { course, speed };
  const [east, north] = [speed * Math.sin(course) - stream[0], speed * Math.cos(course) - stream[1]];
  const isMoving = Math.hypot(east, north) > 0;
  return { course: isMoving ? Math.atan2(east, north) : heading, speed: Math.hypot(east, north) };
}
