// SPDX-License-Identifier: BSD-3-Clause
// The particles, drawn by three.js: a plane that can be moved and zoomed, or a space that can be turned.
import * as THREE from "three";
import { OrbitControls } from "three/examples/jsm/controls/OrbitControls.js";
import { distanceToFit } from "./fit.js";
import { number, ticks } from "./format.js";

const PHASES = 256, MARGIN = 1.06, FIELD_OF_VIEW = 40;
// Diameters, in distances between particles. In a plane discs leave no gaps, and who is nearest has a pixel, so that larger ones move no
// interface; those that are chosen by chance leave holes, which are one in 10^5 of the plane from 3.8 on.
const FILL = { 2: 1.7, 3: 1.15 }, SCATTERED = { 2: 3.8 / 1.7, 3: 1.4 };

const SQUARE_PX = { plane: "4.0", space: "2.0" }; // of a few pixels a disc would be too few

const vertexShader = `
  attribute float value; attribute float phase;
  uniform float size, scale, lo, hi, byPhase;
  uniform sampler2D map, palette;
  varying vec3 colour; varying float across;
  #ifdef PLANE
  uniform vec4 domain; varying vec2 centre; varying float radius, clips;
  #endif
  void main() {
    vec4 own = texture2D(palette, vec2((phase + 0.5) / ${PHASES}.0, 0.5));
    bool wall = own.a < 0.75;
    colour = own.rgb;
    if (byPhase < 0.5 && !wall) colour = texture2D(map, vec2(clamp((value - lo) / (hi - lo), 0.0, 1.0) * 255.0 / 256.0 + 0.5 / 256.0, 0.5)).rgb;
    vec4 seen = modelViewMatrix * vec4(position, 1.0);
    gl_Position = own.a > 0.25 ? projectionMatrix * seen : vec4(2.0, 2.0, 2.0, 1.0);
    #ifdef PLANE
    across = size * scale + 1.0; // a pixel belongs to whom its middle does, which may be beside it
    centre = position.xy;
    radius = 0.5 * across / scale;
    clips = !wall && all(greaterThanEqual(centre, domain.xy)) && all(lessThanEqual(centre, domain.zw)) ? 1.0 : 0.0;
    #else
    across = max(1.5, (wall ? 0.2 : 1.0) * size * scale / -seen.z);
    #endif
    gl_PointSize = across;
  }`;
const fragmentShader = `
  varying vec3 colour; varying float across;
  #ifdef PLANE
  uniform vec4 domain; varying vec2 centre; varying float radius, clips;
  const float square = ${SQUARE_PX.plane};
  #else
  const float square = ${SQUARE_PX.space};
  #endif
  void main() {
    vec2 at = 2.0 * gl_PointCoord - 1.0;
    float r = dot(at, at);
    if (r > 1.0 && across > square) discard;
    #ifdef PLANE
    vec2 here = centre + radius * vec2(at.x, -at.y);
    if (clips > 0.5 && (any(lessThan(here, domain.xy)) || any(greaterThan(here, domain.zw)))) discard; // fluid is drawn within the domain
    gl_FragDepth = 0.5 * r; // who is nearest is seen
    gl_FragColor = vec4(colour, 1.0);
    #else
    gl_FragColor = vec4(colour * (0.55 + 0.45 * sqrt(max(0.0, 1.0 - r))), 1.0);
    #endif
  }`;

/** @param {number} width  of the texture */
function strip(width) {
  const texture = new THREE.DataTexture(new Uint8Array(4 * width), width, 1, THREE.RGBAFormat);
  texture.minFilter = texture.magFilter = THREE.NearestFilter;
  return texture;
}

/** @param {string} hex @returns {[number, number, number]} */
export function rgb(hex) {
  const [red, green, blue] = [1, 3, 5].map((k) => parseInt(hex.slice(k, k + 2), 16));
  return [red, green, blue];
}

/**
 * @typedef {object} Space
 * @property {2|3} dimensions @property {number[]} min @property {number[]} max @property {number} spacing @property {[number, number, number]} up
 */

export class View {
  /** @param {HTMLElement} place */
  constructor(place) {
    this.place = place;
    this.renderer = new THREE.WebGLRenderer({ antialias: true, preserveDrawingBuffer: true });
    this.renderer.outputColorSpace = THREE.LinearSRGBColorSpace; // the colours are those of the screen already
    this.ink = document.createElement("canvas"); // axes, over the particles
    place.append(this.renderer.domElement, this.ink);
    this.scene = new THREE.Scene();
    this.material = new THREE.ShaderMaterial({
      vertexShader, fragmentShader,
      uniforms: {
        size: { value: 1 }, scale: { value: 1 }, lo: { value: 0 }, hi: { value: 1 }, byPhase: { value: 1 }, domain: { value: new THREE.Vector4() },
        map: { value: strip(256) }, palette: { value: strip(PHASES) },
      },
    });
    this.points = new THREE.Points(new THREE.BufferGeometry(), this.material);
    this.points.frustumCulled = false;
    this.points.visible = false;
    this.box = new THREE.LineSegments(new THREE.BufferGeometry(), new THREE.LineBasicMaterial({ color: 0x808080 }));
    this.box.frustumCulled = false;
    this.scene.add(this.points, this.box);
    this.room = 0;
    this.isHome = true;
    /** @type {Space|null} */
    this.space = null;
    this.stale = true;
    new ResizeObserver(() => this.resize()).observe(place);
  }

  /** Of another case: look at all of it. @param {Space} space */
  setSpace(space) {
    this.space = space;
    this.points.visible = false;
    this.controls?.dispose();
    const [x0, y0, z0 = 0] = space.min, [x1, y1, z1 = 0] = space.max;
    this.centre = new THREE.Vector3((x0 + x1) / 2, (y0 + y1) / 2, (z0 + z1) / 2);
    this.reach = new THREE.Vector3(x1 - x0, y1 - y0, z1 - z0);
    const corners = [];
    const across = (/** @type {number} */ a) => [a & 1 ? x1 : x0, a & 2 ? y1 : y0, a & 4 ? z1 : z0];
    for (let a = 0; a < 2 ** space.dimensions; a++)
      for (let d = 1; d < 2 ** space.dimensions; d *= 2) if (!(a & d)) corners.push(...across(a), ...across(a | d));
    this.box.geometry.dispose();
    this.box.geometry = new THREE.BufferGeometry().setAttribute("position", new THREE.Float32BufferAttribute(corners, 3));
    const plane = space.dimensions === 2;
    this.camera = plane ? new THREE.OrthographicCamera() : new THREE.PerspectiveCamera(FIELD_OF_VIEW);
    if (!plane) this.camera.up.set(...space.up);
    this.controls = new OrbitControls(this.camera, this.renderer.domElement);
    this.controls.enableRotate = !plane;
    this.controls.zoomToCursor = plane;
    this.controls.screenSpacePanning = true;
    if (plane) this.controls.mouseButtons.LEFT = THREE.MOUSE.PAN;
    if (plane) this.controls.touches.ONE = THREE.TOUCH.PAN;
    this.controls.addEventListener("change", () => { this.stale = true; });
    this.controls.addEventListener("start", () => { this.isHome = false; });
    this.material.defines = plane ? { PLANE: 1 } : {};
    this.material.uniforms.domain.value.set(x0, y0, x1, y1);
    this.material.needsUpdate = true;
    this.box.material.depthTest = !plane;
    this.box.renderOrder = 1;
    this.home();
    this.resize();
  }

  /** Show all of the domain. */
  home() {
    if (!this.space) return;
    const size = this.reach.length();
    this.controls.target.copy(this.centre);
    this.isHome = true;
    if (this.space.dimensions === 2) {
      this.camera.position.set(this.centre.x, this.centre.y, size);
      this.camera.near = 0;
      this.camera.far = 2 * size;
      this.camera.zoom = 1;
    } else {
      this.camera.near = size / 100;
      this.camera.far = 20 * size;
    }
    this.resize();
    this.controls.update();
  }

  /** Of a space: as far away as shows all of it in a window of this size, with room for what is written at its corners. @param {number} width @param {number} height */
  stepBack(width, height) {
    const up = new THREE.Vector3(...this.space.up).normalize();
    const side = Math.abs(up.y) > 0.5 ? new THREE.Vector3(0, 0, 1) : new THREE.Vector3(0, -1, 0);
    const right = new THREE.Vector3().crossVectors(up, side);
    const from = side.clone().addScaledVector(right, 0.45).addScaledVector(up, 0.35).normalize();
    const pad = 8 + 0.05 * Math.min(width, height), tangent = Math.tan(FIELD_OF_VIEW * Math.PI / 360);
    const wide = tangent * (width - 2 * pad) / height, high = tangent * (1 - 2 * pad / height);
    this.camera.position.copy(this.centre).addScaledVector(from, distanceToFit(this.reach.toArray(), from.toArray(), up.toArray(), wide, high));
  }

  resize() {
    const width = this.place.clientWidth, height = this.place.clientHeight;
    if (!width || !height) return;
    const ratio = Math.min(2, window.devicePixelRatio || 1);
    this.renderer.setPixelRatio(ratio);
    this.renderer.setSize(width, height);
    this.ink.width = width * ratio;
    this.ink.height = height * ratio;
    if (this.camera instanceof THREE.OrthographicCamera) {
      // Room for the axes: left and below.
      const pads = { left: 52, right: 12, top: 12, bottom: 36 };
      const across = Math.max(1, width - pads.left - pads.right), up = Math.max(1, height - pads.top - pads.bottom);
      const unit = Math.max(MARGIN * this.reach.x / across, MARGIN * this.reach.y / up, 1e-12);
      Object.assign(this.camera, {
        left: -unit * (across / 2 + pads.left), right: unit * (across / 2 + pads.right),
        top: unit * (up / 2 + pads.top), bottom: -unit * (up / 2 + pads.bottom),
      });
    } else if (this.camera) {
      this.camera.aspect = width / height;
      if (this.isHome) this.stepBack(width, height);
      this.controls.update();
    }
    this.camera?.updateProjectionMatrix();
    this.stale = true;
  }

  /** @param {string[]} stops  colours of the map from its lower to its upper end */
  setMap(stops) {
    const texture = this.material.uniforms.map.value, last = stops.length - 1;
    for (let k = 0; k < 256; k++) {
      const at = k / 255 * last, low = Math.min(last - 1, Math.floor(at)), a = rgb(stops[low]), b = rgb(stops[low + 1]);
      texture.image.data.set([0, 1, 2].map((c) => a[c] + (at - low) * (b[c] - a[c])), 4 * k);
      texture.image.data[4 * k + 3] = 255;
    }
    texture.needsUpdate = true;
    this.stale = true;
  }

  /** Walls keep their colour, and in a space they are dots that can be looked through. @param {{colour: string, visible: boolean, wall: boolean}[]} phases */
  setPhases(phases) {
    const texture = this.material.uniforms.palette.value;
    for (let k = 0; k < PHASES; k++) {
      const { colour, visible, wall } = phases[k] ?? { colour: "#808080", visible: true, wall: false };
      texture.image.data.set([...rgb(colour), visible ? (wall ? 128 : 255) : 0], 4 * k);
    }
    texture.needsUpdate = true;
    this.stale = true;
  }

  /** @param {[number, number]|null} ends */
  setRange(ends) {
    if (ends) [this.material.uniforms.lo.value, this.material.uniforms.hi.value] = ends;
    this.stale = true;
  }

  /** @param {import("./frame.js").Frame} frame */
  setFrame(frame) {
    if (!this.space) return;
    const geometry = this.points.geometry, n = frame.particles;
    if (n > this.room || geometry.getAttribute("position")?.itemSize !== frame.dimensions) {
      this.room = Math.ceil(1.2 * n) + 16;
      const add = (/** @type {string} */ name, /** @type {any} */ array, /** @type {number} */ size) =>
        geometry.setAttribute(name, new THREE.BufferAttribute(array, size).setUsage(THREE.DynamicDrawUsage));
      geometry.dispose();
      add("position", new Float32Array(frame.dimensions * this.room), frame.dimensions);
      // three.js would look at all particles, and at what is in no use, for it.
      geometry.boundingSphere = new THREE.Sphere(this.centre, this.reach.length());
      add("value", new Float32Array(this.room), 1);
      add("phase", new Uint8Array(this.room), 1);
    }
    for (const name of /** @type {const} */ (["position", "value", "phase"])) {
      const from = frame[name], attribute = /** @type {THREE.BufferAttribute} */ (geometry.getAttribute(name));
      if (!from) continue;
      attribute.array.set(from);
      attribute.clearUpdateRanges();
      attribute.addUpdateRange(0, from.length);
      attribute.needsUpdate = true;
    }
    geometry.setDrawRange(0, n);
    this.material.uniforms.byPhase.value = frame.value ? 0 : 1;
    // Fewer particles are drawn larger, so that together they fill what all would.
    const larger = frame.every > 1 ? SCATTERED[frame.dimensions] * frame.every ** (1 / frame.dimensions) : 1;
    this.material.uniforms.size.value = FILL[frame.dimensions] * this.space.spacing * larger;
    this.points.visible = n > 0;
    this.stale = true;
  }

  /** Draw, if anything has changed. @param {{ink: string, paper: string}} colours */
  draw(colours) {
    if (!this.camera || !this.stale) return;
    this.stale = false;
    const height = this.renderer.domElement.height;
    const camera = this.camera;
    this.material.uniforms.scale.value = camera instanceof THREE.OrthographicCamera
      ? height * camera.zoom / (camera.top - camera.bottom)
      : height / (2 * Math.tan(camera.fov * Math.PI / 360));
    this.scene.background = new THREE.Color().setStyle(colours.paper, THREE.LinearSRGBColorSpace);
    this.renderer.render(this.scene, camera);
    this.drawInk(colours);
  }

  /** Axes of a plane; names of the directions of a space. @param {{ink: string, paper: string}} colours */
  drawInk({ ink, paper }) {
    const ratio = this.renderer.getPixelRatio(), pen = this.ink.getContext("2d");
    const width = this.ink.width / ratio, height = this.ink.height / ratio;
    pen.setTransform(ratio, 0, 0, ratio, 0, 0);
    pen.clearRect(0, 0, width, height);
    pen.font = "12px system-ui, sans-serif";
    pen.fillStyle = pen.strokeStyle = ink;
    if (this.space.dimensions === 2) this.drawAxes(pen, width, height, paper);
    else this.drawTriad(pen, width, height);
  }

  /** @param {CanvasRenderingContext2D} pen @param {number} width @param {number} height @param {string} paper */
  drawAxes(pen, width, height, paper) {
    const camera = /** @type {THREE.OrthographicCamera} */ (this.camera), left = 52, below = height - 28;
    const x0 = camera.position.x + camera.left / camera.zoom, x1 = camera.position.x + camera.right / camera.zoom;
    const y0 = camera.position.y + camera.bottom / camera.zoom, y1 = camera.position.y + camera.top / camera.zoom;
    const atX = (/** @type {number} */ x) => (x - x0) / (x1 - x0) * width, atY = (/** @type {number} */ y) => (y1 - y) / (y1 - y0) * height;
    pen.fillStyle = paper;
    pen.fillRect(0, 0, left, height);
    pen.fillRect(0, below, width, height - below);
    pen.fillStyle = pen.strokeStyle;
    pen.beginPath();
    pen.textAlign = "center";
    pen.textBaseline = "top";
    for (const x of ticks(x0, x1, width / 90)) {
      const at = Math.round(atX(x)) + 0.5;
      if (at < left || at > width - 16) continue;
      pen.moveTo(at, below);
      pen.lineTo(at, below + 5);
      if (at < width - 44) pen.fillText(number(x, 6), at, below + 8);
    }
    pen.fillText("x (m)", width - 22, below + 8);
    pen.textAlign = "right";
    pen.textBaseline = "middle";
    for (const y of ticks(y0, y1, height / 50)) {
      const at = Math.round(atY(y)) + 0.5;
      if (at > below || at < 6) continue;
      pen.moveTo(left - 5, at);
      pen.lineTo(left, at);
      if (at > 26) pen.fillText(number(y, 6), left - 8, at);
    }
    pen.fillText("y (m)", left - 8, 12);
    pen.moveTo(left + 0.5, 0);
    pen.lineTo(left + 0.5, below + 0.5);
    pen.lineTo(width, below + 0.5);
    pen.stroke();
  }

  /** @param {CanvasRenderingContext2D} pen @param {number} width @param {number} height */
  drawTriad(pen, width, height) {
    const { min, max } = this.space;
    pen.textAlign = "center";
    pen.textBaseline = "middle";
    ["x", "y", "z"].forEach((name, d) => {
      const end = new THREE.Vector3(...min), beyond = new THREE.Vector3(...min);
      end.setComponent(d, max[d]);
      beyond.setComponent(d, max[d] + 0.05 * this.reach.length());
      const at = beyond.project(this.camera);
      if (at.z > 1) return;
      const x = Math.min(Math.max((at.x + 1) / 2 * width, 44), width - 44), y = Math.min(Math.max((1 - at.y) / 2 * height, 10), height - 10);
      pen.fillText(`${name} = ${number(max[d], 4)} m`, x, y);
    });
  }

  /** Keys for who has no mouse. @param {KeyboardEvent} event @returns {boolean} whether it was one of ours */
  key(event) {
    if (!this.camera) return false;
    const plane = this.space.dimensions === 2;
    const moves = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, 1], ArrowDown: [0, -1] };
    const move = moves[/** @type {keyof typeof moves} */ (event.key)];
    const offset = this.camera.position.clone().sub(this.controls.target);
    if (event.key === "Home") this.home();
    else if (event.key === "+" || event.key === "=" || event.key === "-") {
      const factor = event.key === "-" ? 0.8 : 1.25;
      if (plane) this.camera.zoom *= factor;
      else this.camera.position.copy(this.controls.target).addScaledVector(offset, 1 / factor);
      this.camera.updateProjectionMatrix();
    } else if (move && plane) {
      const { left, right, zoom } = /** @type {THREE.OrthographicCamera} */ (this.camera), by = 0.08 * (right - left) / zoom;
      for (const at of [this.camera.position, this.controls.target]) at.add(new THREE.Vector3(by * move[0], by * move[1], 0));
    } else if (move) {
      const up = this.camera.up.clone().normalize(), right = new THREE.Vector3().crossVectors(up, offset).normalize();
      offset.applyAxisAngle(up, -0.12 * move[0]);
      const angle = offset.angleTo(up), turn = Math.min(Math.max(angle - 0.12 * move[1], 0.05), Math.PI - 0.05) - angle;
      offset.applyAxisAngle(right, turn);
      this.camera.position.copy(this.controls.target).add(offset);
    } else return false;
    if (event.key !== "Home") this.isHome = false;
    this.controls.update();
    this.stale = true;
    return true;
  }
}
