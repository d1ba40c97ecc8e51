// What the page shows, and the numbers that follow from it. Lengths are in tiles, points are [x, y] as the eye sees them.

const $ = (id) => document.getElementById(id);
const data = JSON.parse($("data").textContent);

const FLOOR = geometry.floorY(data.scenes.chess);
const pick = (values, ...names) => Object.fromEntries(names.map((name) => [name, values[name]]));
const START = {
  chess: { L: [data.scenes.chess.x, FLOOR + data.scenes.chess.pedestal], z1: data.scenes.chess.z1 },
  spheres: { L: data.scenes.spheres.line, z1: data.scenes.spheres.z2 },
};
const OPENING = {
  scene: "chess", sheet: "ideal", alpha: data.scenes.chess.alpha, z2: data.scenes.chess.z2, prisms: data.scenes.chess.prisms,
  piece: data.scenes.chess.piece, E: [0, 0], ...START.chess,
  windows: 1, alpha2: 120, d: 2, ratio: 0.7, axis: [0, 1, 0],    // beyond the paper: beyond.js
  position: false, circles: false, image: false, caption: false,  // what is drawn on the picture
  diagram: "picture", question: -1,                              // the diagram's orientation; the question, or -1
};
const RANGES = {
  alpha: [-360, 360], z1: [0.01, 5000], z2: [0.01, 150], prisms: [1, data.limits.prisms],
  windows: [1, 2], alpha2: [-360, 360], d: [0.01, 100], ratio: [0.1, 10],
};
const CHOICES = {
  scene: ["chess", "spheres"], sheet: ["none", "single", "detailed", "ideal", "axis", "refraction", "lenslets", "mirror"], diagram: ["picture", "paper"],
  piece: data.pieces,
};
const ASIDE = 10;           // |x| and |y| of L and E are at most this
const LEAST_PEDESTAL = 0.2;
const state = { ...OPENING };

const clamped = (x, [least, most]) => Math.min(most, Math.max(least, x));

let refusals = [];  // sentences that say which values were not allowed in the last change

// Change values of the state to the nearest allowed ones. Another scene begins with its own L and z1.
function change(values) {
  const { axis } = state;
  if (values.scene && values.scene !== state.scene) values = { ...START[values.scene], ...values };
  Object.assign(state, values);
  refusals = [];
  const limited = (name, x, [least, most], why = "") => {
    const kept = clamped(x, [least, most]);
    if (kept !== x) refusals.push(`${name} is at ${x < least ? "least" : "most"} ${brief(kept)}${name === SYMBOL.alpha || name === SYMBOL.alpha2 ? "°" : ""}${why}.`);
    return kept;
  };
  for (const [name, range] of Object.entries(RANGES)) state[name] = limited(SYMBOL[name], state[name], range);
  if (!Number.isInteger(state.prisms)) refusals.push("N is a whole number.");
  for (const name of ["prisms", "windows"]) state[name] = Math.round(state[name]);
  const { L, E } = state;
  const aside = [-ASIDE, ASIDE];
  // in the chess scene, a pedestal and the floor are below
  const heights = state.scene === "chess" ? [[FLOOR + LEAST_PEDESTAL, FLOOR + 10], [FLOOR + 0.05, ASIDE]] : [aside, aside];
  const why = (y, [least]) => (state.scene === "chess" && y < least ? ": the floor is below" : "");
  state.L = [limited("x of L", L[0], aside), limited("y of L", L[1], heights[0], why(L[1], heights[0]))];
  state.axis = state.axis.map((part, k) => limited(`${"xyz"[k]} of the axis`, part, [-1, 1]));
  if (!state.axis.some(Boolean)) {
    refusals.push("An axis of 0, 0, 0 has no direction: the axis stays as it was.");
    state.axis = axis;
  }
  if (state.sheet === "single") state.windows = 1;
  state.E = [limited("x of E", E[0], aside), limited("y of E", E[1], heights[1], why(E[1], heights[1]))];
}

// ---- Settings that a movie, another choice or Reset replaces ----

let replaced = null;  // all values before, and the new values of those that were the user's own

// Change values, and keep what the user had set, for Undo. `chosen`: names of values that the user has chosen.
function replace(values, chosen = []) {
  const before = { ...state };
  const usual = { ...OPENING, ...START[state.scene], ...BEYOND[chosenBeyond()] };
  change(values);
  const lost = Object.keys(SETTINGS).filter((name) =>
    !chosen.includes(name) && [state, usual].every((other) => String(other[name]) !== String(before[name])));
  if (lost.length && state.question < 0) replaced = { before, values: pick(state, ...lost) };
}

// The names of the settings that still have the values that replaced the user's own.
const replacedNames = () => Object.entries(replaced?.values ?? {}).filter(([name, value]) => String(state[name]) === String(value)).map(([name]) => name);

// ---- The scene ----

// The least distance of the eye: just in front of the window frame, or far enough to see through a deep one.
const leastZ2 = (back) => back * (1 + 3 * clamped((back - 1) / 3, [0, 1])) + 0.011;

// The values of povgen's scene, for the live view. z1 and z2 are large enough for the sheets' depth.
function sceneValues() {
  const { scene, sheet, alpha, prisms, piece, L, E, ratio, axis, alpha2, d } = state;
  const values = { ...data.scenes[scene], sheet, alpha, prisms, ratio, axis, eye: E, faces: data.faces };
  if (inSeries()) values.window = [{ alpha: alpha2, z: Math.max(d, geometry.depth(values) + 0.011), sheet: null }];
  const back = geometry.depth(values) / 2;
  values.z2 = Math.max(state.z2, leastZ2(back));
  if (scene === "spheres") return { ...values, line: L };
  const foot = data.pedestals[piece];
  const z1 = Math.max(state.z1, back + foot + 0.001);
  return { ...values, piece, pedestal_halves: data.pedestals, z1, x: L[0], pedestal: L[1] - FLOOR };
}

// All numbers that the page shows. Angles are in radians, but `degrees`.
function moment() {
  const scene = sceneValues();
  const { z2, alpha: degrees, sheet } = scene;
  const objects = geometry.distances(scene);
  const z1 = objects.reduce((best, z) => (Math.abs(Math.log(z / state.z1)) < Math.abs(Math.log(best / state.z1)) ? z : best));
  const alpha = sheet === "none" ? 0 : radians(degrees);
  const r = z2 / z1;
  const now = { scene, sheet, degrees, alpha, z1, z2, r, objects, L: state.L, E: state.E, prism: geometry.prism(scene) };
  now.radii = state.scene === "spheres" ? geometry.spheres(scene).map(({ radius }) => radius) : [data.feet[state.piece]];
  now.behind = behindFirst(scene);
  if (now.behind.length) {
    [[now.d]] = now.behind;
    now.Z = equations.depth(z1, z2, alpha, now.behind);
    now.total = alpha + now.behind[0][1];
  }
  // the paper's window; or a choice beyond the paper
  now.two = (sheet === "ideal" || sheet === "detailed") && !now.Z;
  now.beyond = Boolean(now.Z) || OTHER_SHEETS.includes(sheet);
  now.P = equations.P(r, alpha);
  now.place = markedPosition(now);
  Object.assign(now, appearance(now));
  // whether the light from L, on its way through the first window, misses the second one
  now.beside = Boolean(now.Z) && now.M <= NEAR_POLE && !outside(now.place, scene) && outside(atSecondWindow(now), scene);
  // near the pole, the window shows a small part of the object's plane: its width
  now.nearPole = now.M > NEAR_POLE && (now.two || Boolean(now.Z) || sheet === "lenslets" || now.M === Infinity);
  now.seen = scene.aperture / now.M;
  return now;
}
const NEAR_POLE = 12;  // a larger M is near the pole

// The point of the plane z = 0 at which the sheets show a point, by default L.
// Through the other sheets, light that passes the point at a distance of up to `near` counts too.
function apparentPosition(now, L = now.L, { z1, z2, alpha } = now, near = 0) {
  const { E, prism, behind } = now;
  if (imagingPole(now.scene, z1, z2)) return [Infinity, 0];
  if (OTHER_SHEETS.includes(now.sheet)) return crossing(L, E, z1, z2, now.scene, near);
  if (now.sheet === "single") return equations.mirrored(L, E, z1, z2, prism);
  if (now.sheet === "detailed") return equations.prisms(L, E, z1, z2, alpha, prism, behind);
  return equations.ideal(L, E, z1, z2, alpha, behind);
}

// Where an object is marked: where its middle is seen, or a place close to it if only a part beside the middle is seen.
const markedPosition = (now) => apparentPosition(now, now.L, now, now.radii[now.objects.indexOf(now.z1)]);

// The angle nu by which an object appears rotated, and its magnification M. A single sheet mirrors: nu is NaN, and M is that
// of the width; `height` is that of the height. Of the other sheets, M is that of the area, as a length.
function appearance(now) {
  const { sheet, z1, z2, alpha, prism, behind } = now;
  if (imagingPole(now.scene, z1, z2)) return { nu: NaN, M: Infinity };
  if (OTHER_SHEETS.includes(sheet)) return { nu: NaN, M: Math.sqrt(Math.abs(determinant(shownSteps(now)))) };
  if (sheet === "single") return { nu: NaN, M: z2 / (z1 + z2 - prism.slab_shift), height: Math.abs(z2 / (z2 - z1)) };
  if (sheet === "detailed") return equations.turned(z1, z2, alpha, prism, behind);
  if (behind.length) {
    const Z = equations.depth(z1, z2, alpha, behind);
    return { nu: abs(Z) === 0 ? NaN : -arg(Z), M: z2 / abs(Z) };
  }
  return { nu: equations.nu(z2 / z1, alpha), M: equations.M(z2 / z1, alpha) };
}

// How a short step of the object to the right, and one up, appears: for each tile of the step.
const shownSteps = (now) => [[1e-3, 0], [0, 1e-3]].map((h) => scaled(500, minus(apparentPosition(now, plus(now.L, h)), apparentPosition(now, minus(now.L, h)))));

// Where the object must be moved to appear moved by a step, tiles: the inverse of the linear map of `apparentPosition`.
function objectStep(now, step) {
  const steps = shownSteps(now);
  const area = determinant(steps);
  if (!Number.isFinite(area) || Math.abs(area) > 50 || Math.abs(area) < 1e-6) return step;
  return resolved(step, steps);
}

// Whether the prediction can be wrong by pixels. The limits are in povgen/scene/limits.py.
function unsure(now) {
  if (now.sheet === "none" || OTHER_SHEETS.includes(now.sheet)) return false;
  if (now.sheet === "ideal") return now.M > data.limits.condition;
  return !(possibleError(now) <= data.limits.error);
}

// By how many pixels of 1280x960 the prediction can be wrong, for one sheet or windows of prisms: povgen/scene/prediction.py.
function possibleError(now) {
  const { sheet, scene, E, z1, z2, alpha, behind, prism, place, radii, objects } = now;
  const { M, height } = appearance(now);
  const single = sheet === "single";
  const k = single ? [[1 / prism.pitch, 0]] : equations.frequencies(z2, alpha, prism, behind);
  const { A, B } = equations.depths(z1, z2, alpha, prism, behind);
  const scale = z2 / Math.abs(single ? z2 - z1 : abs(A) - abs(B));
  if (!Number.isFinite(scale)) return Infinity;
  const [least, most] = data.limits.radii;
  const apparent = Math.min(Math.max((single ? height : M) * radii[objects.indexOf(z1)], least), most);
  return (equations.possibleError(k, scale, apparent, abs(minus(place, E)) / z2, z2, prism, scene.index) / scene.view) * 960;
}

// ---- The state in the page's address ----

const short = (x) => String(Number(x.toPrecision(7)));
// What only some of the scenes have.
const OWN_VALUES = { none: [], series: ["windows", "alpha2", "d"], axis: ["axis"], refraction: ["ratio"], lenslets: ["ratio"], mirror: [] };
const SWITCHES = ["position", "circles", "image", "caption"];

function toHash() {
  const { scene, sheet, piece, question } = state;
  const parts = { scene, sheet };
  if (scene === "chess") parts.piece = piece;
  for (const name of ["alpha", "z1", "z2", "prisms"]) parts[name] = short(state[name]);
  for (const name of OWN_VALUES[chosenBeyond()]) parts[name] = [state[name]].flat().map(short).join(",");
  for (const name of ["L", "E"]) parts[name] = state[name].map(short).join(",");
  parts.show = SWITCHES.filter((name) => state[name]).join(",");
  parts.diagram = state.diagram;
  if (question >= 0) parts.question = question + 1;
  return `#${Object.entries(parts).map(([name, value]) => `${name}=${encodeURIComponent(value).replaceAll("%2C", ",")}`).join("&")}`;
}

// Take the values from an address. What is missing or wrong there has the value that the page opens with. A question whose
// answer has not been revealed is shown as before its answer.
function fromHash(hash) {
  const given = new URLSearchParams(hash.slice(1));
  const values = {};
  for (const [name, allowed] of Object.entries(CHOICES)) if (allowed.includes(given.get(name))) values[name] = given.get(name);
  for (const name of Object.keys(RANGES)) if (isNumber(given.get(name))) values[name] = Number(given.get(name));
  for (const [name, count] of [["L", 2], ["E", 2], ["axis", 3]]) {
    const parts = (given.get(name) ?? "").split(",");
    if (parts.length === count && parts.every(isNumber)) values[name] = parts.map(Number);
  }
  if (given.has("show")) for (const name of SWITCHES) values[name] = given.get("show").split(",").includes(name);
  const question = Number(given.get("question")) - 1;
  if (QUESTIONS[question]) Object.assign(values, { question }, revealed.has(question) ? {} : QUESTIONS[question].before);
  Object.assign(state, OPENING, START[values.scene ?? "chess"]);
  change(values);
  [replaced, own] = [null, {}];
}
const isNumber = (text) => Boolean(text?.trim()) && Number.isFinite(Number(text));
