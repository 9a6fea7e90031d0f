import type { Vector } from "../state/types";
import type { PoseMessage, Xyz, Xyzw } from "./messages";

/** x, y, z, w; of length 1. */
export type Quaternion = readonly [number, number, number, number];

/** Where something is and how it is turned, in a frame. */
export interface Pose {
  position: Readonly<Vector>;
  orientation: Quaternion;
}

export const IDENTITY: Pose = { position: [0, 0, 0], orientation: [0, 0, 0, 1] };

export const poseFrom = (position: Xyz, orientation: Xyzw): Pose => ({
  position: [position.x, position.y, position.z],
  orientation: unit([orientation.x, orientation.y, orientation.z, orientation.w]),
});

export const poseOf = (message: PoseMessage): Pose => poseFrom(message.position, message.orientation);

/** A quaternion of length 1; one of length 0 means no rotation, as in ROS. */
export function unit(q: Quaternion): Quaternion {
  const length = Math.hypot(...q);
  return length === 0 ? [0, 0, 0, 1] : [q[0] / length, q[1] / length, q[2] / length, q[3] / length];
}

export const multiply = (
  [ax, ay, az, aw]: Quaternion,
  [bx, by, bz, bw]: Quaternion,
): [number, number, number, number] => [
  aw * bx + ax * bw + ay * bz - az * by,
  aw * by - ax * bz + ay * bw + az * bx,
  aw * bz + ax * by - ay * bx + az * bw,
  aw * bw - ax * bx - ay * by - az * bz,
];

/** A vector turned by a quaternion: v + 2w(q × v) + 2q × (q × v). */
export function rotate([x, y, z, w]: Quaternion, [vx, vy, vz]: Readonly<Vector>): Vector {
  const tx = 2 * (y * vz - z * vy);
  const ty = 2 * (z * vx - x * vz);
  const tz = 2 * (x * vy - y * vx);
  return [vx + w * tx + y * tz - z * ty, vy + w * ty + z * tx - x * tz, vz + w * tz + x * ty - y * tx];
}

/** Where a point given in a pose's own axes is in the pose's frame. */
export function transform(pose: Pose, point: Readonly<Vector>): Vector {
  const [x, y, z] = rotate(pose.orientation, point);
  return [x + pose.position[0], y + pose.position[1], z + pose.position[2]];
}

/** The pose of something that is at `inner` in the axes of `outer`. */
export const compose = (outer: Pose, inner: Pose): Pose => ({
  position: transform(outer, inner.position),
  orientation: multiply(outer.orientation, inner.orientation),
});

/** Roll, pitch and yaw (rad): turned about x, then y, then z of the fixed axes, as in SDF and URDF. */
export function rollPitchYaw([x, y, z, w]: Quaternion): Vector {
  const up = Math.min(1, Math.max(-1, 2 * (w * y - z * x)));
  return [
    Math.atan2(2 * (w * x + y * z), 1 - 2 * (x * x + y * y)),
    Math.asin(up),
    Math.atan2(2 * (w * z + x * y), 1 - 2 * (y * y + z * z)),
  ];
}

export const yawOf = (orientation: Quaternion): number => rollPitchYaw(orientation)[2];

export function fromRollPitchYaw(roll: number, pitch: number, yaw: number): Quaternion {
  const about = (axis: 0 | 1 | 2, angle: number): Quaternion => {
    const s = Math.sin(angle / 2);
    return [axis === 0 ? s : 0, axis === 1 ? s : 0, axis === 2 ? s : 0, Math.cos(angle / 2)];
  };
  return multiply(about(2, yaw), multiply(about(1, pitch), about(0, roll)));
}
