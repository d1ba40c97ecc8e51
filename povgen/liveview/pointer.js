// What a pointer and the arrow keys do on a part of a page. Ways are [to the right, up].

const ARROWS = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, 1], ArrowDown: [0, -1] };

/** Call `moved(step, event)` for each arrow key that is pressed on a part, with a step of length 1.
 * @param {(step: number[], event: KeyboardEvent) => void} moved */
export function onArrows(part, moved) {
  part.addEventListener("keydown", (event) => {
    const step = ARROWS[event.key];
    if (!step || event.ctrlKey || event.altKey || event.metaKey) return;
    event.preventDefault();
    moved(step, event);
  });
}

/** While a pointer holds a part, call what `pressed(event)` has returned with the pointer's way from where it was pressed, in pixels.
 * If it returns nothing, the pointer does not hold the part. `released(event)` is called at the end. A second finger, wherever it is,
 * takes the drag back and ends it: its event is then a `pointerdown`. So does the browser, where it scrolls instead. Return a function:
 * whether a pointer holds the part.
 * @param {(event: PointerEvent) => ((way: number[], event: PointerEvent) => void) | undefined} pressed
 * @param {(event: PointerEvent) => void} released */
export function onDrag(part, pressed, released = () => {}) {
  let held = null;
  const release = (event) => {
    held = null;
    released(event);
  };
  addEventListener("pointerdown", (event) => {
    if (!held || event.isPrimary) return;
    held.moved([0, 0], event);
    release(event);
  }, true);
  part.addEventListener("pointerdown", (event) => {
    const moved = event.button || !event.isPrimary ? undefined : pressed(event);
    if (!moved) return;
    held = { pointer: event.pointerId, start: [event.clientX, event.clientY], moved };
    part.setPointerCapture(event.pointerId);
  });
  part.addEventListener("pointermove", (event) => {
    if (held?.pointer === event.pointerId) held.moved([event.clientX - held.start[0], held.start[1] - event.clientY], event);
  });
  for (const end of ["pointerup", "pointercancel", "lostpointercapture"]) {
    part.addEventListener(end, (event) => {
      if (held?.pointer !== event.pointerId) return;
      if (end === "pointercancel") held.moved([0, 0], event);
      release(event);
    });
  }
  return () => held !== null;
}
