// Scan conversion on the GPU: the polar picture is a texture (bins x azimuths), each pixel of the scope looks itself up in it.

const VERTEX = `#version 300 es
void main() {  // one triangle that covers the whole canvas
  gl_Position = vec4(gl_VertexID == 1 ? 3.0 : -1.0, gl_VertexID == 2 ? 3.0 : -1.0, 0.0, 1.0);
}`;

const FRAGMENT = `#version 300 es
precision highp float;
precision highp sampler2D;
const float TURN = 6.283185307179586;
uniform sampler2D video;   // bins x rows, R8
uniform sampler2D fade;    // 1 x rows, R8
uniform sampler2D colours; // 256 x 1
uniform vec2 centre;       // own ship, pixels from the lower left corner
uniform float radius;      // pixels
uniform float rim;         // range at the rim, m
uniform float up;          // true bearing at the top, rad
uniform float azimuths;
uniform float bins;
uniform float first;       // range of sample 0, m
uniform float cell;        // range step, m
out vec4 pixel;

float cellAt(float u, float v) { return texture(video, vec2(u / bins, v)).r; }

void main() {
  vec2 from = gl_FragCoord.xy - centre;
  float far = length(from);
  if (far > radius) { pixel = vec4(0.0); return; }
  float bearing = atan(from.x, from.y) + up;                // clockwise from north
  float v = bearing / TURN + 0.5 / azimuths;                // a row is centred on its boresight; REPEAT closes the circle
  float u = (far / radius * rim - first) / cell + 0.5;      // and a column on its sample
  float width = rim / radius / cell;                        // bins under this pixel
  float level = cellAt(u, v);
  if (width > 1.0) {                                        // several: the strongest shows, or small targets would flicker away
    float taps = min(ceil(width), 16.0);
    level = 0.0;
    for (float i = 0.5; i < taps; i++) level = max(level, cellAt(floor(u + (i / taps - 0.5) * width) + 0.5, v));
  }
  vec4 scope = texelFetch(colours, ivec2(0, 0), 0);
  vec4 echo = texelFetch(colours, ivec2(int(level * 255.0 + 0.5), 0), 0);
  pixel = mix(scope, echo, texture(fade, vec2(0.5, v)).r);
}`;

export class WebGLRenderer {
  name = "WebGL2";

  /** restored(): called when the GPU, once lost, is back and wants a new picture. Throws where there is no WebGL2. */
  constructor(canvas, restored) {
    this.canvas = canvas;
    this.gl = canvas.getContext("webgl2", { alpha: true, antialias: false, premultipliedAlpha: true });
    if (!this.gl) throw new Error("this browser offers no WebGL2");
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
    this.at = Object.fromEntries(
      ["video", "fade", "colours", "centre", "radius", "rim", "up", "azimuths", "bins", "first", "cell"].map((name) => [
        name,
        gl.getUniformLocation(this.program, name),
      ]),
    );
    gl.pixelStorei(gl.UNPACK_ALIGNMENT, 1);
    this.colours = texture(gl, gl.NEAREST);
    this.fade = texture(gl, gl.LINEAR);
    this.video = null;
    this.polar = null;
    if (this.palette) this.setColours(this.palette);
  }

  /** table: 256 RGBA colours by level. */
  setColours(table) {
    const { gl } = this;
    this.palette = table;
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

  /** Draws `polar` as `view` sees it; grid {first, step}: where the samples stand [m]; scale: device pixels per CSS pixel. */
  draw(polar, grid, view, scale) {
    const { gl, at, canvas } = this;
    if (gl.isContextLost()) return;
    this.upload(polar);
    gl.viewport(0, 0, canvas.width, canvas.height);
    gl.useProgram(this.program);
    [this.video, this.fade, this.colours].forEach((bound, unit) => {
      gl.activeTexture(gl.TEXTURE0 + unit);
      gl.bindTexture(gl.TEXTURE_2D, bound);
    });
    gl.activeTexture(gl.TEXTURE0);
    gl.uniform1i(at.video, 0);
    gl.uniform1i(at.fade, 1);
    gl.uniform1i(at.colours, 2);
    gl.uniform2f(at.centre, view.x * scale, canvas.height - view.y * scale);
    const scalars = { radius: view.radius * scale, rim: view.range, up: view.up, first: grid.first, cell: grid.step };
    Object.assign(scalars, { azimuths: polar.azimuths, bins: polar.bins });
    for (const [name, value] of Object.entries(scalars)) gl.uniform1f(at[name], value);
    gl.drawArrays(gl.TRIANGLES, 0, 3);
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
