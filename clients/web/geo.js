// Latitude and longitude of points on the map. The map keeps geodesic distance and bearing from the scene's origin (WGS 84).

const A = 6_378_137; // m, semi-major axis
const F = 1 / 298.257223563;
const B = A * (1 - F);
const DEGREE = Math.PI / 180;
const CLOSE = 1e-12; // rad: 6 micrometres

/** [latitude, longitude] in degrees of a point east and north [m] of `origin` {latitude_deg, longitude_deg}.
 *  The direct geodesic problem, after Vincenty (Survey Review 23, 1975, equations 1 to 11), good to a millimetre anywhere. */
export function geographic(east, north, origin) {
  const [s, azimuth] = [Math.hypot(east, north), Math.atan2(east, north)];
  const [sinA, cosA] = [Math.sin(azimuth), Math.cos(azimuth)];
  const tanU = (1 - F) * Math.tan(origin.latitude_deg * DEGREE);
  const cosU = 1 / Math.hypot(1, tanU);
  const sinU = tanU * cosU;
  const sinAlpha = cosU * sinA; // 2
  const cos2Alpha = 1 - sinAlpha ** 2;
  const start = Math.atan2(tanU, cosA); // 1
  const [sigma, mid] = arc(s, start, (cos2Alpha * (A ** 2 - B ** 2)) / B ** 2);
  const [sin, cos] = [Math.sin(sigma), Math.cos(sigma)];
  const across = Math.hypot(sinAlpha, sinU * sin - cosU * cos * cosA);
  const latitude = Math.atan2(sinU * cos + cosU * sin * cosA, (1 - F) * across); // 8
  const lambda = Math.atan2(sin * sinA, cosU * cos - sinU * sin * cosA); // 9
  const c = (F / 16) * cos2Alpha * (4 + F * (4 - 3 * cos2Alpha)); // 10
  const slip = (1 - c) * F * sinAlpha * (sigma + c * sin * (mid + c * cos * (2 * mid ** 2 - 1))); // 11
  return [latitude / DEGREE, wrapDegrees(origin.longitude_deg + (lambda - slip) / DEGREE)];
}

/** Angle sigma [rad] of a distance s [m] on the auxiliary sphere, and the cosine of twice its midpoint's angle. */
function arc(s, start, u2) {
  const a = 1 + (u2 / 16384) * (4096 + u2 * (-768 + u2 * (320 - 175 * u2))); // 3
  const b = (u2 / 1024) * (256 + u2 * (-128 + u2 * (74 - 47 * u2))); // 4
  let sigma = s / (B * a);
  for (let step = Infinity; Math.abs(step) > CLOSE; ) {
    const mid = Math.cos(2 * start + sigma); // 5
    const [sin, cos] = [Math.sin(sigma), Math.cos(sigma)];
    const inner = cos * (2 * mid ** 2 - 1) - (b / 6) * mid * (4 * sin ** 2 - 3) * (4 * mid ** 2 - 3);
    const next = s / (B * a) + b * sin * (mid + (b / 4) * inner); // 6, 7
    step = next - sigma;
    sigma = next;
  }
  return [sigma, Math.cos(2 * start + sigma)];
}

const wrapDegrees = (longitude) => ((((longitude + 180) % 360) + 360) % 360) - 180;

/** "50°18.000′ N" and "001°24.000′ W" on two lines; the last digit is two metres. */
export function positionText([latitude, longitude]) {
  return `${angleText(latitude, 2, "NS")}\n${angleText(longitude, 3, "EW")}`;
}

function angleText(angle, digits, [positive, negative]) {
  const thousandths = Math.round(Math.abs(angle) * 60_000); // of a minute; rounded once, so that 60.000′ never shows
  const degrees = String(Math.floor(thousandths / 60_000)).padStart(digits, "0");
  const minutes = ((thousandths % 60_000) / 1000).toFixed(3).padStart(6, "0");
  return `${degrees}°${minutes}′ ${angle < 0 ? negative : positive}`;
}

/** [latitude, longitude] of a target at a true bearing [rad] and slant range [m] from an antenna `height` [m] above own
 *  ship's position [east, north] [m]. */
export function geographicPosition({ bearing, range }, position, height, origin) {
  const level = Math.sqrt(Math.max(range ** 2 - height ** 2, 0)); // horizontal range; the earth's curvature changes it less
  return geographic(position[0] + level * Math.sin(bearing), position[1] + level * Math.cos(bearing), origin);
}
