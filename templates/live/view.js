// The live view: a scene on a canvas, traced by the graphics processor.
//
// view = new LiveView(canvas, scene, volumes); await view.ready; view.set({ alpha: 66 });
//
// It is ready when it can draw: not before the canvas is in sight.

import { Context } from "./context.js";
import { Schedule } from "./scheduling.js";
import { field } from "./volume.js";

export class LiveView extends Schedule {
  // `scene` has the names and units of povgen's scenes. `volumes`: { grid, pieces: { name: { place, data, most } } }.
  // `failed` is called with a sentence if the view cannot be shown, and with null when it can be shown again.
  /** @param {(sentence: string | null) => void} failed */
  constructor(canvas, scene, volumes, failed = () => {}) {
    super();
    this.scene = { ...scene };
    this.failed = failed;
    this.attach(canvas);
    this.loading = load(volumes);
    this.ready = this.loading.then(
      (shapes) => new Promise((done) => {
        this.shapes = shapes;
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

  // Change values of the scene. The view is drawn soon after.
  set(values) {
    Object.assign(this.scene, values);
    this.again();
  }

  start() {
    const gl = this.canvas.getContext("webgl2", { antialias: false, powerPreference: "high-performance" });
    // Rays are summed in textures of 32-bit numbers, or of 16-bit numbers, as on some phones.
    const float = gl?.getExtension("EXT_color_buffer_float");
    this.loaded(true);
    if (!float && !gl?.getExtension("EXT_color_buffer_half_float")) {
      this.failed("This browser cannot draw the live view: it needs WebGL 2 with EXT_color_buffer_float.");
      return;
    }
    this.gl = gl;
    this.context = new Context(gl, float ? gl.RGBA32F : gl.RGBA16F, this);
    this.loss = gl.getExtension("WEBGL_lose_context");
    this.lost = this.released = false;
    this.failed(null);
    this.resize();
    this.again();
    this.hold();
  }
}

// Read the pieces' distance fields: their names, their places, and the numbers on the grid of each.
async function load({ grid, pieces }) {
  const names = Object.keys(pieces);
  const fields = await Promise.all(names.map((name) => field(pieces[name], grid)));
  return { names, grid, fields, places: names.map((name) => pieces[name].place) };
}
