// What povgen has written into the page, its elements, and when all of it is drawn.

/** @type {(id: string) => any} */
export const $ = (id) => document.getElementById(id);
export const data = JSON.parse($("data").textContent);

/** An element with properties, and with what it contains.
 * @type {(tag: string, properties?: object, ...children: (Node | string)[]) => any} */
export function element(tag, properties, ...children) {
  const made = Object.assign(document.createElement(tag), properties);
  made.append(...children);
  return made;
}
export const pick = (values, ...names) => Object.fromEntries(names.map((name) => [name, values[name]]));
// An angle in degrees as one from -180 to 180.
export const wrapped = (angle) => (Math.abs(angle) > 180 ? angle - 360 * Math.round(angle / 360) : angle);
export const clamped = (x, [least, most]) => Math.min(most, Math.max(least, x));

// Write a text where it has changed: of a live region, a screen reader speaks all that is written.
export function write(id, text) {
  if ($(id).textContent !== text) $(id).textContent = text;
}

// ---- A drawing of the page: at once, or before the browser shows its next frame ----

let asked = false;
let drawAll = () => {};

// Say what is drawn: all that depends on the state.
export const drawBy = (drawing) => (drawAll = drawing);

// Draw at once. A drawing that was asked for is done by this.
export function draw() {
  asked = false;
  drawAll();
}

export function refresh() {
  if (asked) return;
  asked = true;
  requestAnimationFrame(() => asked && draw());
}

// Do something at an event of the element with this id, then draw.
export function on(id, event, action) {
  $(id).addEventListener(event, (given) => {
    action(given);
    refresh();
  });
}
