// The light in space: eye, frame, sheets and object, and rays that are traced through them (rays.js). Or one prism.
// Points are [x, y, z], in tiles. Depths are to scale, unless the whole is very long.

import * as geometry from "../liveview/geometry.js";
import { onArrows, onDrag } from "../liveview/pointer.js";
import * as presets from "../liveview/presets.js";
import { hasPrisms } from "../liveview/sheets.js";
import { abs, finite, minus, plus, scaled, turn } from "./complex.js";
import { $, clamped, data, refresh } from "./data.js";
import { angle, brief, say, tilesText } from "./language.js";
import { seenAt, SHOWN } from "./moment.js";
import { outlineOf } from "./outline.js";
import { imagePlace, lightShares, raysSaid, thing } from "./phrases.js";
import { at, bundle, FIELD_RAYS, fieldRays, hasField, meeting, perpendicularLoop } from "./rays.js";
import { along, arrowhead, dot, heading, line, svg, words } from "./shapes.js";
import { CAMERAS, FLOOR, isEmpty, session, state } from "./state.js";
import { passage } from "./trace.js";

const space = $("space"), box = $("space-box"), stage = $("stage");
const LONGEST = 16;  // tiles: what is longer is drawn shorter
const HIGHEST = 1.8; // tiles: of all pieces
const LOW = 110;     // pixels: a lower view names only L and E

export function drawSpace(now) {
  place();
  const { width, height } = space.getBoundingClientRect();
  if (!width) return;
  const rem = Math.min(parseFloat(getComputedStyle(document.documentElement).fontSize), width / 24);
  const drawing = state.light === "prism" ? onePrism(now) : scene(now);
  const view = session.held?.view ?? roomBeside(picture(), drawing, { left: 0, width, height }, rem);
  session.spaceView = view;
  space.setAttribute("viewBox", `0 0 ${width} ${height}`);
  space.replaceChildren(...drawing.parts(view, rem));
  if (drawing.squeeze < 1 && height >= LOW) space.append(words("scale", [width / 2, height - Math.max(0.8 * rem, 12)], say("light.shorter", { times: brief(1 / drawing.squeeze) })));
  $("light-says").textContent = [drawing.says, ...(now.glass && state.light !== "prism" ? [lightShares(now)] : [])].join(" ");
  $("light-where").textContent = drawing.where ?? "";
  for (const button of $("cameras").children) button.setAttribute("aria-pressed", String(session.camera) === String(CAMERAS[button.value]));
}

// The view stands in the panel, or in place of the picture, which then becomes small.
function place() {
  const home = state.large ? $("stage-box") : $("space-home");
  if (box.parentElement !== home) {
    const focused = box.contains(document.activeElement) ? document.activeElement : null;
    home.append(box);
    focused?.focus();
  }
  document.body.classList.toggle("large-space", state.large);
}

// The small picture's width and height, where it lies over the view; otherwise 0.
/** @type {() => [number, number]} */
const picture = () => (state.large ? [stage.clientWidth, stage.clientHeight] : [0, 0]);

// The whole view; or what is to the right of the small picture, if something named would lie under the picture.
function roomBeside([wide, high], { extent, squeeze }, box, rem) {
  const view = projection(extent, squeeze, box, rem);
  const covered = extent.some(({ point, left, above }) => {
    const [x, y] = view.to(point);
    return x - left * rem < wide && y - above * rem < high;
  });
  return covered ? projection(extent, squeeze, { ...box, left: wide }, rem) : view;
}

// Room that something needs at a point: to the left, to the right, above and below, in rem.
const room = (point, left = 0.6, right = left, above = left, below = above) => ({ point, left, right, above, below });

// A map from points to pixels: an orthographic projection in which all of `extent` has room, a list of what `room` returns.
// `across` is the direction to the right in space.
function projection(extent, squeeze, { left: from, width, height }, rem) {
  const [azimuth, elevation] = session.camera;
  const [c, s] = turn(azimuth), [ce, se] = turn(elevation);
  const flat = ([x, y, z]) => [squeeze * z * c + x * s, -y * ce - (squeeze * z * s - x * c) * se];
  const places = extent.map(({ point, left, right, above, below }) => {
    const [x, y] = flat(point);
    return [[x, left * rem, right * rem], [y, above * rem, below * rem]];
  });
  const axes = [width - from, height].map((size, k) => ({ size, sides: places.map((place) => place[k]) }));
  const fitted = Math.max(1, Math.min(...axes.flatMap(({ size, sides }) => sides.flatMap(([a, before]) => sides
    .filter(([b]) => b > a + 1e-9).map(([b, , after]) => (size - before - after) / (b - a))))));
  const scale = session.zoom * fitted;
  const starts = axes.map(({ size, sides }) => {
    const low = Math.min(...sides.map(([a, before]) => fitted * a - before)), high = Math.max(...sides.map(([a, , after]) => fitted * a + after));
    return size / 2 - (session.zoom * (low + high)) / 2;
  });
  starts[0] += from;
  const to = (point) => flat(point).map((x, k) => starts[k] + scale * x);
  return { to, low: height < LOW, across: [s, 0, c / squeeze], scale };
}

// ---- The scene ----

function scene(now) {
  const { L, E, z1, z2, windows, place, radii, objects, scene } = now, last = windows.at(-1).z;
  const eye = [...E, -z2], object = [...L, last + z1], squeeze = Math.min(1, LONGEST / (z2 + last + z1));
  const outer = scene.aperture / 2 + scene.rim, frames = windows.flatMap(({ z }) => [-1, 1].flatMap((way) => corners(outer, z + (way * presets.depth(scene)) / 2)));
  const rays = state.light === "field" ? [] : bundle(now), shown = rays.filter(({ kind }) => state.stray || kind === "designed");
  const image = state.light === "pencil" && !isEmpty() ? meeting(now.glass ? bundle(now, 11) : rays) : null;
  const near = image && image[2] > -1.6 * z2 - 1 && image[2] < last + 2 * z1 + 4 && Math.hypot(image[0], image[1]) < 6 ? image : null;
  const ground = presets.hasPiece(state.scene) ? FLOOR : -outer, below = squeeze < 1 ? 1.6 : 0.6;  // under it the scale is said
  const half = presets.hasPiece(state.scene) ? data.pedestals[state.piece] : radii[objects.indexOf(z1)];
  const wide = 0.45 * say("light.image").length;  // half the label
  const heights = presets.hasPiece(state.scene) ? [FLOOR, L[1], L[1] + HIGHEST] : [L[1] - half, L[1] + half];
  const sides = heights.flatMap((y) => [[-1, -1], [1, -1], [1, 1], [-1, 1]].map(([a, b]) => room([L[0] + a * half, y, last + z1 + b * half], 0.4, 0.4, 0.4, below)));
  const extent = [
    room(eye, 1.2, 1.2, 2.7, 0.8), room(object, 0.4, 2.3, 1.3), ...sides, ...frames.map((point) => room(point, 0.4, 0.4, 0.4, below)),
    ...[-z2, last + z1].map((z) => room([0, ground, z], 0.8, 0.8, 0.6, below + 1.9)),  // and of the labels below
    ...(marksP(now) ? [room([...place, 0], 0.8, 0.8, 2.3, 0.4)] : []),
    ...(near ? [room(near, wide, wide, 0.6, 2.4)] : []),
  ];
  const field = state.light === "field" && hasField(now) ? { ...perpendicularLoop(now), rays: fieldRays(now) } : null;
  if (field) extent.push(...field.points.map((point) => room(point)));
  return { extent, squeeze, says: says(now, rays, image, field), where: raysSaid(now, rays), parts: (view, rem) => [
    ...floor(now, view, ground),
    ...dimensions(now, view, ground, rem),
    ...[...windows].reverse().flatMap((window) => windowParts(now, window, view)),
    ...objectParts(now, view),
    ...rayParts(now, shown, image, view, rem),
    ...(field ? fieldParts(field, view, rem) : []),
    ...eyeParts(eye, view, rem),
    ...names(now, { object, eye, image: near }, view, rem),
    hold("E", eye, view, rem), hold("L", [L[0], L[1] + (presets.hasPiece(state.scene) ? 0.5 : 0), object[2]], view, rem),
  ] };
}

const corners = (half, z) => [[-half, -half, z], [half, -half, z], [half, half, z], [-half, half, z]];
const face = (kind, points, { to }) => svg("path", { class: kind, d: along([points.map(to)], "Z") });

function floor({ z1, z2, windows }, { to }, ground) {
  const end = windows.at(-1).z + z1, parts = [], step = Math.max(1, Math.ceil((end + z2) / 30));
  for (let x = -2; x <= 2; x++) parts.push(line("tile", to([x, ground, -z2]), to([x, ground, end])));
  for (let z = -Math.floor(z2); z <= end; z += step) parts.push(line("tile", to([-2, ground, z]), to([2, ground, z])));
  return parts;
}

// A frame and its sheets. The frame is as deep as in the picture.
function windowParts(now, window, view) {
  const { scene } = now, half = scene.aperture / 2, depth = presets.depth(scene) / 2, outer = half + scene.rim;
  const ring = (z) => svg("path", { class: "frame", "fill-rule": "evenodd", d: along([outer, half].map((side) => corners(side, z).map(view.to)), "Z") });
  const edges = corners(outer, window.z - depth).map((corner, n) => line("frame", view.to(corner), view.to(corners(outer, window.z + depth)[n])));
  const panes = hasPrisms(window)
    ? geometry.sheets(window).toReversed().flatMap(({ angle, centre }) => pane("pane", window.z + centre, half, angle, Math.min(window.values.prisms, 15), view))
    : window.sheet === "none" ? [] : pane("pane ideal", window.z, half, 0, 0, view);
  return [ring(window.z + depth), ...edges, ...panes, ring(window.z - depth)];
}

// A sheet, with lines along some of its prisms' ridges.
function pane(kind, z, half, angle, count, view) {
  const parts = [face(kind, corners(half, z), view)], [c, s] = turn(angle);
  for (let k = 0; k < count; k++) {
    const v = ((k + 0.5) / count - 0.5) * 2 * half * (Math.abs(c) + Math.abs(s));
    const ends = [-Infinity, Infinity];  // of the line (-s v + c t, c v + s t) inside the square
    for (const [start, step] of [[-s * v, c], [c * v, s]]) {
      const [a, b] = [(-half - start) / step, (half - start) / step].sort((one, other) => one - other);
      if (Math.abs(step) < 1e-9) {
        if (Math.abs(start) > half) ends[1] = -Infinity;
      } else [ends[0], ends[1]] = [Math.max(ends[0], a), Math.min(ends[1], b)];
    }
    if (ends[0] < ends[1]) parts.push(line("ridge", ...ends.map((t) => view.to([c * t - s * v, c * v + s * t, z]))));
  }
  return parts;
}

function objectParts({ L, z1, windows, objects, radii }, view) {
  const last = windows.at(-1).z;
  if (!presets.hasPiece(state.scene)) {
    return objects.map((z, n) => dot(z === z1 ? "object q q-L" : "object other", view.to([...L, last + z]), Math.max(2, view.scale * radii[n])));
  }
  const half = data.pedestals[state.piece], z = last + z1;
  const [low, high] = [FLOOR, L[1]].map((y) => [[-1, -1], [1, -1], [1, 1], [-1, 1]].map(([a, b]) => [L[0] + a * half, y, z + b * half]));
  const pedestal = [0, 1, 2, 3].map((n) => face("pedestal", [low[n], low[(n + 1) % 4], high[(n + 1) % 4], high[n]], view));
  // the piece as it looks from everywhere: its outline, turned to the viewer
  const lines = outlineOf(state.piece).map((points) => points.map(([x, y]) => view.to([L[0] + x * view.across[0], L[1] + y, z + x * view.across[2]])));
  return [...pedestal, svg("path", { class: "object q q-L", d: along(lines, "Z") })];
}

// Light runs from the object to the eye: the rays that begin at the eye are drawn against their direction.
function rayParts(now, rays, image, { to }, rem) {
  const { z1, z2, windows } = now, parts = [], forward = state.light !== "pencil";
  const seen = state.light === "aim" ? seenAt(now, state.W) : "";
  const beyond = SHOWN.includes(seen) && seen !== "pedestal" ? z1 + 2 : 0;  // it does not end at the object
  const end = forward ? windows.at(-1).z + z1 + beyond : Math.min(-1.15 * z2, image && image[2] < 0 ? Math.max(image[2] - 0.4, -2 * z2) : 0);
  for (const ray of [...rays].sort((a, b) => Number(a.kind === "designed") - Number(b.kind === "designed"))) {
    const points = [...ray.points];
    if (ray.kind !== "lost") points.push(at(ray, (end - points.at(-1)[2]) * ray.direction[2] > 0 ? end : points.at(-1)[2] + 2 * Math.sign(ray.direction[2])));
    if (state.light === "aim" && presets.hasPiece(state.scene)) endOnFloor(points);
    parts.push(path(`ray ${ray.kind}`, points, to));
    if (ray.kind !== "designed") continue;
    if (state.light === "ray" && points.length > 2) parts.push(path("straight", [points[1], at({ points: [points[1]], direction: points[1].map((x, k) => x - points[0][k]) }, end)], to));
    const [a, b] = (forward ? [points[1] ?? points[0], points[0]] : points.slice(-2)).map(to);
    if (abs(minus(a, b)) > 3 * rem) parts.push(arrowhead("head ray", [0.4 * a[0] + 0.6 * b[0], 0.4 * a[1] + 0.6 * b[1]], heading(a, b), 0.6 * rem));
    if (image && image[2] > windows[0].z) parts.push(path("virtual", [ray.points.at(-1), image], to));
  }
  return parts;
}

// Cut the last part of a path where it meets the floor.
function endOnFloor(points) {
  const [from, to] = points.slice(-2);
  const part = (FLOOR - from[1]) / (to[1] - from[1]);
  if (to[1] < FLOOR && part >= 0) points[points.length - 1] = from.map((x, k) => x + part * (to[k] - x));
}

function fieldParts({ points, gap, rays: traced }, { to }, rem) {
  const rays = traced.flatMap(([from, end]) => {
    const [a, b] = [from, end].map(to);
    return [path("ray designed", [from, end], to), arrowhead("head ray", b, heading(a, b), 0.45 * rem)];
  });
  return [...rays, path("loop", points, to), ...(Math.abs(gap) > 0.005 ? [path("gap", [points[0], points.at(-1)], to)] : [])];
}

const path = (kind, points, to) => svg("path", { class: kind, d: along([points.map((point) => to(point).map((x) => clamped(x, [-1e5, 1e5])))]) });

function eyeParts(eye, { to }, rem) {
  const [x, y] = to(eye), [wide, high] = [0.95 * rem, 0.75 * rem];
  const d = `M${x - wide} ${y}Q${x} ${y - high} ${x + wide} ${y}Q${x} ${y + high} ${x - wide} ${y}Z`;
  return [svg("path", { class: "eye q q-E", d }), svg("circle", { class: "pupil q q-E q-pupil", cx: x + 0.3 * rem, cy: y, r: 0.27 * rem })];
}

// Where a pointer takes hold of the eye, or of the object.
const hold = (what, point, { to }, rem) => svg("circle", { class: "hold", "data-moves": what, cx: to(point)[0], cy: to(point)[1], r: 1.4 * rem });

const marksP = ({ place, sheet }) => state.light === "ray" && sheet !== "none" && finite(place) && abs(place) < 4;

function names(now, { object, eye, image }, { to, low }, rem) {
  const named = (name, point, up) => words(`point q q-${name}`, [to(point)[0], to(point)[1] - up * rem], name);
  const [x, y] = to(object);
  const parts = [named("E", eye, 1.2), words("point q q-L", [x + 1.5 * rem, y + 0.2 * rem], "L")];
  if (marksP(now)) parts.push(dot("dot q q-P", to([...now.place, 0]), 0.25 * rem), ...(low ? [] : [named("P", [...now.place, 0], 0.9)]));
  if (state.light === "aim") parts.push(dot("dot", to([...state.W, 0]), 0.25 * rem));
  if (image) parts.push(dot("image", to(image), 0.4 * rem), words("image", [to(image)[0], to(image)[1] + 1.2 * rem], say("light.image")));
  return parts;
}

// z1, z2 and d, along the floor. The name of z1 stands nearer to the object, because the frame covers the other end.
function dimensions({ z1, z2, d, windows }, { to, low }, ground, rem) {
  const last = windows.at(-1).z, y = ground;
  return [["z2", "z₂", -z2, 0], ["z1", "z₁", last, last + z1], ...(d ? [["d", "d", 0, last]] : [])].flatMap(([name, text, from, end]) => {
    const [a, b] = [to([0, y, from]), to([0, y, end])], kind = `q q-${name}`;
    const tips = abs(minus(a, b)) > 3 * rem ? [[a, b], [b, a]].map(([tip, other]) => arrowhead(`head ${kind}`, tip, heading(other, tip), 0.5 * rem)) : [];
    const middle = plus(a, scaled(name === "z1" ? 0.75 : 0.5, minus(b, a)));
    return [line(kind, a, b), ...tips, ...(low ? [] : [words(`symbol-name ${kind}`, plus(middle, [0, 0.8 * rem]), text)])];
  });
}

// What the drawing shows, in words.
function says(now, rays, image, field) {
  const { windows, z2, E } = now, count = (kind) => rays.filter((ray) => ray.kind === kind).length;
  const paths = [], missed = rays.filter(({ kind, frame, points }) => kind === "beside" || (frame === "rim" && points.length > 2)).length;
  if (now.glass && rays.length > 1) paths.push(say("light.paths", { designed: count("designed"), stray: count("stray"), lost: count("back") + count("lost") + count("beside") }));
  else if (missed) paths.push(say("light.beside", { count: missed, number: missed }));
  if (state.light === "ray") return !rays.length ? say("light.no_ray") : [say("light.ray"), ...(now.sheet === "none" ? [] : [say(now.glass || now.lenses ? "light.ray_prisms" : "light.ray_sheets")])].join(" ");
  if (field) {
    const loop = say(Math.abs(field.gap) > 0.005 ? "light.field" : "light.field_closed", { gap: tilesText(Math.abs(field.gap)) });
    return field.rays.length < FIELD_RAYS ? `${loop} ${say("light.through_window")}` : loop;
  }
  if (state.light === "field") return say("light.no_field");
  if (state.light === "aim") return say("light.aim", { what: seenBy(now, rays[0]) });
  if (state.light === "eye") return [say("light.eye", { number: rays.length }), ...paths].join(" ");
  const good = rays.filter(({ kind }) => kind === "designed");
  const reach = good.filter((ray) => abs(minus(at(ray, -z2), E)) < 0.05);
  const meets = isEmpty() ? say("light.straight") : !image ? say("light.nowhere") : reach.length === good.length ? say("light.pole")
    : say(image[2] < windows[0].z ? "light.real" : "light.virtual", { place: imagePlace(image[2], z2, now.d ? "first_window" : "window") });
  return [say("light.pencil", { number: rays.length }), ...paths, meets].join(" ");
}

// The name of what a ray to the eye comes from.
function seenBy(now, { kind, frame }) {
  if (kind === "stray" || kind === "back") return say(`light.${kind}`);
  if (frame) return say("shown.frame");
  const found = kind === "lost" ? "dark" : seenAt(now, state.W);
  return SHOWN.includes(found) ? say(`shown.${found}`) : thing().name;
}

// ---- One prism ----

// A prism that is 1 high and 1 wide, and parallel rays from the object's side. The faces that one of them meets are numbered.
function onePrism(now) {
  const values = { ...now.scene, sheet: "single", prisms: 1, aperture: 1 }, window = { sheet: "single", z: 0, values };
  const { height, length } = geometry.prism(values), far = length / 2 + 1.4;
  const base = -0.5 + values.gap / 2, top = length / 2 - height / Math.tan(geometry.radians(values.base_angle));
  const rays = [0.1, 0.3, 0.5, 0.7, 0.9].map((part) => {
    const towards = [0.06, -0.2, -1], start = [-0.15, base + part * height, length / 2];
    const from = start.map((x, k) => x - 1.4 * towards[k]);
    return { from, ...passage(window, from, towards) };
  });
  const numbered = rays.filter(({ designed }) => designed).at(1) ?? rays.find(({ designed }) => designed);
  const ends = [-0.5, 0.5].map((x) => [[x, base, -length / 2], [x, base, length / 2], [x, base + height, top], [x, base + height, -top]]);
  const extent = [...ends.flat(), [0, 0.4, far], [0, 0.4, -far], [0, -0.4, far]].map((point) => room(point, 1));
  const parts = (view, rem) => [
    ...ends.map((points) => face("glass", points, view)),
    ...ends[0].map((corner, n) => line("glass", view.to(corner), view.to(ends[1][n]))),
    face("base", [ends[0][0], ends[0][1], ends[1][1], ends[1][0]], view),
    ...rays.filter(({ designed }) => designed || state.stray).flatMap((ray) => {
      const { from, steps, end, place, direction, designed } = ray, inside = [from, ...steps.map((step) => step.place), place];
      const out = place.map((x, k) => x + (1.4 * direction[k]) / Math.abs(direction[2]));
      const kind = designed ? "designed" : end === "through" ? "stray" : "lost", points = kind === "lost" ? inside : [...inside, out];
      const heads = [points.slice(0, 2), points.slice(-2)].map((pair) => pair.map(view.to));
      return [path(`ray ${kind}${ray === numbered ? " numbered" : ""}`, points, view.to),
        ...(designed ? heads.map(([a, b]) => arrowhead("head ray", [(a[0] + b[0]) / 2, (a[1] + b[1]) / 2], heading(a, b), 0.6 * rem)) : [])];
    }),
    ...(numbered?.steps ?? []).flatMap((step, n) => {
      const [x, y] = view.to(step.place);
      return [dot("number", [x, y], 0.72 * rem), words("number", [x, y + 0.05 * rem], n + 1)];
    }),
  ];
  return { extent, squeeze: 1, says: say("light.one_prism"), parts };
}

// ---- Turning the view ----

function turnTo(camera) {
  session.camera = [camera[0], clamped(camera[1], [-0.4, 1.55])];
  refresh();
}

function zoomBy(factor) {
  session.zoom = clamped(session.zoom * factor, [0.5, 40]);
  refresh();
}

// Two fingers zoom: their distances count. They end a turn: liveview/pointer.js.
const fingers = new Map();
const apart = () => {
  const [a, b] = fingers.values();
  return fingers.size === 2 ? abs(minus(a, b)) : 0;
};
for (const event of ["pointerdown", "pointermove", "pointerup", "pointercancel"]) {
  $("space-turn").addEventListener(event, ({ type, pointerId, clientX, clientY }) => {
    const before = apart();
    if (type === "pointerdown" || fingers.has(pointerId)) fingers.set(pointerId, [clientX, clientY]);
    if (type === "pointermove" && before) zoomBy(apart() / before);
    if (type === "pointerup" || type === "pointercancel") fingers.delete(pointerId);
  });
}
onDrag($("space-turn"), ({ target }) => {
  if (target.closest("[data-moves]")) return undefined;  // handles.js
  const [azimuth, elevation] = session.camera;
  return ([right, up]) => turnTo([azimuth - right / 150, elevation - up / 150]);
});
$("space-turn").addEventListener("wheel", (event) => {
  event.preventDefault();
  zoomBy(Math.exp(-(event.deltaMode ? 33 : 1) * event.deltaY / 500));  // a wheel may count lines
}, { passive: false });

const ZOOMS = { "+": 1.2, "-": 1 / 1.2, "0": 0 };
$("space-turn").addEventListener("keydown", (event) => {
  if (!(event.key in ZOOMS) || event.ctrlKey || event.altKey || event.metaKey) return;
  event.preventDefault();
  event.stopPropagation();  // digits are keys of the movies
  if (ZOOMS[event.key]) zoomBy(ZOOMS[event.key]);
  else session.zoom = 1;
  sayTurned();
});
onArrows($("space-turn"), (step, event) => {
  event.stopPropagation();
  turnTo(session.camera.map((x, k) => x + step[k] * (event.shiftKey ? 0.3 : 0.06)));
  sayTurned();
});
function sayTurned() {
  const [azimuth, elevation] = session.camera.map(angle);
  $("spoken").textContent = say("light.turned", { azimuth, elevation, times: brief(session.zoom) });
  refresh();
}
for (const button of $("cameras").children) {
  button.addEventListener("click", () => {
    session.zoom = 1;
    turnTo(CAMERAS[button.value]);
  });
}
