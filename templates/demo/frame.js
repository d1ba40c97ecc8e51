// A drawing of the page, before the browser shows its next frame.

let asked = false;
let action = () => {};

// Say what is drawn: all that depends on the state.
export function drawBy(draw) {
  action = draw;
}

export function refresh() {
  if (asked) return;
  asked = true;
  requestAnimationFrame(() => {
    asked = false;
    action();
  });
}
