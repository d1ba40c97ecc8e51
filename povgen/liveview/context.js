// A WebGL context of the live view: its programs, its textures, and drawing on them. It is of no use when it is lost.

import { camera } from "./presets.js";
import { defines, uniforms } from "./values.js";

const SHADERS = JSON.parse(document.getElementById("shaders").textContent);

export class Context {
  // `format` is that of the sums of rays. `failed` as for LiveView.
  constructor(gl, format, { scene, shapes, failed }) {
    this.gl = gl;
    this.format = format;
    this.scene = scene;
    this.shapes = shapes;
    this.failed = failed;
    this.programs = {};    // by name and by what they are compiled for
    this.targets = {};
    this.textures = {};    // of the pictures
    this.parallel = gl.getExtension("KHR_parallel_shader_compile");
    gl.bindVertexArray(gl.createVertexArray());
  }

  // Make the textures of what has been read.
  fill() {
    this.makeVolumes();
    for (const part of Object.keys(this.shapes.images)) this.makePicture(part);
  }

  // Make the texture of a picture, in the place of an earlier one. Its colours become linear light before they are interpolated.
  makePicture(part) {
    const { gl } = this, image = this.shapes.images[part];
    const { unit, wraps } = { sky: { unit: 2, wraps: [gl.REPEAT, gl.CLAMP_TO_EDGE] }, floor: { unit: 3, wraps: [gl.REPEAT, gl.REPEAT] }, cards: { unit: 4, wraps: [gl.CLAMP_TO_EDGE, gl.CLAMP_TO_EDGE] }, mountains: { unit: 5, wraps: [gl.REPEAT, gl.CLAMP_TO_EDGE] } }[part];
    gl.activeTexture(gl.TEXTURE0 + unit);
    const size = [image.width, image.height], old = this.textures[part];
    if (String(old?.size) !== String(size)) {
      gl.deleteTexture(old?.texture ?? null);
      this.textures[part] = { size, texture: this.texture(gl.TEXTURE_2D, gl.SRGB8_ALPHA8, size, gl.LINEAR, wraps) };
    }
    gl.texSubImage2D(gl.TEXTURE_2D, 0, 0, 0, gl.RGBA, gl.UNSIGNED_BYTE, image);
    gl.activeTexture(gl.TEXTURE0);
  }

  // A new texture at the active unit. `wraps`: what follows beyond its ends, for each axis.
  texture(kind, format, size, filter, wraps = []) {
    const { gl } = this, made = gl.createTexture(), axes = [gl.TEXTURE_WRAP_S, gl.TEXTURE_WRAP_T, gl.TEXTURE_WRAP_R];
    gl.bindTexture(kind, made);
    gl[`texStorage${size.length}D`](kind, 1, format, ...size);
    for (const name of [gl.TEXTURE_MIN_FILTER, gl.TEXTURE_MAG_FILTER]) gl.texParameteri(kind, name, filter);
    wraps.forEach((wrap, k) => gl.texParameteri(kind, axes[k], wrap));
    return made;
  }

  // All distance fields in one texture: three a row along x, the rows along z.
  makeVolumes() {
    const { gl } = this;
    const { names, fields, grid: [nx, ny, nz] } = this.shapes;
    if (!names.length) return;
    gl.activeTexture(gl.TEXTURE1);
    this.texture(gl.TEXTURE_3D, gl.R16F, [nx * Math.min(names.length, 3), ny, nz * Math.ceil(names.length / 3)], gl.LINEAR, Array(3).fill(gl.CLAMP_TO_EDGE));
    gl.activeTexture(gl.TEXTURE0);
    for (const k of fields.keys()) if (fields[k]) this.fillVolume(k);
  }

  // Put the distance field of piece number k into its place.
  fillVolume(k) {
    const { gl } = this, { fields, grid: [nx, ny, nz] } = this.shapes;
    gl.activeTexture(gl.TEXTURE1);
    gl.texSubImage3D(gl.TEXTURE_3D, 0, nx * (k % 3), 0, nz * Math.floor(k / 3), nx, ny, nz, gl.RED, gl.FLOAT, fields[k]);
    gl.activeTexture(gl.TEXTURE0);
  }

  // The program that a shader's main function belongs to. There is one for each kind of scene that has been shown.
  program(name) {
    const kinds = name === "display" ? "" : defines(this.scene, this.shapes);
    return (this.programs[name + kinds] ??= this.compile(kinds, name));
  }

  compile(kinds, name) {
    const { gl } = this;
    const precision = ["float", "int", "sampler2D", "sampler3D"].map((type) => `precision highp ${type};\n`).join("");
    const head = `#version 300 es\n${precision}${kinds}`;
    const parts = name === "display" ? ["display"] : ["windows", "materials", "objects", "prisms", "laws", "view", name];
    const texts = {
      [gl.VERTEX_SHADER]: `#version 300 es
        void main() { gl_Position = vec4(4 * (gl_VertexID & 1) - 1, 2 * (gl_VertexID & 2) - 1, 0, 1); }`,
      [gl.FRAGMENT_SHADER]: head + parts.map((part) => SHADERS[part]).join("\n"),
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
      this.failed("program");
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
    const values = { ...(name === "display" ? {} : uniforms(this.scene, this.shapes)), ...others };
    for (const [key, { place, type }] of Object.entries(this.uniforms(made))) {
      const numbers = [values[key]].flat(Infinity).map(Number);
      if (type === gl.FLOAT_MAT3) gl.uniformMatrix3fv(place, false, numbers);
      else gl[setters[type]](place, numbers);
    }
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
      const texture = this.texture(gl.TEXTURE_2D, this.format, [width, height], gl.NEAREST);
      gl.framebufferTexture2D(gl.FRAMEBUFFER, gl.COLOR_ATTACHMENT0 + k, gl.TEXTURE_2D, texture, 0);
      return texture;
    });
    gl.drawBuffers(made.map((_, k) => gl.COLOR_ATTACHMENT0 + k));
    return (this.targets[name] = { width, height, framebuffer, textures: made });
  }

  // Draw on a target, or on the canvas, from this corner. `rows`: the first row, and how many.
  draw(name, target, size, values, rows = [0, size[1]], corner = [0, 0]) {
    const { gl } = this;
    this.use(name, values);
    gl.bindFramebuffer(gl.FRAMEBUFFER, target?.framebuffer ?? null);
    gl.viewport(...corner, ...size);
    gl.enable(gl.SCISSOR_TEST);
    gl.scissor(corner[0], corner[1] + rows[0], size[0], rows[1]);
    gl.drawArrays(gl.TRIANGLES, 0, 3);
  }

  // Add ray number `count` to each pixel of a picture, or of some of its rows. Return the sum: a target whose lower left
  // corner holds it. For red and cyan glasses, the rays are the left eye's and the right eye's by turns. The rays are spread evenly over this part of the pixel's width and height; the first is in the middle.
  // Of the two targets, the first ray is added to that of number `first`.
  addRay(name, size, count, { part = 1, rows = undefined, first = 1 } = {}) {
    const { gl } = this, { canvas } = gl;
    // a moving picture is in a target of the canvas's size, which need not be made anew when the picture's size changes
    const [width, height] = name === "sum" ? [canvas.width, canvas.height] : size;
    const [from, to] = [1 - first, first].map((k) => k ^ (count & 1)).map((k) => this.target(name + k, width, height));
    gl.bindTexture(gl.TEXTURE_2D, from.textures[0]);
    const side = this.scene.eyes ? 2 * (count % 2) - 1 : 0, rayNumber = side ? count >> 1 : count;
    const jitter = [0.7548776662466927, 0.5698402909980532].map((step) => part * (((0.5 + rayNumber * step) % 1) - 0.5));
    const { eye, right } = camera(this.scene), moved = eye.map((x, k) => x + (side ? side * this.scene.eyes / 2 : 0) * right[k]);
    this.draw("picture", to, size, { size, jitter, sum: 0, first: count === 0, rayNumber, side, eye: moved }, rows);
    return to;
  }

  // Show a sum of this many rays on the canvas.
  show(sum, size, rays) {
    const { gl } = this;
    const all = [gl.canvas.width, gl.canvas.height];
    this.shown = [sum, size, rays];
    gl.bindTexture(gl.TEXTURE_2D, sum.textures[0]);
    this.draw("display", null, all, { sum: 0, size, rays, canvas: all, corner: [0, 0] });
  }

  // Draw what an eye sees, in a picture of this size, on a part of another framebuffer.
  drawEye(camera, size, framebuffer, canvas, corner) {
    const { gl, scene } = this;
    this.scene = { ...scene, camera, eyes: 0 };
    const sum = this.addRay("eye", size, 0);
    this.scene = scene;
    gl.bindTexture(gl.TEXTURE_2D, sum.textures[0]);
    this.draw("display", { framebuffer }, canvas, { sum: 0, size, rays: 1, canvas, corner }, undefined, corner);
  }

  // Show the last sum again: a browser keeps the canvas's pixels only until they have been shown.
  repaint() {
    if (this.shown) this.show(...this.shown);
  }
}
