// Numbers from a live view: what its shaders find, its pictures, and how long a picture takes.

// What the shader finds for every pixel of a picture of this size: { ray, shown, met }, four numbers each, see
// readout.glsl. The rows begin at the bottom.
export function readout({ context }, width, height) {
  const { gl } = context;
  const target = context.target("readout", width, height, 3);
  const size = [width, height];
  context.draw("readout", target, size, { size, jitter: [0, 0], rayNumber: 0 });
  const [ray, shown, met] = [0, 1, 2].map((k) => {
    gl.readBuffer(gl.COLOR_ATTACHMENT0 + k);
    return numbers(gl, width, height);
  });
  return { ray, shown, met };
}

// The numbers of a framebuffer. To read them waits for the graphics processor.
function numbers(gl, width, height) {
  const found = new Float32Array(4 * width * height);
  gl.readPixels(0, 0, width, height, gl.RGBA, gl.FLOAT, found);
  return found;
}

// The light of each pixel of a picture, by this many rays: four numbers each, the sum of red, green and blue, and the
// number of rays that are not transparent. The rows begin at the bottom. `part` as for `Context.addRay`.
export function light({ context }, width, height, rays, part = 1) {
  const { gl } = context;
  let sum;
  for (let count = 0; count < rays; count++) sum = context.addRay("still", [width, height], count, { part });
  gl.bindFramebuffer(gl.FRAMEBUFFER, sum.framebuffer);
  return numbers(gl, width, height);
}

export const STILL = { RAYS: 16, PUPIL: 64, MOST: 4000 };  // rays a pixel of a picture to save, also to a pupil; fewer if they take so many ms

// A picture of this size, on a canvas of its own.
export function still({ context, canvas }, width, height) {
  const { gl } = context, start = performance.now(), size = [width, height], before = [canvas.width, canvas.height, context.shown];
  const rays = context.scene.pupil ? STILL.PUPIL : STILL.RAYS;
  let sum, count = 0;
  while (count < rays && (count === 0 || (context.scene.eyes && count % 2) || performance.now() - start < STILL.MOST)) {
    sum = context.addRay("still", size, count++);
    numbers(gl, 1, 1);
  }
  const made = Object.assign(document.createElement("canvas"), { width, height });
  [canvas.width, canvas.height] = size;
  context.show(sum, size, count);
  made.getContext("2d").drawImage(canvas, 0, 0);
  [canvas.width, canvas.height, context.shown] = before;
  context.repaint();
  return made;
}
