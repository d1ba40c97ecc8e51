// The sketch: eye, sheets and object, seen from the right side. z is to scale, unless one of z1 and z2 is very short.

import { finite } from "./complex.js";
import { $, clamped } from "./data.js";
import { atSecondWindow } from "./equations.js";
import { brief } from "./numbers.js";
import { arrowhead, curve, line, svg, words } from "./shapes.js";
import { state } from "./state.js";

export const sketch = $("sketch");

export function drawSketch(now) {
  const { width, height } = sketch.getBoundingClientRect();
  if (!width) return;
  const rem = parseFloat(getComputedStyle(document.documentElement).fontSize);
  const [left, right] = [2.2 * rem, width - 2.2 * rem];
  const d = now.d ?? 0, all = now.z2 + d + now.z1;
  const x = left + clamped(now.z2 / all, [0.14, d ? 0.6 : 0.86]) * (right - left);
  const last = d ? clamped(x + (d / all) * (right - left), [x + 1.6 * rem, right - 2.5 * rem]) : x;  // the last window
  const [top, bottom] = [0.5 * rem, height - 1.9 * rem];
  const tile = (bottom - top) / now.scene.view;
  const y = (tiles) => clamped((top + bottom) / 2 - tile * tiles, [top, bottom]);
  /** @type {any[]} */
  const [eye, object] = [[left, y(now.E[1])], [right, Math.max(y(now.L[1]), 1.7 * rem)]];
  const half = (tile * now.scene.aperture) / 2, middle = (top + bottom) / 2;
  const parts = [];
  if (finite(now.place)) {
    const second = d ? [[last, y(atSecondWindow(now)[1])]] : [];
    parts.push(curve("ray", [object, ...second, [x, y(now.place[1])], eye]));
  }
  const panes = { none: [], single: [0], detailed: [-3, 3] }[now.sheet] ?? [0];
  for (const place of d ? [x, last] : [x]) {
    parts.push(line("frame", [place, middle - half], [place, middle + half]));
    for (const aside of panes) {
      const kind = panes.length === 1 && now.sheet !== "single" ? "pane ideal" : "pane";
      parts.push(svg("rect", { class: kind, x: place + aside - 2, y: middle - half, width: 4, height: 2 * half }));
    }
  }
  parts.push(...eyeShape(eye, rem), ...objectShape(object, rem));
  parts.push(...dimension("q q-z2", left, x, height - 0.9 * rem, "z₂", rem), ...dimension("q q-z1", last, right, height - 0.9 * rem, "z₁", rem));
  if (d) parts.push(...dimension("q q-d", x, last, height - 0.9 * rem, "d", rem));
  sketch.setAttribute("viewBox", `0 0 ${width} ${height}`);
  sketch.replaceChildren(...parts);
  sketch.setAttribute("aria-label", `From the side: the eye E, the sheets ${brief(now.z2)} tiles behind it${d ? `, a second window ${brief(d)} tiles behind them` : ""}, the object L ${brief(now.z1)} tiles behind the sheets.`);
}

function dimension(kind, from, to, y, name, rem) {
  const room = to - from > 3 * rem;
  const parts = [line(kind, [from + 1, y], [to - 1, y])];
  if (room) parts.push(arrowhead(`head ${kind}`, [from + 1, y], Math.PI, 0.55 * rem), arrowhead(`head ${kind}`, [to - 1, y], 0, 0.55 * rem));
  return [...parts, words(kind, [(from + to) / 2, y - 0.05 * rem], name)];
}

function eyeShape([x, y], rem) {
  const [wide, high] = [0.95 * rem, 0.75 * rem];
  const d = `M${x - wide} ${y}Q${x} ${y - high} ${x + wide} ${y}Q${x} ${y + high} ${x - wide} ${y}Z`;
  return [svg("path", { class: "eye q q-E", d }), svg("circle", { class: "pupil q q-E", cx: x + 0.3 * rem, cy: y, r: 0.27 * rem }),
    words("point q q-E", [x, y - 1.05 * rem < 0.6 * rem ? y + 1.15 * rem : y - 1.05 * rem], "E")];
}

function objectShape([x, y], rem) {
  const name = words("point q q-L", [x + 1.3 * rem, y], "L");
  if (state.scene === "spheres") return [svg("circle", { class: "object q q-L", cx: x, cy: y, r: 0.55 * rem }), name];
  const at = (dx, dy) => `${x + dx * rem} ${y - dy * rem}`;
  const d = `M${at(-0.6, 0)}L${at(0.6, 0)}L${at(0.22, 0.9)}L${at(-0.22, 0.9)}Z`;
  return [svg("path", { class: "object q q-L", d }), svg("circle", { class: "object q q-L", cx: x, cy: y - 1.2 * rem, r: 0.42 * rem }), name];
}
