/** sensor_msgs/LaserScan, as far as it is drawn. */
export interface LaserScan {
  angle_min: number;
  angle_increment: number;
  range_min: number;
  range_max: number;
  ranges: Float32Array;
}

const FRUSTUM_M = 1;

/** The edges of what a camera sees up to a distance, as pairs of points; it looks along x, with z up. */
export function frustumLines(fov_rad: number, aspect: number): Float32Array {
  const y = FRUSTUM_M * Math.tan(fov_rad / 2);
  const z = y / aspect;
  const corners = [
    [FRUSTUM_M, y, z],
    [FRUSTUM_M, -y, z],
    [FRUSTUM_M, -y, -z],
    [FRUSTUM_M, y, -z],
  ];
  return new Float32Array(
    corners.flatMap((corner, at) => [0, 0, 0, ...corner, ...corner, ...(corners[(at + 1) % 4] ?? [])]),
  );
}

/**
 * Writes the rays of a scan that hit something, as pairs of points in the scanner's own axes. Returns the number of
 * points; `lines` holds 6 numbers for each ray.
 */
export function writeRays(scan: LaserScan, lines: Float32Array): number {
  let at = 0;
  for (let ray = 0; ray < scan.ranges.length && at + 6 <= lines.length; ray++) {
    const range = scan.ranges[ray] ?? Infinity;
    if (!(range >= scan.range_min && range <= scan.range_max)) continue;
    const angle = scan.angle_min + ray * scan.angle_increment;
    lines.set([0, 0, 0, range * Math.cos(angle), range * Math.sin(angle), 0], at);
    at += 6;
  }
  return at / 3;
}
