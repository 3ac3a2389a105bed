// SPDX-License-Identifier: BSD-3-Clause
// A picture's worth of particles, as the gateway sends it: README.md has the layout.

/**
 * @typedef {object} Frame
 * @property {number} step @property {number} time @property {number} particles  how many came
 * @property {number} all  how many there are @property {number} every  one in how many came
 * @property {2|3} dimensions @property {string} field @property {string} unit @property {boolean} magnitude @property {boolean} walls
 * @property {number} skipped  pictures that gave way to newer ones, in all
 * @property {Float32Array} position @property {Float32Array|null} value @property {Uint8Array} phase
 */

/** @param {ArrayBuffer} buffer @returns {Frame}  views into the buffer */
export function decode(buffer) {
  const numbers = new DataView(buffer);
  if (buffer.byteLength < 8) throw new RangeError("a frame has no header");
  const length = numbers.getUint32(0, true), skipped = numbers.getUint32(4, true);
  if (length % 4 || 8 + length > buffer.byteLength) throw new RangeError("a frame is shorter than its header");
  const header = JSON.parse(new TextDecoder().decode(new Uint8Array(buffer, 8, length)));
  const n = header.particles, dimensions = header.dimensions, hasValue = header.field !== "phase";
  let at = 8 + length;
  if (buffer.byteLength !== at + n * (4 * dimensions + (hasValue ? 4 : 0) + 1)) throw new RangeError("a frame has another size than it says");
  const position = new Float32Array(buffer, at, n * dimensions);
  at += 4 * n * dimensions;
  const value = hasValue ? new Float32Array(buffer, at, n) : null;
  at += hasValue ? 4 * n : 0;
  return { ...header, skipped, position, value, phase: new Uint8Array(buffer, at, n) };
}
