// Ground and sea stabilisation: what course, speed, true motion and true trails are measured against. A tidal stream is the
// velocity of the water over ground [east, north] [m/s].

/** A position [m] at a time [s] as the water has it, which lay on the ground at time 0; stream: null leaves it as it is. */
export function stabilised(position, time, stream) {
  return stream ? position.map((metres, axis) => metres - stream[axis] * time) : position;
}

/** Course [rad] and speed [m/s] through the water of own ship, whose course and speed are over ground; stream: null leaves
 *  them as they are. */
export function throughWater({ course, speed, heading }, stream) {
  if (!stream) return { course, speed };
  const [east, north] = [speed * Math.sin(course) - stream[0], speed * Math.cos(course) - stream[1]];
  const isMoving = Math.hypot(east, north) > 0;
  return { course: isMoving ? Math.atan2(east, north) : heading, speed: Math.hypot(east, north) };
}
