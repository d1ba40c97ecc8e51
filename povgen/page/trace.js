// The exact ray trace through the sheets of Dove prisms, or of lenses, in a window, with numbers of 64 bits: povgen/optics/trace.py, whose
// comments explain the method. x, y and z are the scene's, in tiles.

import { radians, shape, sheets } from "../liveview/geometry.js";

const [NONE, BASE, NEAR, TOP, FAR] = [0, 1, 2, 3, 4];  // faces of a prism, as in trace.py; those of lenses are 1 and 2
const BORDER = 255;                                     // in place of a face: the border between two lenses
const ROUNDING = 1e-12;                                 // of a lens's width: by how much a ray may miss its end
// The faces of the designed path in each sheet, for a ray that runs to greater z.
const PRISMS = [NEAR, BASE, FAR], LENSES = [1, 2];

/** The shape of the last window: many rays pass the same one.
 * @type {any} */
let known = {};

const copysign = (size, sign) => (sign < 0 ? -size : size);

/** Follow a ray through the sheets of a window. It starts outside of them and runs towards them. `frame` is the extent of the
 * window's frame along z. `steps` are the faces that the ray meets: where, the number of the face, and whether it reflects the ray
 * totally. `end` is "through", "back" (leaves where it came from), "frame", "black" (meets a blackened top), or "unfinished" (has
 * met `most` faces). `designed`: whether it took the designed path. `place` and `direction` are those at its end.
 * @param {any} window */
export function passage(window, from, towards, { most = 60, frame = 0 } = {}) {
  if (window !== known.window) known = { window, found: shape(window), layers: sheets(window) };
  const { found: { pitch, height, length, index, edges }, layers } = known;
  const { values } = window, lenses = edges.map((edge) => edge.map((x) => pitch * x));
  const halfWindow = values.aperture / 2, half = length / 2, first = -halfWindow + (lenses.length ? 0 : (values.gap * pitch) / 2);
  const [cosine, sine] = [Math.cos(radians(values.base_angle)), Math.sin(radians(values.base_angle))];
  const normals = { [BASE]: [-1, 0], [NEAR]: [cosine, -sine], [TOP]: [1, 0], [FAR]: [cosine, sine] };
  const facets = [[NEAR, -sine], [FAR, sine]];
  const size = Math.hypot(...towards), forward = towards[2] > 0;
  let place = [from[0], from[1], from[2] - window.z], direction = towards.map((x) => x / size);
  const steps = [], wanted = lenses.length ? LENSES : PRISMS;
  let orders = 0;  // how many lenses lie between that by which a ray has entered a sheet and that by which it has left it
  let at = forward ? 0 : layers.length - 1;
  const isOutside = (x, y) => Math.max(Math.abs(x), Math.abs(y)) > halfWindow;

  const ended = (end) => {
    const path = layers.flatMap(() => (forward ? wanted : [...wanted].reverse()));
    const designed = end === "through" && !orders && steps.length === path.length && steps.every(({ face }, n) => face === path[n]);
    return { place: [place[0], place[1], place[2] + window.z], direction, end, steps, designed };
  };

  for (;;) {
    if (at < 0 || at === layers.length) {
      const way = Math.max(0, (copysign(frame / 2, direction[2]) - place[2]) / direction[2]);
      if (isOutside(place[0] + way * direction[0], place[1] + way * direction[1])) return ended("frame");
      return ended((direction[2] > 0) === forward ? "through" : "back");
    }
    // To the surface of the next sheet. From there on x, u and z are the sheet's own, with u above the base of prism `cell`.
    const { angle, centre } = layers[at], [c, s] = [Math.cos(angle), Math.sin(angle)];
    const surface = copysign(half, -direction[2]);
    const way = (surface - place[2] + centre) / direction[2];
    const [X, Y] = [0, 1].map((k) => place[k] + way * direction[k]);
    if (isOutside(X, Y)) {
      place = [X, Y, surface + centre];
      return ended("frame");
    }
    const v = c * Y - s * X;
    let cell = Math.floor((v - first) / pitch), glass = false;
    let [x, u, z] = [c * X + s * Y, v - first - cell * pitch, surface];
    let entered = NaN, last = NaN, normal = [0, 0];
    let [dx, dy, dz] = [c * direction[0] + s * direction[1], c * direction[1] - s * direction[0], direction[2]];
    const outside = () => {
      const y = u + cell * pitch + first;
      place = [c * x - s * y, s * x + c * y, z + centre];
      direction = [c * dx - s * dy, s * dx + c * dy, dz];
      return isOutside(place[0], place[1]);
    };
    for (;;) {
      const [t, face] = lenses.length ? wayToLens() : glass ? wayOut() : wayIn();
      x += t * dx;
      u += t * dy;
      z += t * dz;
      if (outside()) return ended("frame");
      if (face === NONE) break;
      if (face === BORDER) {
        [cell, u] = dy > 0 ? [cell + 1, 0] : [cell - 1, pitch];
        continue;
      }
      if (Number.isNaN(entered)) entered = cell;
      last = cell;
      const [nu, nz] = lenses.length ? normal : normals[face], along = nu * dy + nz * dz, eta = glass ? index : 1 / index;
      const square = 1 - eta ** 2 * (1 - along ** 2), total = square < 0;
      steps.push({ place: [place[0], place[1], place[2] + window.z], face, total });
      if (face === TOP && values.black_tops && !lenses.length) return ended("black");
      const change = total ? -2 * along : copysign(Math.sqrt(square), along) - eta * along, scale = total ? 1 : eta;
      [dx, dy, dz] = [scale * dx, scale * dy + change * nu, scale * dz + change * nz];
      if (!total) {
        if (face === BASE && !lenses.length) [cell, u] = glass ? [cell - 1, pitch] : [cell + 1, 0];  // through the air between two prisms
        glass = !glass;
      }
      if (steps.length === most) {
        outside();
        return ended("unfinished");
      }
    }
    if (last !== entered && !Number.isNaN(last)) orders++;
    at += direction[2] > 0 ? 1 : -1;

    // Where the ray meets a lens or a border, and which. Only lenses count that it crosses in the right direction: so it does not
    // meet the lens again that it has just met.
    function wayToLens() {
      const outwards = glass ? 1 : -1, square = dy ** 2 + dz ** 2;
      let [t, face] = [dy === 0 ? Infinity : ((dy > 0 ? pitch : 0) - u) / dy, BORDER];
      lenses.forEach(([su, sz, eu, ez, radius], n) => {
        const chord = Math.hypot(eu - su, ez - sz), least = ROUNDING * Math.max(pitch, Math.abs(radius));
        const [tu, tz] = [(eu - su) / chord, (ez - sz) / chord], sagitta = copysign(Math.sqrt(radius ** 2 - chord ** 2 / 4), radius);
        const [qu, qz] = [u - (su + eu) / 2 + sagitta * tz, z - (sz + ez) / 2 - sagitta * tu];
        const b = qu * dy + qz * dz, root = b ** 2 - square * (qu ** 2 + qz ** 2 - radius ** 2);
        const reach = (outwards * Math.sign(radius) * Math.sqrt(root) - b) / square;
        const [hu, hz] = [u + reach * dy - su, z + reach * dz - sz], along = tu * hu + tz * hz;
        const meets = root > 0 && reach > -least && reach < t && along >= -least && along <= chord + least;
        if (!meets || Math.sign(radius) * (tz * hu - tu * hz) < -least) return;  // the circle's other part
        [t, face, normal] = [reach, n + 1, [(qu + reach * dy) / radius, (qz + reach * dz) / radius]];
      });
      t = Math.max(t, 0);
      if (glass) return [t, face];
      const side = dz === 0 ? Infinity : Math.max((copysign(half, dz) - z) / dz, 0);
      return side < t || (side === t && face === BORDER) ? [side, NONE] : [t, face];
    }

    // For a slanted facet: how fast the ray approaches its plane from inside, and when it meets it.
    function approach(sideways) {
      const along = cosine * dy + sideways * dz;
      return [along, (sine * half - cosine * u - sideways * z) / along];
    }

    // Where the ray, which is in the glass, meets a face, and which one.
    function wayOut() {
      let [t, face] = dy === 0 ? [Infinity, BASE] : [((dy > 0 ? height : 0) - u) / dy, dy > 0 ? TOP : BASE];
      for (const [facet, sideways] of facets) {
        const [along, reach] = approach(sideways);
        if (along > 0 && reach < t) [t, face] = [reach, facet];
      }
      return [Math.max(t, 0), face];
    }

    // The same for a ray in the air. The base is that of the prism above.
    function wayIn() {
      const up = dy > 0;
      let enters = up || dy === 0 ? (u > height ? Infinity : -Infinity) : (height - u) / dy, face = TOP;
      let leaves = dy === 0 ? Infinity : ((up ? height : 0) - u) / dy;
      for (const [facet, sideways] of facets) {
        const [along, reach] = approach(sideways);
        if (along > 0 && reach < leaves) leaves = reach;
        if (along < 0 && reach > enters) [enters, face] = [reach, facet];
        if (along === 0 && reach < 0) enters = Infinity;
      }
      let t = enters > -1e-12 * pitch && enters < leaves && leaves >= 0 ? Math.max(enters, 0) : Infinity;
      const base = up ? Math.max((pitch - u) / dy, 0) : Infinity;
      if (base < t) [t, face] = [base, BASE];
      const side = dz === 0 ? Infinity : Math.max((copysign(half, dz) - z) / dz, 0);
      return side <= t ? [side, NONE] : [t, face];
    }
  }
}
