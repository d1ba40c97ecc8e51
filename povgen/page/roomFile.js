// A room's file (docs/rooms.md), as povgen reads it: what it states, and the scene that the live view draws. What the page knows of
// rooms is from povgen/page/rooms.py.

import { shape, radians, thickness } from "../liveview/geometry.js";
import { hasPrisms } from "../liveview/sheets.js";
import { data, element, pick } from "./data.js";
import { say } from "./language.js";
import { parsed } from "./toml.js";

const { tables, objects: KINDS, most, movies, letters } = data.rooms;

// What is wrong with a file, in a sentence.
export class Fault extends Error {}
/** @type {(sentence: string, values: object) => any} */
function fault(sentence, values) {
  throw new Fault(say(`rooms.${sentence}`, values));
}
function notAllowed(name, value, allowed) {
  fault("not_allowed", { name, value: String(JSON.stringify(value)).slice(0, 60), allowed });
}

// ---- What the file states ----

const TEXTS = {
  name: [/^([A-Za-z][A-Za-z0-9_]{0,30})?$/, "A–Z a–z 0–9 _"],
  text: [new RegExp(`^[${letters}]{1,60}$`), "A–ÿ, Α–Ω, 0–9 (1–60)"],
};
const pen = element("canvas").getContext("2d");

// A colour's red, green and blue, 0 to 1; undefined if the text is none.
function rgb(text) {
  const [one, other] = ["#000000", "#ffffff"].map((before) => {
    pen.fillStyle = before;
    pen.fillStyle = text;
    return pen.fillStyle;
  });
  return one === other && one.startsWith("#") ? [1, 3, 5].map((k) => parseInt(one.slice(k, k + 2), 16) / 255) : undefined;
}

/** @type {(x: any, field: any) => boolean} */
const isNumber = (x, [, least, most, whole, size]) =>
  typeof x === "number" && x >= least && x <= most && Math.abs(x) >= size && (!whole || Number.isInteger(x));
function isDirection(list, [usual, least, most, , size]) {
  if (!Array.isArray(list) || list.length !== usual.length) return false;
  return list.every((x) => isNumber(x, [0, least, most, false, 0])) && Math.max(...list.map(Math.abs)) >= size;
}

// A value that is allowed: `field` says what is (povgen/page/rooms.py).
function allowed(name, value, field, said) {
  const [usual, least, most] = field, range = say("controls.range", { least, most });
  if (Array.isArray(least)) return least.includes(value) ? value : notAllowed(said, value, least.join(", "));
  if (Array.isArray(usual)) return isDirection(value, field) ? value : notAllowed(said, value, `[x, y, z], ${range}`);
  if (least !== undefined) return isNumber(value, field) || value === usual ? value : notAllowed(said, value, range);
  if (typeof usual === "boolean") return value === true || value === false ? value : notAllowed(said, value, "true, false");
  if (typeof value === "string" && (TEXTS[name] ? TEXTS[name][0].test(value) : rgb(value))) return value;
  return notAllowed(said, value, TEXTS[name]?.[1] ?? "#c87529");
}

// The values of a table, also those that it does not state. `of` is what the table is of, in messages.
function checked(given, fields, of = "") {
  if (typeof given !== "object" || Array.isArray(given)) notAllowed(of, given, `[${of}]`);
  const known = Object.keys(fields), said = (name) => [of, name].filter(Boolean).join(".");
  const strange = Object.keys(given).find((name) => !known.includes(name));
  if (strange) fault("unknown", { name: said(strange), allowed: known.join(", ") });
  const value = (name) => (Object.hasOwn(given, name) ? allowed(name, given[name], fields[name], said(name)) : fields[name][0]);
  return Object.fromEntries(known.map((name) => [name, value(name)]));
}

function tablesOf(given, name) {
  if (!Array.isArray(given)) notAllowed(name, given, `[[${name}]]`);
  if (given.length > most[name]) notAllowed(`[[${name}]]`, given.length, say("controls.range", { least: 0, most: most[name] }));
  return given;
}

function stated(text) {
  const { size } = new Blob([text]);
  if (size > most.bytes) fault("not_allowed", { name: "text", value: `${size} bytes`, allowed: `${most.bytes} bytes` });
  try {
    return parsed(text.replace(/^\ufeff/, ""));
  } catch ({ message: number }) {
    return fault("unread", { number, text: text.split("\n")[number - 1].trim().slice(0, 60) });
  }
}

// The room that a file states: its eye, its windows and its objects, with all values. Throws a Fault.
export function roomOf(text) {
  const whole = stated(text), { scene = "room", eye = {}, window = [], object = [], ...given } = whole, count = {};
  if (Object.keys(whole).every((name) => movies.includes(name))) fault("nothing", { allowed: "[eye], [[window]], [[object]]" });
  const others = Object.fromEntries(Object.entries(given).filter(([name]) => !movies.includes(name)));
  if (scene !== "room") notAllowed("scene", scene, "room");
  const named = (kind, made) => ({ ...made, kind, name: made.name || `${kind}${count[kind]}` });
  const next = (kind) => `${kind}${(count[kind] = (count[kind] ?? 0) + 1)}`;
  const windows = tablesOf(window, "window").map((each) => {
    const of = next("window");
    return named("window", checked(each, tables.window, of));
  });
  const things = tablesOf(object, "object").map((each) => {
    const { kind, ...own } = typeof each === "object" ? each : {};
    if (!Object.hasOwn(KINDS, kind)) notAllowed("kind", kind, Object.keys(KINDS).join(", "));
    const of = next(kind);
    return named(kind, checked(own, { ...tables.placed, ...KINDS[kind] }, of));
  });
  const names = ["eye", ...[...windows, ...things].map(({ name }) => name.toLowerCase())];
  const twice = names.find((name, k) => names.indexOf(name) < k);
  if (twice) fault("twice", { name: twice });
  /** @type {any} */
  const room = { ...checked(others, tables.room), title: given.title, windows, objects: things };
  room.eye = { ...checked(eye, tables.eye, "eye"), name: "eye" };
  const [, least, most] = tables.room.focus;
  if (room.pupil && room.focus === "best") notAllowed("focus", "best", say("controls.range", { least, most }));
  for (const each of windows.filter(hasPrisms)) {
    const { length, edges } = shape({ ...each, values: valuesOf(each) });
    const exists = [length, ...edges.flat()].every(Number.isFinite);
    if (!exists) notAllowed(`${each.name}.sheet`, each.sheet, "index, base_angle, f_number …");
  }
  return room;
}

// The room after other numbers of its eye and its windows, by names such as left.alpha. What is not allowed is left out.
export function withNumbers(room, numbers) {
  const moved = (part, fields) => {
    const own = Object.keys(fields).map((name) => [name, numbers[`${part.name}.${name}`]]);
    return { ...part, ...Object.fromEntries(own.filter(([name, x]) => isNumber(x, fields[name]))) };
  };
  return { ...room, eye: moved(room.eye, tables.eye), windows: room.windows.map((each) => moved(each, tables.window)) };
}

// ---- The scene: povgen/liveview/values.py ----

const THICK = 0.02;  // of a board
const NUMBERS = {
  box: ({ width, height, depth }) => [width / 2, height / 2, depth / 2, 0],
  pedestal: ({ width, height }) => [width / 2, height, 0, 0],
  piece: ({ piece }, { names }) => [names.indexOf(piece), 0, 0, 0],
  sphere: ({ radius }) => [radius, -1, 0, 0],
  board(each, { boards }) {
    const place = boards.keys.indexOf(key(each)), { width, height } = boards.canvases[place];
    const [across, up] = each.kind === "text" ? [(each.height * width) / height, each.height] : [each.length + RULER / 2, RULER];
    return [across / 2, up / 2, THICK, place];
  },
};
const drawnAs = (kind) => (kind === "text" || kind === "ruler" ? "board" : kind);

// The place and the axes: povgen/optics/pose.py.
function pose({ x, y, z, yaw, pitch, roll }) {
  const [[cy, sy], [cp, sp], [cr, sr]] = [yaw, pitch, roll].map(radians).map((angle) => [Math.cos(angle), Math.sin(angle)]);
  const turned = [[cr, cp * sr, sp * sr], [-sr, cp * cr, sp * cr], [0, -sp, cp]];
  return { place: [x, y, z], axes: turned.map(([a, b, c]) => [cy * a + sy * c, b, cy * c - sy * a]) };
}

const sides = ({ width, height }) => [width, height ?? width];
const valuesOf = (each) => ({ ...each, aperture: Math.max(...sides(each)) });

// `turned`: the shader is that of turned windows, also for one that is not, so that a slider does not need another one.
function windowOf(each) {
  const { sheet, name, frame, outline } = each, values = valuesOf(each);
  const depth = Math.max(frame ? values.aperture / 10 : 0, 1.02 * thickness({ sheet, values }));
  const half = sides(each).map((side) => side / 2), round = outline === "round";
  return { sheet, name, ...pose(each), turned: true, half, round, depth, framed: frame, values };
}
const NO_WINDOW = {
  sheet: "none", name: "", ...pose({ x: 0, y: 0, z: 0, yaw: 0, pitch: 0, roll: 0 }),
  half: [5e-10, 5e-10], round: false, depth: 0, framed: false, values: { aperture: 1e-9 },
};

// What the view needs beside the scene, and a function from the room, also after other numbers, to its scene.
export function drawing({ objects, ...room }) {
  const boards = boardsOf(objects), names = [...new Set(objects.flatMap(({ piece }) => piece ?? []))];
  const drawn = objects.filter(({ kind }) => kind !== "floor"), kinds = drawn.map(({ kind }) => drawnAs(kind));
  drawn.sort((one, other) => kinds.indexOf(drawnAs(one.kind)) - kinds.indexOf(drawnAs(other.kind)));
  const shown = drawn.map((each) => {
    const kind = drawnAs(each.kind);
    return { kind, ...pose(each), numbers: NUMBERS[kind](each, { names, boards }), colour: rgb(each.color ?? "#000000") };
  });
  const pictures = picturesOf(boards), floor = objects.find(({ kind }) => kind === "floor");
  const volumes = { grid: data.volumes.grid, pieces: pick(data.volumes.pieces, ...names) };
  const scene = ({ eye, windows }) => ({
    name: "room", eye, objects: shown, pictures, floor_y: floor ? floor.y : null, rim: data.scenes.chess.rim,
    windows: windows.length ? windows.map(windowOf) : [NO_WINDOW],
    faces: data.faces * Math.max(1, windows.filter(hasPrisms).length),
    background: room.background, pupil: room.pupil, inverse_focus: room.pupil ? 1 / room.focus : 0,
  });
  return { volumes, scene };
}

// ---- Pictures on boards: povgen/objects/text.py and ruler.py ----

const LETTER = 96, MARGIN = 24, TILE = 160, RULER = 0.4, LONGEST = 8192;  // pixels; the height of a ruler in tiles
const FONTS = { text: `bold ${LETTER}px "Povgen Text"`, ruler: '27px "Povgen Text"' };
// When the fonts can be used.
export const fonts = () => Promise.all(Object.values(FONTS).map((font) => document.fonts.load(font)));

const key = (each) => JSON.stringify(pick(each, "text", "color", "background", "length"));

function sheet(width, height, back) {
  const canvas = element("canvas", { width: Math.round(width), height: Math.round(height) }), pen = canvas.getContext("2d");
  pen.fillStyle = back;
  pen.fillRect(0, 0, canvas.width, canvas.height);
  pen.direction = "ltr";
  return [canvas, pen];
}

function written({ text, color, background }) {
  pen.font = FONTS.text;
  const [canvas, brush] = sheet(Math.round(pen.measureText(text).width) + 2 * MARGIN, LETTER + 2 * MARGIN, background);
  Object.assign(brush, { font: FONTS.text, fillStyle: color });
  brush.fillText(text, MARGIN, MARGIN + 0.82 * LETTER);
  return canvas;
}

function ruled({ length }) {
  const width = length + RULER / 2, tile = Math.min(TILE, LONGEST / width);
  const [canvas, brush] = sheet(width * tile, RULER * tile, "#f4e6b4");
  const font = FONTS.ruler.replace("27", String(Math.max(6, Math.round(0.17 * tile))));
  Object.assign(brush, { font, fillStyle: "#20242a", textAlign: "center" });
  for (let tenth = 0; tenth <= 10 * length; tenth++) {
    const x = (RULER / 4 + tenth / 10) * tile, whole = tenth % 10 === 0;
    const thick = Math.max(1, Math.round((whole ? 0.02 : 0.01) * tile)), mark = whole ? 0.16 : tenth % 5 === 0 ? 0.11 : 0.07;
    brush.fillRect(Math.round(x - thick / 2), 0, thick, Math.round(mark * tile) + 1);
    if (whole) brush.fillText(String(tenth / 10), x, 0.36 * tile);
  }
  return canvas;
}

// The different pictures of all boards.
function boardsOf(objects) {
  const several = new Map(objects.filter(({ kind }) => drawnAs(kind) === "board").map((each) => [key(each), each]));
  const canvases = [...several.values()].map((each) => (each.kind === "text" ? written(each) : ruled(each)));
  return { keys: [...several.keys()], canvases };
}

// One picture with all of them, one above the other, and their places in it.
function picturesOf({ canvases }) {
  if (!canvases.length) return {};
  const high = canvases.reduce((sum, { height }) => sum + height, 0), wide = Math.max(...canvases.map(({ width }) => width));
  const [all, brush] = sheet(wide, high, "#000");
  let top = 0;
  const places = canvases.map((canvas) => {
    brush.drawImage(canvas, 0, top);
    top += canvas.height;
    return [0, (top - canvas.height) / high, canvas.width / wide, canvas.height / high];
  });
  return { cards: { data: all.toDataURL(), places } };
}
