// What is in the window: what the lines of sight through it meet.

import { abs, finite, minus, plus, scaled, times, turn } from "./complex.js";
import { data } from "./data.js";
import * as equations from "./equations.js";
import { apparentPosition, outside } from "./moment.js";
import { outlineOf, within } from "./outline.js";
import { FLOOR, state } from "./state.js";

const NO_DEPTH = { slab_shift: 0, separation: 0 };  // of sheets without thickness

// The line of sight through a place of the plane z = 0, behind the last window: its slope, and where it crosses the plane at
// the distance z1. `beside` if it misses the second window. null if no light passes.
function sight(now, place) {
  const { scene, sheet, E, z1, z2, alpha, prism, behind } = now;
  const slope = scaled(1 / z2, minus(place, E));
  if (now.bend) {
    const after = now.bend(slope, place);
    return after && { slope: after, point: plus(place, scaled(z1, after)) };
  }
  if (sheet === "single") {
    const [x, y] = slope;
    return { slope: [x, -y], point: plus(E, [x * (z2 + z1 - prism.slab_shift), y * (z2 - z1)]) };
  }
  if (behind.length && outside(equations.atSecondWindow({ ...now, place }), scene)) {
    const after = times(slope, turn(-alpha));
    return { slope: after, point: plus(place, scaled(now.d + z1, after)), beside: true };
  }
  const depths = sheet === "detailed" ? prism : NO_DEPTH;
  const after = times(slope, turn(-(now.total ?? alpha)));
  return { slope: after, point: equations.behind(place, E, z1, z2, alpha, depths, behind) };
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
export const SHOWN = {
  pedestal: "the pedestal", others: "other spheres", floor: "the floor", ground: "the ground", mountains: "mountains", sky: "sky",
  dark: "black parts",
};
const PLACES = [-0.98, -0.8, -0.6, -0.4, -0.2, 0, 0.2, 0.4, 0.6, 0.8, 0.98];  // of half the window

// The names of what the window shows: of what it shows at a grid of places, and of small objects.
export const contents = (now) => (now.contents ??= foundInWindow(now));

function foundInWindow(now) {
  const half = now.scene.aperture / 2;
  /** @type {Set<string>} */
  const found = new Set(PLACES.flatMap((x) => PLACES.map((y) => met(now, sight(now, [x * half, y * half])))));
  const seen = (d, z1) => isInWindow({ ...now, z1 }, apparentPosition(now, plus(now.L, d), { ...now, z1 }));
  if (!found.has("thing") && outlinePoints(now).some((d) => seen(d, now.z1))) found.add("thing");
  if (now.objects.some((z1) => z1 !== now.z1 && seen([0, 0], z1))) found.add("others");
  return found;
}

const isInWindow = (now, place) =>
  finite(place) && !outside(place, now.scene) && !(now.Z && outside(equations.atSecondWindow({ ...now, place }), now.scene));

// Points of the object's outline, from L.
function outlinePoints({ objects, z1, radii }) {
  if (state.scene === "chess") return outlineOf(state.piece).flatMap((line) => line.filter((_, n) => n % 4 === 0));
  return [[0, 0], ...Array.from({ length: 12 }, (_, k) => scaled(radii[objects.indexOf(z1)], turn((k * Math.PI) / 6)))];
}
