// SPDX-License-Identifier: BSD-3-Clause
// From how far away all of a box is seen, whatever the shape of the window.

/** @param {number[]} a @param {number[]} b */
const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
/** @param {number[]} a @param {number[]} b */
const cross = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
/** @param {number[]} a */
const unit = (a) => a.map((x) => x / Math.hypot(...a));

/**
 * The distance from the middle of a box at which an eye that looks there sees each of its corners.
 * @param {number[]} reach  of the box @param {number[]} from  direction to the eye @param {number[]} up
 * @param {number} wide  tangent of half the angle across @param {number} high  and of that upwards
 */
export function distanceToFit(reach, from, up, wide, high) {
  const toEye = unit(from), right = unit(cross(up, toEye)), top = cross(toEye, right);
  let distance = 0;
  for (let k = 0; k < 8; k++) {
    const corner = reach.map((length, d) => (k & 1 << d ? length : -length) / 2);
    distance = Math.max(distance, dot(corner, toEye) + Math.max(Math.abs(dot(corner, right)) / wide, Math.abs(dot(corner, top)) / high));
  }
  return distance;
}
