// The scene in a headset (WebXR): each eye sees a picture of its own, and the head moves the eyes.

import { cross } from "../liveview/presets.js";
import { $ } from "./data.js";
import { say } from "./language.js";
import { EYES } from "./moment.js";
import { view } from "./picture.js";

const TILES = EYES / 0.063;  // for a metre: between the pupils of most people are 63 mm
const SLOW = 25, WORSE = 1.4;  // ms of a frame from which fewer pixels are drawn; by so many times fewer a side
const AHEAD = 1;             // tiles from an eye to the rectangle that it sees: any distance will do

// In the scene, x is to the right and y up, as in the headset, but z is away from the eye.
const turned = ([x, y, z]) => [x, y, -z];

/** What one eye of the headset sees, as `camera` in povgen/liveview/presets.js. `start`: where the headset was at first, in the scene.
 * @type {(eye: any, start: number[]) => any} */
function cameraOf({ transform, projectionMatrix: p }, start) {
  const { matrix: m, position } = transform, right = turned(m.slice(0, 3)), up = turned(m.slice(4, 7)), ahead = cross(right, up);
  const eye = turned([position.x, position.y, position.z]).map((metres, k) => start[k] + TILES * metres);
  const middle = eye.map((x, k) => x + AHEAD * (ahead[k] + (p[8] / p[0]) * right[k] + (p[9] / p[5]) * up[k]));
  return { eye, middle, right, up, height: (2 * AHEAD) / p[5] };
}

/** Draw the live view's scene in a session of the headset, until it ends.
 * @type {(session: any) => Promise<void>} */
async function enter(session) {
  const { gl } = view;
  await gl.makeXRCompatible();
  const layer = new globalThis.XRWebGLLayer(session, gl, { antialias: false, depth: false });
  session.updateRenderState({ baseLayer: layer });
  const space = await session.requestReferenceSpace("local");
  let last = 0, mean = 0, part = 1;  // of the pixels a side
  function draw(time, frame) {
    session.requestAnimationFrame(draw);
    mean = last ? 0.9 * mean + 0.1 * (time - last) : 0;
    last = time;
    if (mean > SLOW && part > 0.2) [part, mean] = [part / WORSE, 0];
    const { eye, z2 } = view.scene, start = [...eye, -z2];
    for (const each of frame.getViewerPose(space)?.views ?? []) {
      const { x, y, width, height } = layer.getViewport(each), rows = Math.round(part * height);
      const wide = Math.round((rows * each.projectionMatrix[5]) / each.projectionMatrix[0]);
      view.context.drawEye(cameraOf(each, start), [wide, rows], layer.framebuffer, [width, height], [x, y]);
    }
  }
  view.lend(session);
  session.addEventListener("end", () => view.lend(null));
  session.requestAnimationFrame(draw);
}

/** @type {any} */
const { xr } = navigator;
xr?.isSessionSupported("immersive-vr").then((there) => ($("headset").hidden = !there), () => {});
$("headset").addEventListener("click", () => {
  /** @type {any} */
  let session = null;
  xr.requestSession("immersive-vr").then((started) => enter(session = started)).catch(({ message }) => {
    session?.end();
    $("copied").textContent = say("share.no_headset", { reason: message });
  });
});
