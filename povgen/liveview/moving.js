// Moving the eye in the page that shows the live view alone; with Shift, changing alpha. By dragging and the arrow keys.

import { onArrows, onDrag } from "./pointer.js";

const STEP = 0.05;     // tiles, for a press of a key
const DEGREES = 0.25;  // for a pixel; for a press of a key four times as much
const FARTHEST = 10;   // the eye from the window's centre, tiles

// Call `moved` with what a user changes of the view's scene: { eye } or { alpha }. Return a function: whether a pointer
// holds the view.
export function movable(view, area, moved) {
  const change = (values) => {
    view.set(values);
    moved(values);
  };
  const from = (scene, [x, y], alpha) =>
    alpha === undefined
      ? { eye: [scene.eye[0] + x, scene.eye[1] + y].map((place) => Math.max(-FARTHEST, Math.min(FARTHEST, place))) }
      : { alpha: ((((scene.alpha + alpha + 180) % 360) + 360) % 360) - 180 };

  onArrows(area, ([x, y], { shiftKey }) => change(from(view.scene, [STEP * x, STEP * y], shiftKey ? 4 * DEGREES * (x + y) : undefined)));
  return onDrag(area, () => {
    const scene = { ...view.scene };
    return ([right, up], { shiftKey }) => {
      const tiles = view.scene.view / area.clientHeight;
      change(from(scene, [tiles * right, tiles * up], shiftKey ? DEGREES * right : undefined));
    };
  });
}
