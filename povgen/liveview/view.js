// The live view: a scene on a canvas, traced by the graphics processor.
//
// view = new LiveView(canvas, scene, volumes); await view.ready; view.set({ alpha: 66 });
//
// It is ready when it can draw: not before the canvas is in sight.

import { Context } from "./context.js";
import { Schedule } from "./scheduling.js";
import { field } from "./pieceShape.js";
import { objects } from "./presets.js";

const MOUNTAINS = { data: document.getElementById("mountains").textContent };

export class LiveView extends Schedule {
  // `scene` has the names and units of povgen's scenes. `volumes`: { grid, pieces: { name: { place, data, most } } }.
  // If the view cannot be shown, `failed` is called with a name of the table `failures` (povgen/liveview/languages/), and with what
  // the browser says; with null when it can be shown again.
  /** @param {(why: string | null, reason?: string) => void} failed */
  constructor(canvas, scene, volumes, failed = () => {}) {
    super();
    this.scene = { ...scene };
    this.sky = this.ownSky = null;  // a picture in the place of the scene's sky; the scene's own
    this.failed = failed;
    this.attach(canvas);
    this.shapes = named(volumes);
    this.loadingFirst = this.loadShown(volumes);
    this.loading = this.loadingFirst.then(() => this.loadRest(volumes));  // all pieces
    this.ready = /** @type {Promise<void>} */ (new Promise((done) => (this.settled = done)));
    this.loading.catch((error) => {
      this.failed("browser", error.message);
      this.settled();
    });
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
      else this.failed("stopped");
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

  // Hold a context while the canvas is in sight, and none otherwise: a browser has few for all views, Chromium 16. But a canvas that
  // its own page has hidden comes back soon: another context would have to make the shaders first, which takes seconds.
  hold() {
    if (!this.inSight) {
      if (!this.gl || this.gl.isContextLost() || !this.canvas.checkVisibility()) return;
      this.released = true;
      this.loss.loseContext();
    } else if (!this.context) {
      this.start();
    } else if (this.lost && this.released) {
      this.loss.restoreContext();
    } else if (this.lost) {  // the browser needed it for another view, and may not give it back: only a new canvas gets one
      const canvas = this.canvas.cloneNode();
      this.canvas.replaceWith(canvas);
      this.attach(canvas);
      this.start();
    } else this.again();  // it was hidden
  }

  // Change values of the scene. The view is drawn soon after, if they are new.
  set(values) {
    if (!this.sky && Object.entries(values).every(([name, value]) => same(value, this.scene[name]))) return;
    Object.assign(this.scene, values);
    if (this.sky) this.scene.pictures = { ...this.scene.pictures, sky: this.sky };
    this.again();
  }

  // Show a picture of all directions, an image or a canvas, in the place of the scene's sky; with null, the sky again.
  setSky(picture) {
    if (!this.gl) return;
    const { images } = this.shapes;
    this.ownSky ??= { image: images.sky, value: this.scene.pictures.sky };
    images.sky = picture ?? this.ownSky.image;
    this.sky = picture ? {} : null;
    const shown = this.sky ?? this.ownSky.value;
    this.scene.pictures = { ...this.scene.pictures, sky: shown };
    if (!shown) delete this.scene.pictures.sky;
    if (images.sky) this.context?.makePicture("sky");
    else delete images.sky;
    this.again();
  }

  // Draw no more, and give the context back.
  close() {
    this.observers.forEach((observer) => observer.disconnect());
    this.inSight = false;
    this.canvas = this.canvas.cloneNode();  // so that nothing is told of what happens to the old one
    this.context?.gl.getExtension("WEBGL_lose_context")?.loseContext();
  }

  start() {
    const gl = this.canvas.getContext("webgl2", { antialias: false, powerPreference: "high-performance" });
    // Rays are summed in textures of 32-bit numbers, or of 16-bit numbers, as on some phones.
    const float = gl?.getExtension("EXT_color_buffer_float");
    if (!float && !gl?.getExtension("EXT_color_buffer_half_float")) {
      this.failed("webgl");
      this.settled();
      return;
    }
    const context = (this.context = new Context(gl, float ? gl.RGBA32F : gl.RGBA16F, this));
    this.resize();
    this.warmUp(context);
    this.loadingFirst.then(() => {
      if (this.context !== context || gl.isContextLost()) return;
      context.fill();
      this.gl = gl;
      this.loss = gl.getExtension("WEBGL_lose_context");
      this.lost = this.released = false;
      this.failed(null);
      this.again();
      this.settled();
      this.hold();
    }, () => {});
  }

  // The numbers of the pieces that the scene shows.
  get pieces() {
    const pieces = objects(this.scene, this.shapes.names).filter(({ kind }) => kind === "piece");
    return [...new Set(pieces.map(({ numbers }) => numbers[0]))];
  }

  // Read the distance fields of the pieces that the scene shows, and its pictures.
  async loadShown({ grid, pieces }) {
    await null;  // a page changes the scene when it begins
    const pictures = { mountains: MOUNTAINS, ...this.scene.pictures }, { names, fields, images } = this.shapes;
    const reading = this.pieces.map(async (k) => (fields[k] = await field(pieces[names[k]], grid)));
    const decoding = Object.entries(pictures).map(([part, { data }]) => (images[part] = Object.assign(new Image(), { src: data })).decode());
    await Promise.all([...reading, ...decoding]);
  }

  // Read the distance fields of the other pieces, one after the other: the browser draws in between.
  async loadRest({ grid, pieces }) {
    const { names, fields } = this.shapes;
    const next = () => this.unread ?? names.findIndex((_, k) => !fields[k]);
    for (let k = next(); k >= 0; k = next()) {
      await new Promise((done) => setTimeout(done));
      fields[k] = await field(pieces[names[k]], grid);
      if (this.gl && !this.gl.isContextLost()) this.context.fillVolume(k);
    }
    return this.shapes;
  }

  // The number of a piece that the scene shows and whose distance field has not been read yet.
  get unread() {
    return this.pieces.find((k) => !this.shapes.fields[k]);
  }

  // What is shown stays until all pieces of the scene have been read.
  move() {
    if (this.unread === undefined) return super.move();
    this.asked = false;
    this.later();
  }

  // Draw a pixel as soon as the shaders are compiled, which makes them ready, while the pieces are being read.
  warmUp(context) {
    if (this.gl || this.context !== context || context.gl.isContextLost()) return;
    if (["picture", "display"].every((name) => context.compiled(name))) context.addRay("sum", [1, 1], 0);
    else setTimeout(() => this.warmUp(context), 10);
  }
}

const same = (a, b) => a === b || (typeof a === "object" && JSON.stringify(a) === JSON.stringify(b));

// The pieces' names, and their places on a grid. The distance fields and the pictures are read later.
function named({ grid, pieces }) {
  const names = Object.keys(pieces);
  return { names, grid, places: names.map((name) => pieces[name].place), fields: [], images: {} };
}
