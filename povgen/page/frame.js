// A drawing of the page: at once, or before the browser shows its next frame.

import { $ } from "./data.js";

let asked = false;
let action = () => {};

// Say what is drawn: all that depends on the state.
export function drawBy(draw) {
  action = draw;
}

// Draw at once. A drawing that was asked for is done by this.
export function draw() {
  asked = false;
  action();
}

export function refresh() {
  if (asked) return;
  asked = true;
  requestAnimationFrame(() => {
    if (asked) draw();
  });
}

// Do something at an event of the element with this id, then draw.
export function on(id, event, action) {
  $(id).addEventListener(event, (given) => {
    action(given);
    refresh();
  });
}
