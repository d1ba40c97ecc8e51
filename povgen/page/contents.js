// What is in the window: what the lines of sight through it meet.

import { landing, meets } from "./apparent.js";
import { abs, finite, minus, plus, scaled, turn } from "./complex.js";
import { data } from "./data.js";
import { apparentOutline, apparentPosition, isBesideSecond, outside } from "./moment.js";
import { outlineOf, within } from "./outline.js";
import { FLOOR, state } from "./state.js";

// The line of sight through a place of the plane z = 0, behind the last window: its slope, and where it crosses the plane at
// the distance z1. `beside` if it misses the second window. null if no light passes.
function sight(now, place) {
  const { windows, z1 } = now;
  const path = now.follow(scaled(1 / now.z2, minus(place, now.E)));
  if (isBesideSecond(now, place)) return { ...meets(path, 1), point: place, beside: true };
  const point = landing(path, windows, z1);
  return point && { slope: path.at(-1).slope, point };
}

// What a line of sight meets: "thing" (the object at L), or one of the names in SHOWN.
function met(now, line) {
  if (!line) return "dark";
  const { L, objects, z1, radii } = now;
  const { slope, point, beside } = line;
  const [x, y] = minus(point, L);
  if (beside) {
    // seen without the second window: not as the windows show it
  } else if (state.scene === "spheres") {
    if (abs([x, y]) <= radii[objects.indexOf(z1)]) return "thing";
  } else {
    const lines = outlineOf(state.piece);
    if (!lines.length || within([x, y], lines)) return "thing";  // the outline may not be known yet
    const half = data.pedestals[state.piece];
    const crosses = ([x, y]) => Math.abs(x) <= half && y <= 0 && y >= FLOOR - L[1];
    if ([-half, 0, half].some((z) => crosses(plus([x, y], scaled(z, slope))))) return "pedestal";
  }
  if (slope[1] < 0) return state.scene === "spheres" ? "ground" : "floor";
  return slope[1] < MOUNTAINS ? "mountains" : "sky";
}

const MOUNTAINS = 0.05;  // slope: most mountains are higher
// in the order in which they are said
export const SHOWN = ["pedestal", "others", "floor", "ground", "mountains", "sky", "dark"];
const PLACES = [-0.98, -0.8, -0.6, -0.4, -0.2, 0, 0.2, 0.4, 0.6, 0.8, 0.98];  // of half the window

// What the eye sees through a place of the window.
export const seenAt = (now, place) => met(now, sight(now, place));

// The names of what the window shows: of what it shows at a grid of places, and of small objects.
export const contents = (now) => (now.contents ??= foundInWindow(now));

function foundInWindow(now) {
  const half = now.scene.aperture / 2;
  /** @type {Set<string>} */
  const found = new Set(PLACES.flatMap((x) => PLACES.map((y) => met(now, sight(now, [x * half, y * half])))));
  const outline = () => apparentOutline(now, outlinePoints(now).map((d) => plus(now.L, d)));
  if (!found.has("thing") && outline().some((place) => isInWindow(now, place))) found.add("thing");
  const seen = (z1) => isInWindow({ ...now, z1 }, apparentPosition(now, now.L, { ...now, z1 }));
  if (now.objects.some((z1) => z1 !== now.z1 && seen(z1))) found.add("others");
  return found;
}

const isInWindow = (now, place) =>
  finite(place) && !outside(place, now.scene) && !isBesideSecond(now, place);

// Points of the object's outline, from L.
function outlinePoints({ objects, z1, radii }) {
  if (state.scene === "chess") return outlineOf(state.piece).flatMap((line) => line.filter((_, n) => n % 4 === 0));
  return [[0, 0], ...Array.from({ length: 12 }, (_, k) => scaled(radii[objects.indexOf(z1)], turn((k * Math.PI) / 6)))];
}
