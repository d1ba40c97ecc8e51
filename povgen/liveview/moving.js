// Moving the eye in the page that shows the live view alone; with Shift, changing alpha. By dragging and the arrow keys.

const STEP = 0.05;     // tiles, for a press of a key
const DEGREES = 0.25;  // for a pixel; for a press of a key four times as much
const FARTHEST = 10;   // the eye from the window's centre, tiles
const KEYS = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, 1], ArrowDown: [0, -1] };

// Call `moved` with what a user changes of the view's scene: { eye } or { alpha }. Return a function: whether a pointer
// holds the view.
export function movable(view, area, moved) {
  let held = null;

  const change = (values) => {
    view.set(values);
    moved(values);
  };
  const from = (scene, [x, y], alpha) =>
    alpha === undefined
      ? { eye: [scene.eye[0] + x, scene.eye[1] + y].map((place) => Math.max(-FARTHEST, Math.min(FARTHEST, place))) }
      : { alpha: ((((scene.alpha + alpha + 180) % 360) + 360) % 360) - 180 };

  area.addEventListener("pointerdown", (event) => {
    if (event.button) return;
    held = { start: [event.clientX, event.clientY], scene: { ...view.scene } };
    area.setPointerCapture(event.pointerId);
  });
  area.addEventListener("pointermove", (event) => {
    if (!held) return;
    const [right, down] = [event.clientX - held.start[0], event.clientY - held.start[1]];
    const tiles = view.scene.view / area.clientHeight;
    change(from(held.scene, [tiles * right, -tiles * down], event.shiftKey ? DEGREES * right : undefined));
  });
  for (const ended of ["pointerup", "pointercancel"]) area.addEventListener(ended, () => (held = null));
  area.addEventListener("keydown", (event) => {
    const step = KEYS[event.key];
    if (!step || event.ctrlKey || event.altKey || event.metaKey) return;
    event.preventDefault();
    change(from(view.scene, [STEP * step[0], STEP * step[1]], event.shiftKey ? 4 * DEGREES * (step[0] + step[1]) : undefined));
  });
  return () => held !== null;
}
