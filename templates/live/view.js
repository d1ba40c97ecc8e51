// The live view: a scene on a canvas, traced by the graphics processor.
//
// view = new LiveView(canvas, scene, volumes); await view.ready; view.set({ alpha: 66 });
//
// It is ready when it can draw: not before the canvas is in sight.
//
// While values change it draws one ray a pixel, and fewer pixels where a frame takes long. At rest it adds rays, up to
// RAYS a pixel, and then stops drawing. It adds them in strips, so that it can move again at once.

"use strict";

class LiveView {
  static RAYS = 64;
  static IDEAL = { ideal: 0, axis: 1, refraction: 2, lenslets: 3, mirror: 4 };
  static BACKGROUNDS = { sky: 0, black: 1, white: 2, transparent: 3 };
  static MOVING = 150;     // ms without a change until the picture is at rest
  static SLOW = 25;        // ms: if drawing takes longer, fewer pixels are drawn at once
  static FAST = 12;        // ms: below, more are
  static LEAST = 0.15;     // of the canvas's width and height: the moving picture's
  static STRIPS = 4;       // of the picture at rest, at most

  // `scene` has the names and units of povgen's scenes. `volumes`: { grid, pieces: { name: { place, data, most } } }.
  // `failed` is called with a sentence if the view cannot be shown, and with null when it can be shown again.
  constructor(canvas, scene, volumes, failed = () => {}) {
    this.scene = { ...scene };
    this.volumes = volumes;
    this.failed = failed;
    this.budget = 1e5;     // pixels that are drawn at once
    this.count = 0;        // rays a pixel in the sum
    this.row = 0;          // of the sum, up to which the next ray has been added
    this.attach(canvas);
    this.ready = this.load().then(
      () => new Promise((done) => {
        this.loaded = done;
        this.hold();
      }),
      (error) => this.failed(`This browser cannot draw the live view: ${error.message}. A newer version may.`),
    );
  }

  // Show the view on this canvas, and on no other any more.
  attach(canvas) {
    this.canvas = canvas;
    const listen = (event, action) => canvas.addEventListener(event, (what) => canvas === this.canvas && action(what));
    listen("webglcontextlost", (event) => {
      event.preventDefault();
      this.pending = null;
      this.lost = true;
      if (this.released) setTimeout(() => this.hold());  // the canvas may be in sight again; a handler cannot restore it
      else this.failed("The browser has stopped this view. It starts again if you scroll it out of sight and back, or reload the page.");
    });
    listen("webglcontextrestored", () => this.start());
    this.observers?.forEach((observer) => observer.disconnect());
    const size = new ResizeObserver(() => this.resize());
    try {
      size.observe(canvas, { box: "device-pixel-content-box" });  // called for another pixel ratio, too
    } catch {
      size.observe(canvas);
    }
    const sight = new IntersectionObserver((changes) => {
      this.inSight = changes.at(-1).isIntersecting;
      this.hold();
    });
    sight.observe(canvas);
    this.observers = [size, sight];
  }

  // Hold a context while the canvas is in sight, and none otherwise: a browser has few for all views, Chromium 16.
  hold() {
    if (!this.loaded) return;
    if (!this.inSight) {
      if (!this.gl || this.gl.isContextLost()) return;
      this.released = true;
      this.loss.loseContext();
    } else if (!this.gl) {
      this.start();
    } else if (this.lost && this.released) {
      this.loss.restoreContext();
    } else if (this.lost) {  // the browser needed it for another view, and may not give it back: only a new canvas gets one
      const canvas = this.canvas.cloneNode();
      this.canvas.replaceWith(canvas);
      this.attach(canvas);
      this.start();
    }
  }

  async load() {
    const names = Object.keys(this.volumes?.pieces ?? {});
    const fields = names.map((name) => volume.field(this.volumes.pieces[name], this.volumes.grid));
    this.fields = await Promise.all(fields);
    this.names = names;
  }

  // Change values of the scene. The view is drawn soon after.
  set(values) {
    Object.assign(this.scene, values);
    this.again();
  }

  // The part of the canvas's pixels a side that the moving picture has.
  get scale() {
    return Math.min(1, Math.max(LiveView.LEAST, Math.sqrt(this.budget / (this.canvas.width * this.canvas.height))));
  }

  converged() {
    return Boolean(this.gl) && !this.gl.isContextLost() && this.count >= LiveView.RAYS;
  }

  // ---- WebGL ----

  start() {
    const gl = this.canvas.getContext("webgl2", { antialias: false, powerPreference: "high-performance" });
    // Rays are summed in textures of 32-bit numbers, or of 16-bit numbers, as on some phones.
    const float = gl?.getExtension("EXT_color_buffer_float");
    this.loaded();
    if (!float && !gl?.getExtension("EXT_color_buffer_half_float")) {
      this.failed("This browser cannot draw the live view: it needs WebGL 2 with EXT_color_buffer_float.");
      return;
    }
    this.format = float ? gl.RGBA32F : gl.RGBA16F;
    this.gl = gl;
    this.loss = gl.getExtension("WEBGL_lose_context");
    this.lost = this.released = false;
    this.programs = {};
    this.targets = {};
    this.kinds = null;
    this.parallel = gl.getExtension("KHR_parallel_shader_compile");
    gl.bindVertexArray(gl.createVertexArray());
    this.makeVolumes();
    this.failed(null);
    this.resize();
    this.again();
    this.hold();
  }

  // All distance fields in one texture: three a row along x, the rows along z.
  makeVolumes() {
    if (!this.names.length) return;
    const { gl } = this;
    const [nx, ny, nz] = this.volumes.grid;
    gl.activeTexture(gl.TEXTURE1);
    gl.bindTexture(gl.TEXTURE_3D, gl.createTexture());
    gl.texStorage3D(gl.TEXTURE_3D, 1, gl.R16F, nx * Math.min(this.names.length, 3), ny, nz * Math.ceil(this.names.length / 3));
    this.fields.forEach((field, k) => {
      const [x, z] = [nx * (k % 3), nz * Math.floor(k / 3)];
      gl.texSubImage3D(gl.TEXTURE_3D, 0, x, 0, z, nx, ny, nz, gl.RED, gl.FLOAT, field);
    });
    for (const axis of [gl.TEXTURE_WRAP_S, gl.TEXTURE_WRAP_T, gl.TEXTURE_WRAP_R]) {
      gl.texParameteri(gl.TEXTURE_3D, axis, gl.CLAMP_TO_EDGE);
    }
    for (const filter of [gl.TEXTURE_MIN_FILTER, gl.TEXTURE_MAG_FILTER]) gl.texParameteri(gl.TEXTURE_3D, filter, gl.LINEAR);
    gl.activeTexture(gl.TEXTURE0);
  }

  // The program that a shader's main function belongs to. It is made anew if the number of objects has changed.
  program(name) {
    const { gl } = this;
    const kinds = {
      WINDOWS: geometry.windows(this.scene).length,
      PIECES: geometry.pieces(this.scene).length,
      SPHERES: this.scene.name === "spheres" ? Math.max(11, geometry.spheres(this.scene).length) : 0,
      VOLUMES: this.names.length,
      CORNERS: geometry.frameSection(this.scene).length,
      GRID: (this.volumes?.grid ?? []).join(", "),
    };
    const defines = Object.entries(kinds).map(([key, value]) => `#define ${key} ${value}\n`).join("");
    if (this.kinds !== defines) {
      for (const { program, shaders } of Object.values(this.programs)) {
        gl.deleteProgram(program);
        shaders.forEach((shader) => gl.deleteShader(shader));
      }
      this.programs = {};
      this.kinds = defines;
    }
    return (this.programs[name] ??= this.compile(defines, name));
  }

  compile(defines, name) {
    const { gl } = this;
    const precision = ["float", "int", "sampler2D", "sampler3D"].map((type) => `precision highp ${type};\n`).join("");
    const head = `#version 300 es\n${precision}${defines}`;
    const parts = name === "display" ? ["display"] : ["objects", "prisms", "materials", "view", name];
    const texts = {
      [gl.VERTEX_SHADER]: `#version 300 es
        void main() { gl_Position = vec4(4 * (gl_VertexID & 1) - 1, 2 * (gl_VertexID & 2) - 1, 0, 1); }`,
      [gl.FRAGMENT_SHADER]: head + parts.map((part) => LiveView.SHADERS[part]).join("\n"),
    };
    const program = gl.createProgram();
    const shaders = Object.entries(texts).map(([kind, text]) => {
      const shader = gl.createShader(Number(kind));
      gl.shaderSource(shader, text);
      gl.compileShader(shader);
      gl.attachShader(program, shader);
      return shader;
    });
    gl.linkProgram(program);
    return { program, shaders };
  }

  // Whether a program can be used without waiting for the compiler.
  compiled(name) {
    const { program } = this.program(name);
    return !this.parallel || this.gl.getProgramParameter(program, this.parallel.COMPLETION_STATUS_KHR);
  }

  // The places and types of a program's uniforms, by their names.
  uniforms(made) {
    const { gl } = this;
    const { program, shaders } = made;
    if (made.uniforms) return made.uniforms;
    if (!gl.getProgramParameter(program, gl.LINK_STATUS) && !gl.isContextLost()) {
      this.failed("This graphics processor cannot draw the live view.");
      throw new Error(shaders.map((shader) => gl.getShaderInfoLog(shader)).join("") + gl.getProgramInfoLog(program));
    }
    made.uniforms = {};
    for (let k = 0; k < gl.getProgramParameter(program, gl.ACTIVE_UNIFORMS); k++) {
      const { name, type } = gl.getActiveUniform(program, k);
      made.uniforms[name.replace("[0]", "")] = { place: gl.getUniformLocation(program, name), type };
    }
    return made.uniforms;
  }

  // Use a program with the scene's values, and others.
  use(name, others) {
    const { gl } = this;
    const made = this.program(name);
    gl.useProgram(made.program);
    const setters = {
      [gl.FLOAT]: "uniform1fv", [gl.FLOAT_VEC2]: "uniform2fv", [gl.FLOAT_VEC3]: "uniform3fv", [gl.FLOAT_VEC4]: "uniform4fv",
      [gl.INT]: "uniform1iv", [gl.BOOL]: "uniform1iv", [gl.SAMPLER_2D]: "uniform1iv", [gl.SAMPLER_3D]: "uniform1iv",
    };
    const values = { ...(name === "display" ? {} : this.values()), ...others };
    for (const [key, { place, type }] of Object.entries(this.uniforms(made))) {
      gl[setters[type]](place, [values[key]].flat(2).map(Number));
    }
  }

  // The shaders' uniforms.
  values() {
    const { scene } = this;
    const windows = geometry.windows(scene), prism = geometry.prism(scene), spheres = geometry.spheres(scene);
    const pieces = geometry.pieces(scene), base = geometry.radians(scene.base_angle);
    const sheets = windows.map(({ sheet, alpha }) => geometry.sheets(scene, sheet, alpha));
    const turned = (angle) => [Math.cos(angle), Math.sin(angle)];
    const centres = sheets.find((pair) => pair.length)?.map(({ centre }) => centre) ?? [];
    const most = Math.max(11, spheres.length);
    return {
      ideal: LiveView.IDEAL[scene.sheet] ?? 0,
      simulated: windows.filter(({ sheet }) => sheet in LiveView.IDEAL).length,
      turn: windows.map(({ alpha }) => turned(geometry.radians(alpha))),
      ratio: scene.ratio,
      axis: scene.axis.map((part) => part / Math.hypot(...scene.axis)),
      eye: [...scene.eye, -scene.z2],
      viewHeight: scene.view,
      background: LiveView.BACKGROUNDS[scene.background],
      window: scene.aperture,
      windowZ: windows.map(({ z }) => z),
      frameDepth: geometry.depth(scene),
      frameSection: geometry.frameSection(scene),
      frameLip: geometry.frameLip(scene),
      hasFloor: scene.name === "chess",
      floorY: geometry.floorY(scene),
      horizon: geometry.horizon(scene),
      sheets: centres.length,
      sheetTurn: sheets.flatMap((pair) => [0, 1].map((k) => turned(pair[k]?.angle ?? 0))),
      sheetCentre: [0, 1].map((k) => centres[k] ?? 0),
      pitch: prism.pitch,
      firstBase: -scene.prisms / 2 + scene.gap / 2,
      prismHeight: prism.height / prism.pitch,
      prismHalf: prism.length / prism.pitch / 2,
      slant: [Math.cos(base), Math.sin(base)],
      glassIndex: scene.index,
      blackTops: scene.tops === "black",
      maxFaces: scene.faces,
      volumes: 1,
      pieceFoot: pieces.map((piece) => piece.foot),
      pedestal: scene.pedestal,
      pedestalHalf: pieces.map((piece) => piece.half),
      pieceColour: pieces.map((piece) => piece.color),
      pieceVolume: pieces.map((piece) => this.names.indexOf(piece.name)),
      volumePlace: this.names.map((name) => this.volumes.pieces[name].place),
      sphereCount: spheres.length,
      spheres: Array.from({ length: most }, (_, k) => (spheres[k] ? [...spheres[k].centre, spheres[k].radius] : [0, 0, 1, 0])),
    };
  }

  // A framebuffer of float textures; made anew if its size has changed.
  target(name, width, height, textures = 1) {
    const { gl } = this;
    const old = this.targets[name];
    if (old && old.width === width && old.height === height) return old;
    if (old) {
      old.textures.forEach((texture) => gl.deleteTexture(texture));
      gl.deleteFramebuffer(old.framebuffer);
    }
    const framebuffer = gl.createFramebuffer();
    gl.bindFramebuffer(gl.FRAMEBUFFER, framebuffer);
    const made = Array.from({ length: textures }, (_, k) => {
      const texture = gl.createTexture();
      gl.bindTexture(gl.TEXTURE_2D, texture);
      gl.texStorage2D(gl.TEXTURE_2D, 1, this.format, width, height);
      for (const filter of [gl.TEXTURE_MIN_FILTER, gl.TEXTURE_MAG_FILTER]) gl.texParameteri(gl.TEXTURE_2D, filter, gl.NEAREST);
      gl.framebufferTexture2D(gl.FRAMEBUFFER, gl.COLOR_ATTACHMENT0 + k, gl.TEXTURE_2D, texture, 0);
      return texture;
    });
    gl.drawBuffers(made.map((_, k) => gl.COLOR_ATTACHMENT0 + k));
    return (this.targets[name] = { width, height, framebuffer, textures: made });
  }

  // Draw on a target, or on the canvas. `rows`: the first row, and how many.
  draw(name, target, size, values, rows = [0, size[1]]) {
    const { gl } = this;
    this.use(name, values);
    gl.bindFramebuffer(gl.FRAMEBUFFER, target?.framebuffer ?? null);
    gl.viewport(0, 0, ...size);
    gl.enable(gl.SCISSOR_TEST);
    gl.scissor(0, rows[0], size[0], rows[1]);
    gl.drawArrays(gl.TRIANGLES, 0, 3);
  }

  // Add ray number `count` to each pixel of a picture, or of some of its rows. Return the sum: a target whose lower left
  // corner holds it. The rays are spread evenly over this part of the pixel's width and height; the first is in the middle.
  addRay(name, size, count, { part = 1, rows } = {}) {
    const { gl, canvas } = this;
    // a moving picture is in a target of the canvas's size, which need not be made anew when the picture's size changes
    const [width, height] = name === "sum" ? [canvas.width, canvas.height] : size;
    const [from, to] = [count & 1, 1 - (count & 1)].map((k) => this.target(name + k, width, height));
    gl.bindTexture(gl.TEXTURE_2D, from.textures[0]);
    const jitter = [0.7548776662466927, 0.5698402909980532].map((step) => part * (((0.5 + count * step) % 1) - 0.5));
    this.draw("picture", to, size, { size, jitter, sum: 0, first: count === 0, rayNumber: count }, rows);
    return to;
  }

  show(sum, size, rays) {
    const { gl, canvas } = this;
    const all = [canvas.width, canvas.height];
    gl.bindTexture(gl.TEXTURE_2D, sum.textures[0]);
    this.draw("display", null, all, { sum: 0, size, rays, canvas: all });
  }

  // ---- Drawing when it is needed ----

  resize() {
    const { canvas } = this;
    const ratio = window.devicePixelRatio || 1;
    const [width, height] = [canvas.clientWidth, canvas.clientHeight].map((side) => Math.max(1, Math.round(side * ratio)));
    if (width === canvas.width && height === canvas.height) return;
    canvas.width = width;
    canvas.height = height;
    this.again();
  }

  again() {
    clearTimeout(this.resting);
    this.count = this.row = 0;
    this.stale = true;
    this.later();
  }

  later() {
    if (!this.gl || this.asked) return;
    this.asked = true;
    requestAnimationFrame(() => this.move());
  }

  // Draw a frame of the moving picture, if the one shown is no longer right.
  move() {
    const { canvas, scale } = this;
    this.asked = false;
    if (this.gl.isContextLost() || this.pending || !this.stale) return;
    if (!this.compiled("picture") || !this.compiled("display")) {
      this.later();
      return;
    }
    const size = [canvas.width, canvas.height].map((pixels) => Math.max(1, Math.round(scale * pixels)));
    this.stale = false;
    this.show(this.addRay("sum", size, 0), size, 1);
    if (size[0] === canvas.width && size[1] === canvas.height) this.count = 1;  // the first ray of the picture at rest
    this.finish(size[0] * size[1], LiveView.MOVING);
  }

  // Add a ray to each pixel of a strip of the picture at rest. The picture is shown when it is complete.
  refine() {
    const { canvas, count, row } = this;
    if (this.gl.isContextLost() || count >= LiveView.RAYS) return;
    const size = [canvas.width, canvas.height];
    const strip = Math.ceil(Math.max(this.budget / size[0], size[1] / LiveView.STRIPS));
    const rows = Math.min(strip, size[1] - row);
    const sum = this.addRay("sum", size, count, { rows: [row, rows] });
    this.row += rows;
    if (this.row === size[1]) {
      this.count++;
      this.row = 0;
      this.show(sum, size, this.count);
    }
    this.finish(rows * size[0], 0);
  }

  // Wait until these pixels are drawn. Then go on: without a change, after `pause` ms, with the picture at rest.
  finish(pixels, pause) {
    const { gl } = this;
    const fence = gl.fenceSync(gl.SYNC_GPU_COMMANDS_COMPLETE, 0), start = performance.now();
    gl.flush();
    this.pending = fence;
    const poll = () => {
      if (this.pending !== fence) return;  // the context has been lost
      if (gl.getSyncParameter(fence, gl.SYNC_STATUS) !== gl.SIGNALED) {
        setTimeout(poll, 1);
        return;
      }
      gl.deleteSync(fence);
      this.pending = null;
      const time = performance.now() - start;
      this.adapt(pixels, time);
      if (this.stale) this.later();
      else this.resting = setTimeout(() => this.refine(), pause);
    };
    setTimeout(poll, 1);
  }

  // Change the number of pixels that are drawn at once, after so many have taken this time, ms.
  adapt(pixels, time) {
    const expected = time * Math.min(1, this.budget / pixels);  // for as many as may be drawn at once
    if (expected > LiveView.SLOW) this.budget *= Math.max(0.25, 0.9 * LiveView.SLOW / expected);
    else if (expected < LiveView.FAST && pixels > 0.9 * this.budget) this.budget *= 1.25;
    const all = this.canvas.width * this.canvas.height;
    this.budget = Math.min(all, Math.max(LiveView.LEAST ** 2 * all, this.budget));
  }

  // ---- Numbers ----

  // What the shader finds for every pixel of a picture of this size: { ray, shown }, four numbers each, see
  // readout.glsl. The rows begin at the bottom.
  readout(width, height) {
    const { gl } = this;
    const target = this.target("readout", width, height, 2);
    const size = [width, height];
    this.draw("readout", target, size, { size, jitter: [0, 0], rayNumber: 0 });
    const read = (k) => {
      const numbers = new Float32Array(4 * width * height);
      gl.readBuffer(gl.COLOR_ATTACHMENT0 + k);
      gl.readPixels(0, 0, width, height, gl.RGBA, gl.FLOAT, numbers);
      return numbers;
    };
    return { ray: read(0), shown: read(1) };
  }

  // The light of each pixel of a picture, by this many rays: four numbers each, the sum of red, green and blue, and the
  // number of rays that are not transparent. The rows begin at the bottom. `part` as for `addRay`.
  light(width, height, rays, part = 1) {
    const { gl } = this;
    let sum;
    for (let count = 0; count < rays; count++) sum = this.addRay("still", [width, height], count, { part });
    gl.bindFramebuffer(gl.FRAMEBUFFER, sum.framebuffer);
    const numbers = new Float32Array(4 * width * height);
    gl.readPixels(0, 0, width, height, gl.RGBA, gl.FLOAT, numbers);
    return numbers;
  }

  // Milliseconds of each of some frames of the canvas's size, one ray a pixel.
  bench(count = 20) {
    const { gl, canvas } = this;
    const times = [], size = [canvas.width, canvas.height];
    for (let k = 0; k <= count; k++) {
      const start = performance.now();
      this.show(this.addRay("still", size, 0), size, 1);
      gl.readPixels(0, 0, 1, 1, gl.RGBA, gl.UNSIGNED_BYTE, new Uint8Array(4));  // waits for the graphics processor
      if (k) times.push(performance.now() - start);  // the first one compiles
    }
    return times;
  }

  // What `bench` measures, in words.
  benchText() {
    const times = this.bench().sort((a, b) => a - b);
    const [median, worst] = [times[times.length >> 1], times[times.length - 1]].map((time) => time.toFixed(1));
    const { width, height } = this.canvas;
    return `${width}x${height}, one ray a pixel: ${(1000 / median).toFixed(1)} frames a second, median ${median} ms, longest ${worst} ms`;
  }
}
