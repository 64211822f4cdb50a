// Scan conversion on the GPU: the polar picture is a texture (bins x azimuths), which each pixel samples.

import { LONGEST, SIDE, STAMPS, TILE } from "./trails.js";

const VERTEX = `#version 300 es
void main() {  // one triangle that covers the whole canvas
  gl_Position = vec4(gl_VertexID == 1 ? 3.0 : -1.0, gl_VertexID == 2 ? 3.0 : -1.0, 0.0, 1.0);
}`;

const FRAGMENT = `#version 300 es
#define SIDE ${SIDE}.0
#define STAMPS ${STAMPS}.0
#define LONGEST ${LONGEST}.0
precision highp float;
precision highp sampler2D;
const float TURN = 6.283185307179586;
uniform sampler2D video;   // bins x rows, R8
uniform sampler2D fade;    // 1 x rows, R8
uniform sampler2D colours; // 256 x 1
uniform sampler2D trails;  // SIDE x SIDE stamps, R8
uniform vec3 rim;          // of the picture: middle, pixels from the lower left corner, and radius
uniform vec2 ship;         // own ship, likewise
uniform float metre;       // pixels
uniform float range;       // of the radar, m
uniform float up;          // true bearing at the top, rad
uniform float azimuths;
uniform float bins;
uniform float first;       // range of sample 0, m
uniform float cell;        // range step, m
uniform vec3 tint;         // of trails
uniform vec2 origin;       // own ship on the grid of trails, cells
uniform float grid;        // its cell, m
uniform float stamp;       // of new echoes; 0: no trails
out vec4 pixel;

float cellAt(float u, float v) { return texture(video, vec2(u / bins, v)).r; }

float trailAt(vec2 ground) {                                // 1 for new, 0 for none
  ivec2 square = ivec2(floor(mod(origin + ground / grid, SIDE)));
  float then = floor(texelFetch(trails, square, 0).r * 255.0 + 0.5);
  return stamp == 0.0 || then == 0.0 ? 0.0 : max(0.0, 1.0 - mod(stamp - then + STAMPS, STAMPS) / LONGEST);
}

void main() {
  if (length(gl_FragCoord.xy - rim.xy) > rim.z) { pixel = vec4(0.0); return; }
  vec4 scope = texelFetch(colours, ivec2(0, 0), 0);
  pixel = scope;
  vec2 from = gl_FragCoord.xy - ship;
  float distance = length(from) / metre;
  if (distance > range) return;
  float bearing = atan(from.x, from.y) + up;                // clockwise from north
  float v = bearing / TURN + 0.5 / azimuths;                // a row is centred on its boresight; REPEAT wraps north
  float u = (distance - first) / cell + 0.5;                     // and a column on its sample
  float width = 1.0 / metre / cell;                         // bins under this pixel
  float level = cellAt(u, v);
  if (width > 1.0) {                                        // several: show the strongest, or small targets flicker
    float taps = min(ceil(width), 16.0);
    level = 0.0;
    for (float i = 0.5; i < taps; i++) level = max(level, cellAt(floor(u + (i / taps - 0.5) * width) + 0.5, v));
  }
  float trail = trailAt(mat2(cos(up), -sin(up), sin(up), cos(up)) * from / metre);
  if (trail > 0.0) pixel.rgb = mix(scope.rgb, tint, 0.25 + 0.75 * trail);
  vec4 echo = texelFetch(colours, ivec2(int(level * 255.0 + 0.5), 0), 0);
  if (level * 255.0 >= 0.5) pixel = mix(pixel, echo, texture(fade, vec2(0.5, v)).r);
}`;

const UNIFORMS = [
  "video", "fade", "colours", "trails", "rim", "ship", "metre", "range", "up", "azimuths", "bins", "first", "cell",
  "tint", "origin", "grid", "stamp",
];

export class WebGLRenderer {
  name = "WebGL2";

  /** restored(): called when a lost GPU is back and needs a new picture. Throws without WebGL2. */
  constructor(canvas, restored) {
    this.canvas = canvas;
    this.gl = canvas.getContext("webgl2", { alpha: true, antialias: false, premultipliedAlpha: true });
    if (!this.gl) throw new Error("this browser has no WebGL2");
    canvas.addEventListener("webglcontextlost", (event) => event.preventDefault());
    canvas.addEventListener("webglcontextrestored", () => {
      this.build();
      restored();
    });
    this.build();
  }

  build() {
    const { gl } = this;
    this.program = link(gl);
    this.uniforms = Object.fromEntries(UNIFORMS.map((name) => [name, gl.getUniformLocation(this.program, name)]));
    gl.pixelStorei(gl.UNPACK_ALIGNMENT, 1);
    this.colours = texture(gl, gl.NEAREST);
    this.fade = texture(gl, gl.LINEAR);
    this.stamps = texture(gl, gl.NEAREST);
    gl.texStorage2D(gl.TEXTURE_2D, 1, gl.R8, SIDE, SIDE);
    this.video = this.polar = this.trails = null;
    if (this.palette) this.setColours(this.palette, this.tint);
  }

  /** table: 256 RGBA colours by level; tint: of new trails, three shares. */
  setColours(table, tint) {
    const { gl } = this;
    Object.assign(this, { palette: table, tint });
    gl.bindTexture(gl.TEXTURE_2D, this.colours);
    gl.texImage2D(gl.TEXTURE_2D, 0, gl.RGBA8, 256, 1, 0, gl.RGBA, gl.UNSIGNED_BYTE, table);
  }

  upload(polar) {
    const { gl } = this;
    if (polar !== this.polar) this.adopt(polar);
    gl.bindTexture(gl.TEXTURE_2D, this.video);
    for (const [start, stop] of polar.changes()) {
      const rows = polar.video.subarray(start * polar.bins, stop * polar.bins);
      gl.texSubImage2D(gl.TEXTURE_2D, 0, 0, start, polar.bins, stop - start, gl.RED, gl.UNSIGNED_BYTE, rows);
    }
    gl.bindTexture(gl.TEXTURE_2D, this.fade);
    gl.texImage2D(gl.TEXTURE_2D, 0, gl.R8, 1, polar.rows, 0, gl.RED, gl.UNSIGNED_BYTE, polar.fade);
  }

  adopt(polar) {
    const { gl } = this;
    gl.deleteTexture(this.video);
    this.video = texture(gl, gl.LINEAR);
    gl.texStorage2D(gl.TEXTURE_2D, 1, gl.R8, polar.bins, polar.rows);
    polar.dirty.fill(1);
    this.polar = polar;
  }

  uploadTrails(trails) {
    const { gl } = this;
    if (trails !== this.trails) trails.dirty.fill(1);
    this.trails = trails;
    gl.bindTexture(gl.TEXTURE_2D, this.stamps);
    gl.pixelStorei(gl.UNPACK_ROW_LENGTH, SIDE);
    for (const [x, y] of trails.changes()) {
      const tile = trails.stamps.subarray(y * SIDE + x);
      gl.texSubImage2D(gl.TEXTURE_2D, 0, x, y, TILE, TILE, gl.RED, gl.UNSIGNED_BYTE, tile);
    }
    gl.pixelStorei(gl.UNPACK_ROW_LENGTH, 0);
  }

  /** Draws `polar` in `view`. grid {first, step}: ranges of the samples [m]; trails: or null; scale: device pixels per CSS
   *  pixel. */
  draw(polar, grid, view, trails, scale) {
    const { gl, canvas } = this;
    if (gl.isContextLost()) return;
    this.upload(polar);
    if (trails) this.uploadTrails(trails);
    gl.viewport(0, 0, canvas.width, canvas.height);
    gl.useProgram(this.program);
    [this.video, this.fade, this.colours, this.stamps].forEach((bound, unit) => {
      gl.activeTexture(gl.TEXTURE0 + unit);
      gl.bindTexture(gl.TEXTURE_2D, bound);
    });
    gl.activeTexture(gl.TEXTURE0);
    this.setUniforms(polar, grid, view, trails, scale);
    gl.drawArrays(gl.TRIANGLES, 0, 3);
  }

  /** Sets the shader's uniforms. */
  setUniforms(polar, grid, view, trails, scale) {
    const { gl, uniforms, canvas } = this;
    const pixel = (x, y) => [x * scale, canvas.height - y * scale];
    ["video", "fade", "colours", "trails"].forEach((name, unit) => gl.uniform1i(uniforms[name], unit));
    gl.uniform3f(uniforms.rim, ...pixel(view.rim.x, view.rim.y), view.rim.radius * scale);
    gl.uniform2f(uniforms.ship, ...pixel(view.x, view.y));
    gl.uniform3f(uniforms.tint, ...this.tint);
    gl.uniform2f(uniforms.origin, ...(trails?.origin ?? [0, 0]));
    const scalars = { metre: view.metre * scale, range: view.range, up: view.up, first: grid.first, cell: grid.step };
    Object.assign(scalars, { azimuths: polar.azimuths, bins: polar.bins });
    Object.assign(scalars, { grid: trails?.cell ?? 1, stamp: trails?.stamp ?? 0 });
    for (const [name, value] of Object.entries(scalars)) gl.uniform1f(uniforms[name], value);
  }
}

function texture(gl, filter) {
  const made = gl.createTexture();
  gl.bindTexture(gl.TEXTURE_2D, made);
  gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_MIN_FILTER, filter);
  gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_MAG_FILTER, filter);
  gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_WRAP_S, gl.CLAMP_TO_EDGE);
  gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_WRAP_T, gl.REPEAT);
  return made;
}

function link(gl) {
  const program = gl.createProgram();
  for (const [kind, source] of [[gl.VERTEX_SHADER, VERTEX], [gl.FRAGMENT_SHADER, FRAGMENT]]) {
    const shader = gl.createShader(kind);
    gl.shaderSource(shader, source);
    gl.compileShader(shader);
    if (!gl.getShaderParameter(shader, gl.COMPILE_STATUS)) throw new Error(`shader: ${gl.getShaderInfoLog(shader)}`);
    gl.attachShader(program, shader);
  }
  gl.linkProgram(program);
  if (!gl.getProgramParameter(program, gl.LINK_STATUS)) throw new Error(`shaders: ${gl.getProgramInfoLog(program)}`);
  return program;
}
