// When a live view is drawn, and how much of it at once.
//
// While values change it draws one ray a pixel, and fewer pixels where a frame takes long. At rest it adds rays, up to
// RAYS a pixel, and then stops drawing. It adds them in strips, so that it can move again at once.

export const PACE = {
  RAYS: 64,
  MOVING: 150,     // ms without a change until the picture is at rest
  SLOW: 25,        // ms: if drawing takes longer, fewer pixels are drawn at once
  FAST: 12,        // ms: below, more are
  LEAST: 0.15,     // of the canvas's width and height: the moving picture's
  STRIPS: 4,       // of the picture at rest, at most
};

export class Schedule {
  canvas = null;
  gl = null;
  context = null;
  budget = 3e4;    // pixels that are drawn at once
  count = 0;       // rays a pixel in the sum
  row = 0;         // of the sum, up to which the next ray has been added
  drawn = null;    // the program of the picture that is shown
  inSight = false; // whether the canvas is
  lost = false;    // whether the context is lost
  stale = false;   // whether the picture that is shown is no longer right
  pending = null;  // what is being drawn

  // How many rays a picture has at least: for two eyes, one of each.
  get turns() {
    return this.context.scene.eyes ? 2 : 1;
  }

  // The part of the canvas's pixels a side that the moving picture has.
  get scale() {
    return Math.min(1, Math.max(PACE.LEAST, Math.sqrt(this.budget / (this.canvas.width * this.canvas.height))));
  }

  // Whether the picture is still one of another kind of scene, because the shaders of this one are being made ready.
  get behind() {
    return Boolean(this.context) && !this.lost && (!this.gl || this.drawn !== this.context.program("picture"));
  }

  // Whether a picture of the latest change has still to be drawn.
  get moving() {
    return this.inSight && Boolean(this.gl) && !this.gl.isContextLost() && (this.stale || this.pending !== null);
  }

  converged() {
    return Boolean(this.gl) && !this.gl.isContextLost() && this.count >= PACE.RAYS * this.turns;
  }

  resize() {
    const { canvas } = this;
    const ratio = window.devicePixelRatio || 1;
    if (!canvas.clientWidth) return;  // it is hidden
    const [width, height] = [canvas.clientWidth, canvas.clientHeight].map((side) => Math.max(1, Math.round(side * ratio)));
    if (width === canvas.width && height === canvas.height) return;
    canvas.width = width;
    canvas.height = height;
    if (this.gl && !this.gl.isContextLost()) this.context.repaint();  // the size's change has blackened the canvas
    this.again();
  }

  again() {
    clearTimeout(this.resting);
    this.count = this.row = 0;
    this.stale = true;
    this.later();
  }

  // Let others draw with the context, and nothing on the canvas meanwhile; with null, draw again.
  lend(to) {
    this.pending = to;
    this.again();
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
    if (this.gl.isContextLost() || this.pending || !this.stale || !this.inSight) return;
    if (!this.context.compiled("picture") || !this.context.compiled("display")) {
      this.later();
      return;
    }
    const size = [canvas.width, canvas.height].map((pixels) => Math.max(1, Math.round(scale * pixels)));
    const whole = size[0] === canvas.width && size[1] === canvas.height;
    this.stale = false;
    // a smaller picture is in the target that the first ray of the picture at rest spares: it can be shown until then
    const { turns } = this, first = Number(whole || turns > 1);
    let sum;
    for (let ray = 0; ray < turns; ray++) sum = this.context.addRay("sum", size, ray, { first });
    this.context.show(sum, size, turns);
    if (whole) this.count = turns;  // the first rays of the picture at rest
    const program = this.context.program("picture");
    this.finish(turns * size[0] * size[1], PACE.MOVING, () => (this.drawn = program));
  }

  // Add a ray to each pixel of a strip of the picture at rest. The picture is shown when it is complete.
  refine() {
    const { canvas, count, row } = this;
    if (this.gl.isContextLost() || this.converged() || !this.inSight) return;
    const size = [canvas.width, canvas.height];
    const strip = Math.ceil(Math.max(this.budget / size[0], size[1] / PACE.STRIPS));
    const rows = Math.min(strip, size[1] - row);
    const sum = this.context.addRay("sum", size, count, { rows: [row, rows] });
    this.row += rows;
    if (this.row === size[1]) {
      this.count++;
      this.row = 0;
      if (this.count % this.turns === 0) this.context.show(sum, size, this.count);
    }
    this.finish(rows * size[0], 0);
  }

  // Wait until these pixels are drawn. Then go on: without a change, after `pause` ms, with the picture at rest.
  finish(pixels, pause, done = () => {}) {
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
      done();
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
    if (expected > PACE.SLOW) this.budget *= Math.max(0.25, 0.9 * PACE.SLOW / expected);
    else if (expected < PACE.FAST && pixels > 0.9 * this.budget) this.budget *= 1.25;
    const all = this.canvas.width * this.canvas.height;
    this.budget = Math.min(all, Math.max(PACE.LEAST ** 2 * all, this.budget));
  }
}
