"use strict";

const data = JSON.parse(document.getElementById("data").textContent);

// ---- Complex numbers, [re, im] ----

const minus = (a, b) => [a[0] - b[0], a[1] - b[1]];
const plus = (a, b) => [a[0] + b[0], a[1] + b[1]];
const times = (a, b) => [a[0] * b[0] - a[1] * b[1], a[0] * b[1] + a[1] * b[0]];
const scaled = (k, a) => [k * a[0], k * a[1]];
const conj = (a) => [a[0], -a[1]];
const abs = (a) => Math.hypot(a[0], a[1]);
const arg = (a) => Math.atan2(a[1], a[0]);
const turn = (angle) => [Math.cos(angle), Math.sin(angle)];
const finite = (a) => Number.isFinite(a[0]) && Number.isFinite(a[1]);

// a/b for a other than 0: the complex infinity where b is 0.
function over(a, b) {
  const size = b[0] ** 2 + b[1] ** 2;
  return size === 0 ? [Infinity, 0] : scaled(1 / size, times(a, conj(b)));
}

// ---- The equations ----
// Angles in radians, lengths in tiles, r above 0 and finite. Signs and units as in povgen/optics/rotation.py and
// povgen/optics/paraxial.py, which the tests compare these with.

const equations = (() => {
  // a + b exp(i alpha) for a, b >= 0 without cancellation: (a - b) + 2b cos(alpha/2) exp(i alpha/2).
  function sum(a, b, alpha) {
    const half = alpha / 2;
    const cosine = Math.cos(half);
    // no number is pi: the one next to it counts
    const atPi = a === b && Math.abs(cosine) <= spacing(Math.abs(half)) / 2;
    const product = atPi ? 0 : 2 * b * cosine;
    return [a - b + product * Math.cos(half), product * Math.sin(half)];
  }

  // From x >= 0 to the next greater number.
  function spacing(x) {
    const number = new Float64Array([x]);
    new BigUint64Array(number.buffer)[0] += 1n;
    return number[0] - x;
  }

  // Where light from L = 0 crosses the sheet on its way to E = 1, eq. 7.
  const P = (r, alpha) => over([1, 0], sum(1, r, alpha));

  // E - P for L = 0, E = 1.
  const oneMinusP = (r, alpha) => over([r, 0], sum(r, 1, -alpha));

  // Angle through which an object appears turned about E: arg(1 - P), eq. 8 corrected. NaN at the pole.
  function nu(r, alpha) {
    const inverse = sum(r, 1, -alpha);
    return abs(inverse) === 0 ? NaN : -arg(inverse);
  }

  // How much larger an object appears than in the plane of the sheet: |1 - P|, eq. 9 corrected. Infinite at the pole.
  const M = (r, alpha) => abs(oneMinusP(r, alpha));

  // Where light from L crosses an infinitely fine sheet on its way to E: eq. 7. L and E differ.
  function ideal(L, E, z1, z2, alpha) {
    return plus(E, over(scaled(z2, minus(L, E)), sum(z2, z1, -alpha)));
  }

  // The same for two sheets of prisms of a pitch, by the paraxial prediction (docs/sheets.md).
  function prisms(L, E, z1, z2, alpha, pitch) {
    const { A, B } = depths(z1, z2, alpha, pitch);
    const D = minus(L, E);
    const place = minus(times(conj(A), D), times(B, conj(D)));
    return plus(E, scaled(z2 / (abs(A) ** 2 - abs(B) ** 2), place));
  }

  // The angle through which prisms of a pitch show an object turned, and its magnification: paraxial.nu_and_M.
  function turned(z1, z2, alpha, pitch) {
    const { A, B } = depths(z1, z2, alpha, pitch);
    const M = (z2 * Math.max(abs(A), abs(B))) / Math.abs(abs(A) ** 2 - abs(B) ** 2);
    return { nu: abs(A) > abs(B) ? -arg(A) : NaN, M };
  }

  function depths(z1, z2, alpha, pitch) {
    const { b, h } = sheet(pitch);
    return { A: plus([z2 - h, 0], scaled(z1 - h, turn(-alpha))), B: scaled(b, turn(alpha)) };
  }

  function sheet(pitch) {
    const height = pitch * (1 - data.prism.air_gap);
    const g = data.prism.slab_shift * height;
    const apart = height * data.prism.aspect + pitch * data.prism.air_gap;
    return { b: apart - g, h: (apart + g) / 2 };
  }

  // Where a curve of constant alpha passes through infinity, by z1, or comes nearest to it; z1 and z2 may change places.
  function infiniteZ1(z2, alpha, pitch) {
    const { b, h } = sheet(pitch);
    const half = Math.sqrt(Math.max(0, b ** 2 - ((z2 - h) * Math.sin(alpha)) ** 2));
    return [-half, half].map((aside) => h - (z2 - h) * Math.cos(alpha) + aside);
  }

  // The same for a curve of constant r, by alpha.
  function infiniteAlpha(z1, z2, pitch) {
    const { b, h } = sheet(pitch);
    const cosine = (b ** 2 - (z2 - h) ** 2 - (z1 - h) ** 2) / (2 * (z2 - h) * (z1 - h));
    const alpha = Math.acos(Math.min(1, Math.max(-1, cosine)));
    return [-alpha, alpha];
  }

  return { P, oneMinusP, nu, M, ideal, prisms, turned, infiniteZ1, infiniteAlpha };
})();

const radians = (degrees) => degrees * (Math.PI / 180);

// ---- Numbers as text ----

const SYMBOL = { alpha: "α", z1: "z₁", z2: "z₂" };
const NAME = { alpha: "Ray-rotation angle α", z1: "Distance z₁ behind the sheets", z2: "Distance z₂ of the eye" };

const raised = (n) => [...String(n)].map((digit) => "⁰¹²³⁴⁵⁶⁷⁸⁹"[digit] ?? "⁻").join("");

// The text of toFixed, toPrecision or toExponential with the signs of print; what rounds to 0 has none.
function printed(text) {
  const [digits, power] = text.replace("-", "").split("e");
  const sign = text.startsWith("-") && Number(digits) ? "−" : "";
  return sign + digits + (power ? ` × 10${raised(Number(power))}` : "");
}

const fixed = (x, digits) => printed(Math.abs(x) < 1e5 ? x.toFixed(digits) : x.toExponential(2));
const size = (x) => (Number.isFinite(x) ? printed(x < 1e4 ? x.toPrecision(4) : x.toExponential(2)) : "∞");
const angle = (x) => (Number.isNaN(x) ? "undefined" : `${fixed(x / radians(1), 1)}°`);
const quantity = (name, x) => (name === "alpha" ? `${fixed(x, 1)}°` : `${size(x)} tiles`);
const brief = (name, x) => printed(String(x)) + (name === "alpha" ? "°" : "");

// Both parts with as many decimals as the larger allows in five places.
function point(a) {
  if (!finite(a)) return "∞";
  const decimals = Math.max(0, 3 - Math.floor(Math.log10(Math.max(1, Math.abs(a[0]), Math.abs(a[1])))));
  const [re, im] = a.map((x) => fixed(x, decimals));
  return `${re} ${im.startsWith("−") ? "−" : "+"} ${im.replace("−", "")} i`;
}

// ---- What is shown ----

const $ = (id) => document.getElementById(id);
const slider = $("slider");
const state = { movie: null, sheet: "detailed", prediction: true, playing: false };

// A sphere's name in the list of spheres.
function label(z1, z2) {
  const n = Math.round(Math.log2(z1 / z2));
  return state.movie.powers ? `z₁ = ${n ? `2${raised(n)} ` : ""}z₂` : `z₁ = ${size(z1)}`;
}

// The numbers of the frame at which the slider stands, for the object that was chosen.
function moment() {
  const frame = state.movie.frames[state.sheet][slider.valueAsNumber];
  const labels = frame.z1.map((z1) => label(z1, frame.z2));
  const chosen = Math.max(0, labels.indexOf(state.movie.chosen));
  const z1 = frame.z1[chosen];
  const [r, alpha] = [frame.z2 / z1, radians(frame.alpha)];
  return { ...frame, degrees: frame.alpha, objects: frame.z1, labels, chosen, z1, r, alpha, P: equations.P(r, alpha) };
}

// Where the sheets show L, in the plane z = 0, tiles.
function seen(z1, z2, alpha) {
  const { L, E, pitch } = state.movie;
  const fine = state.sheet === "ideal";
  return fine ? equations.ideal(L, E, z1, z2, alpha) : equations.prisms(L, E, z1, z2, alpha, pitch);
}

// How the sheets show an object: turned by nu, M times as large.
function appearance(z1, z2, alpha) {
  if (state.sheet === "detailed") return equations.turned(z1, z2, alpha, state.movie.pitch);
  return { nu: equations.nu(z2 / z1, alpha), M: equations.M(z2 / z1, alpha) };
}

// Whether the prediction is off by pixels: povgen's own limits (povgen/scene/limits.py).
function unsure(now) {
  if (state.sheet === "ideal") return equations.M(now.r, now.alpha) > data.limits.condition;
  const thin = equations.ideal(state.movie.L, state.movie.E, now.z1, now.z2, now.alpha);
  const moved = abs(minus(seen(now.z1, now.z2, now.alpha), thin));
  return !((moved / data.view_height) * 960 <= data.limits.correction); // NaN at the pole
}

// ---- Shapes: places in the drawing are [x, y], y down; angles as the eye sees them ----

function svg(tag, attributes, text = "") {
  const node = document.createElementNS("http://www.w3.org/2000/svg", tag);
  for (const [name, value] of Object.entries(attributes)) node.setAttribute(name, value);
  node.textContent = text;
  return node;
}
const dot = (kind, [cx, cy], r, id = "") => svg("circle", { class: kind, cx, cy, r, ...(id && { id }) });
const line = (kind, [x1, y1], [x2, y2]) => svg("line", { class: kind, x1, y1, x2, y2 });
const words = (kind, [x, y], text) => svg("text", { class: kind, x, y }, text);
const step = (from, angle, length) => plus(from, scaled(length, conj(turn(angle))));

// How far a place is from the line between two others.
function apart(place, a, b) {
  const [along, to] = [minus(b, a), minus(place, a)];
  const part = (along[0] * to[0] + along[1] * to[1]) / (abs(along) ** 2 || 1);
  return abs(minus(to, scaled(Math.min(1, Math.max(0, part)), along)));
}

// A curve, but for what lies far outside of every drawing; null parts it.
function curve(kind, points) {
  let d = "";
  let joined = false;
  for (const point of points) {
    const near = point && finite(point) && abs(point) < 4000;
    if (near) d += `${joined ? "L" : "M"}${point.map((x) => x.toFixed(1)).join(" ")}`;
    joined = near;
  }
  return svg("path", { class: kind, d });
}

// Points of a curve from one parameter to another; parted, and the denser the nearer, where it may pass through infinity.
function branches(place, first, last, infinite) {
  const within = infinite.filter((at) => first < at && at < last).sort((a, b) => a - b);
  const ends = [first, ...within, last];
  return within.concat(last).flatMap((end, n) => {
    const start = ends[n];
    return [...SHARES.map((share) => place(start + (end - start) * share)), null];
  });
}

// From one angle on, through another.
function arc(kind, centre, radius, start, through) {
  const steps = Array.from({ length: 41 }, (_, n) => step(centre, start + (through * n) / 40, radius));
  return curve(kind, steps);
}

function arrowhead(kind, tip, angle, length) {
  const corners = [tip, step(tip, angle + 2.7, length), step(tip, angle - 2.7, length)];
  return svg("polygon", { class: kind, points: corners.map((corner) => corner.join(",")).join(" ") });
}

// A line with a head at its end, unless it is too short for one; it stops short of the dot there.
function vector(kind, from, to, rem) {
  const [x, y] = minus(to, from);
  const length = Math.hypot(x, y) - 0.4 * rem;
  if (length < 0.8 * rem) return [line(kind, from, to)];
  const angle = Math.atan2(-y, x);
  return [
    line(kind, from, step(from, angle, length - 0.5 * rem)),
    arrowhead(`head ${kind}`, step(from, angle, length), angle, 0.75 * rem),
  ];
}

// For a place outside a picture: where at its edge an arrow points there, and at what angle. Otherwise null.
function edge(place, width, height, margin) {
  const excess = Math.max(Math.abs(place[0]) / (width / 2 - margin), Math.abs(place[1]) / (height / 2 - margin));
  return excess > 1 ? { tip: scaled(1 / excess, place), angle: Math.atan2(-place[1], place[0]) } : null;
}

// Shares of the way from one end of a branch to the other.
const SHARES = Array.from({ length: 301 }, (_, n) => n / 300);
for (let near = 1e-8; near < 0.5; near *= 1.04) SHARES.push(near, 1 - near);
SHARES.sort((a, b) => a - b);

// Steps along curves of constant alpha, by r, and of constant r, by alpha; small ones where the pole may be near.
const RATIOS = Array.from({ length: 361 }, (_, n) => Math.exp(8 * (n / 180 - 1) ** 3));
const TURNS = Array.from({ length: 361 }, (_, n) => {
  const part = n / 180 - 1;
  return Math.PI * part * (2 - Math.abs(part));
});

// ---- The diagram: figure 5(b, c), xi to the right, psi up ----

const diagram = $("diagram");

function drawDiagram(now) {
  const { lean } = state.movie;
  const { width, height } = diagram.getBoundingClientRect();
  const rem = parseFloat(getComputedStyle(document.documentElement).fontSize);
  const unit = Math.min(width / 2.4, height / 1.44);
  const at = ([xi, psi]) => [unit * (xi - 0.5), unit * (-0.14 * lean - psi)];
  const [L, E, P] = [at([0, 0]), at([1, 0]), at(scaled(Math.min(1, 40 / abs(now.P)), now.P))];
  const beside = (place) => Math.min(apart(place, P, L), apart(place, P, E)) > 1.5 * rem;
  const clear = ([place]) => !finite(P) || (beside(place) && abs(minus(place, P)) > 3.5 * rem);
  const [circles, names] = family(at, lean < 0 ? -1 : 1, width, height, rem);
  const others = now.objects.map((z1) => equations.P(now.z2 / z1, now.alpha)).filter(finite);
  const parts = [
    ...circles,
    curve("of-alpha", RATIOS.map((r) => at(equations.P(r, now.alpha)))),
    curve("of-r", TURNS.map((alpha) => at(equations.P(now.r, alpha)))),
    ...names.filter(clear).map(([place, name]) => words("scale", place, name)),
  ];
  if (others.length > 1) parts.push(...others.map((P) => dot("other", at(P), 0.26 * rem)));
  if (finite(now.P)) {
    parts.push(...triangle(now, at, rem, width, height));
  } else {
    parts.push(words("far", [0, 0.33 * height], "P is infinitely far:"));
    parts.push(words("far", [0, 0.33 * height + 1.4 * rem], "no light from L reaches E"));
  }
  parts.push(dot("dot", L, 0.3 * rem, "L"), words("point", plus(L, [-0.8 * rem, -0.8 * rem]), "L"));
  parts.push(dot("dot", E, 0.3 * rem, "E"), words("point", plus(E, [0.8 * rem, -0.8 * rem]), "E"));
  diagram.setAttribute("viewBox", `${-width / 2} ${-height / 2} ${width} ${height}`);
  diagram.replaceChildren(...parts);

  const corners = `L = 0, E = 1 and P = ${finite(now.P) ? point(now.P) : "∞, infinitely far"}`;
  const nu = angle(equations.nu(now.r, now.alpha));
  const name = `Triangle of ${corners}; α = ${fixed(now.degrees, 1)}° at P, ν = ${nu} at E, r = ${size(now.r)}.`;
  diagram.setAttribute("aria-label", name);
}

// The axes and circles of constant alpha, through L and E, and of constant r, round L or E; and their names.
function family(at, sign, width, height, rem) {
  const [L, E] = [at([0, 0]), at([1, 0])];
  const unit = E[0] - L[0];
  const parts = [line("axis", [-width, L[1]], [width, L[1]]), line("axis", [L[0], -height], [L[0], height])];
  const names = [
    [[width / 2 - 0.8 * rem, L[1] + 0.9 * rem], "ξ"],
    [[L[0] - 0.8 * rem, 0.9 * rem - height / 2], "ψ"],
    [at([0.5, 0.46 * sign]), "r = 1"],
  ];
  parts.push(line("family", [0, -height], [0, height]));
  for (const [r, name] of [[1 / 4, "¼"], [1 / 2, "½"], [2, "r = 2"], [4, "4"]]) {
    const [centre, radius] = [-1 / (r * r - 1), r / Math.abs(r * r - 1)];
    parts.push(dot("family", at([centre, 0]), unit * radius));
    names.push([at([centre, radius < 0.5 ? sign * radius : -sign * radius]), name]);
  }
  for (const degrees of [30, 60, 90, 120, 150]) {
    const alpha = radians(degrees);
    parts.push(dot("family", at([0.5, 0.5 / Math.tan(alpha)]), (0.5 * unit) / Math.sin(alpha)));
    const name = `${degrees === 30 ? "α = " : ""}${sign < 0 ? "−" : ""}${degrees}°`;
    if (degrees <= 90) names.push([at([0.5, -0.5 * sign * Math.tan(alpha / 2)]), name]);
  }
  return [parts, names];
}

// L, P and E, the vectors P from L and 1 - P to E, alpha at P, nu at E.
function triangle(now, at, rem, width, height) {
  const [L, E, far] = [at([0, 0]), at([1, 0]), abs(now.P) > 40];
  const toE = arg(equations.oneMinusP(now.r, now.alpha));
  const out = edge(at(now.P), width, height, 1.2 * rem);
  // what is far off is drawn towards it alone
  const P = far ? null : at(now.P);
  const fromL = P ?? step(L, arg(now.P), 1e4);
  const fromE = P ?? step(E, toE + Math.PI, 1e4);
  const parts = [line("base", L, E), ...vector("ray", L, fromL, rem), ...vector("of-nu", fromE, E, rem)];

  const nu = equations.nu(now.r, now.alpha);
  const side = nu < 0 ? -1 : 1; // of E - P, as E sees it, on which L is not
  const length = abs(minus(fromE, E));
  const radius = Math.min(3.2 * rem, 0.5 * length);
  if (Math.abs(nu) > 0.03 && radius > 0.6 * rem) {
    parts.push(arc("of-nu", E, radius, Math.PI, nu));
    const beside = Math.abs(nu) * radius < 1.6 * rem; // no room within
    const where = beside ? Math.PI - (side * 0.7 * rem) / radius : Math.PI + nu / 2;
    parts.push(words("of-nu", step(E, where, radius + (beside ? 0 : 0.8 * rem)), "ν"));
  }
  if (length > 7.5 * rem) {
    const along = step(E, toE + Math.PI, Math.min(0.42 * length, 6 * rem));
    const room = 0.9 + 0.9 * Math.abs(Math.sin(toE)); // the text is wider than high
    parts.push(words("of-nu", step(along, toE + Math.PI + (side * Math.PI) / 2, room * rem), "1 − P"));
  }
  if (out) {
    parts.push(arrowhead("arrow", out.tip, out.angle, 1.1 * rem));
    parts.push(words("point", step(out.tip, out.angle + Math.PI, 1.9 * rem), "P"));
    return parts;
  }
  const bend = Math.min(1.7 * rem, 0.6 * length, 0.6 * abs(minus(P, L)));
  if (Math.abs(now.alpha) > 0.03 && bend > 0.5 * rem) {
    parts.push(line("straight", P, step(P, arg(now.P), bend + 1.2 * rem)));
    parts.push(arc("of-alpha", P, bend, arg(now.P), now.alpha));
    parts.push(words("of-alpha", step(P, arg(now.P) + now.alpha / 2, bend + 0.8 * rem), "α"));
  }
  // P's name on the side that neither L nor E is on
  const away = plus(turn(arg(now.P)), turn(toE + Math.PI));
  const aside = abs(away) > 0.05 ? arg(away) : -Math.PI / 2;
  parts.push(dot("dot", P, 0.34 * rem, "P"), words("point", step(P, aside, 1.1 * rem), "P"));
  return parts;
}

// ---- The prediction, over the picture: hundredths of a tile from the window's centre ----

const overlay = $("overlay");

function drawPrediction(now) {
  const { sweep, L, E, ratio } = state.movie;
  const pitch = state.sheet === "ideal" ? 0 : state.movie.pitch;
  const [width, height] = [100 * data.view_height * ratio, 100 * data.view_height];
  const at = ([x, y]) => [100 * x, -100 * y];
  overlay.setAttribute("viewBox", `${-width / 2} ${-height / 2} ${width} ${height}`);
  overlay.replaceChildren();
  if (!state.prediction) return;

  const shapes = [];
  if (sweep !== "alpha" || now.objects.length > 1) {
    const still = sweep === "z2" ? now.z1 : now.z2;
    const place = (log) => {
      const moved = still * Math.exp(log);
      return at(sweep === "z2" ? seen(still, moved, now.alpha) : seen(moved, still, now.alpha));
    };
    const infinite = equations.infiniteZ1(still, now.alpha, pitch).map((moved) => Math.log(moved / still));
    shapes.push(curve("of-alpha", branches(place, -8, 8, infinite)));
  }
  if (sweep === "alpha") {
    const infinite = equations.infiniteAlpha(now.z1, now.z2, pitch);
    shapes.push(curve("of-r", branches((alpha) => at(seen(now.z1, now.z2, alpha)), -Math.PI, Math.PI, infinite)));
  }

  const tops = [dot("dot", at(L), 3.5), words("", plus(at(L), [0, -19]), "L")];
  tops.push(dot("dot", at(E), 3.5), words("", plus(at(E), [0, -19]), "E"));
  now.objects.forEach((z1, k) => {
    const place = at(seen(z1, now.z2, now.alpha));
    if (!finite(place)) return;
    const chosen = k === now.chosen;
    const out = edge(place, width, height, 8);
    const kind = `mark${chosen ? " chosen" : ""}${unsure({ ...now, z1, r: now.z2 / z1 }) ? " unsure" : ""}`;
    if (!out) {
      const reach = now.radius ? Math.max(3, 100 * now.radius[k] * appearance(z1, now.z2, now.alpha).M) : 9;
      shapes.push(dot(kind, place, reach, chosen ? "predicted" : ""));
      const below = place[1] + reach + 26 < height / 2;
      if (chosen) tops.push(words("", plus(place, [0, below ? reach + 15 : -reach - 15]), "P"));
    } else if (chosen && finite(now.P)) {
      tops.push(arrowhead("arrow", out.tip, out.angle, 16), words("", step(out.tip, out.angle + Math.PI, 30), "P"));
    }
  });
  const halos = shapes.map((shape) => {
    const halo = shape.cloneNode();
    halo.removeAttribute("id");
    halo.setAttribute("class", "halo");
    return halo;
  });
  overlay.append(...halos, ...shapes, ...tops);
}

// ---- In words ----

function tell(now) {
  if (!state.prediction) return "";
  const { thing, marked, sweep } = state.movie;
  if (!finite(now.P)) return "P is infinitely far: no light from L reaches E.";
  const [nu, M] = toldAppearance(now);
  const prisms = state.sheet === "detailed" ? ` Through these prisms: ν = ${nu}, M = ${M}.` : "";
  if (unsure(now)) return `Near the pole or through large prisms, as here, the prediction is off by pixels.${prisms}`;
  const what = now.objects.length > 1 ? `Rings: the ${thing}s as predicted.` : `P: the ${marked} as predicted.`;
  return `${what} Line: P's path as ${SYMBOL[sweep]} changes. L, E: ${thing} and eye, projected.${prisms}`;
}

function toldAppearance(now) {
  const { nu, M } = appearance(now.z1, now.z2, now.alpha);
  return [angle(nu), size(M)];
}

function describe(now) {
  const { thing, prisms } = state.movie;
  const model = state.sheet === "ideal" ? "the infinitely fine sheet" : `two sheets of ${prisms} Dove prisms`;
  const where = `α = ${fixed(now.degrees, 1)}°, z₁ = ${size(now.z1)} and z₂ = ${size(now.z2)} tiles`;
  const [nu, M] = toldAppearance(now);
  const how = finite(now.P)
    ? `It appears turned by ν = ${nu} and M = ${M} times as large as in the plane of the sheets.`
    : "It is seen nowhere: P is infinitely far.";
  return `A ${thing} seen through ${model}, with ${where}. ${how}`;
}

// ---- From one frame to another ----

function imageAt(sheet, n) {
  const { frames, images } = state.movie;
  images[sheet] ??= [];
  if (!images[sheet][n]) {
    const image = new Image();
    image.id = "shown";
    image.decoding = "sync"; // painted together with its diagram
    image.src = frames[sheet][n].file;
    images[sheet][n] = image;
  }
  return images[sheet][n];
}
const wanted = () => imageAt(state.sheet, slider.valueAsNumber);

// Show what the slider stands at: picture, diagram and numbers all at once, as soon as the picture is there.
function update() {
  const image = wanted();
  if (image.complete) show(image);
  else image.onload = image.onerror = () => image === wanted() && show(image);
}

function show(image) {
  const now = moment();
  const { sweep } = state.movie;
  const value = sweep === "alpha" ? now.degrees : now[sweep];
  const [nu, M] = [angle(equations.nu(now.r, now.alpha)), size(equations.M(now.r, now.alpha))];
  if (image !== $("shown")) $("shown").replaceWith(image);
  image.alt = describe(now);
  drawPrediction(now);
  drawDiagram(now);
  listSpheres(now);
  $("told").textContent = tell(now);
  $("value").textContent = `${SYMBOL[sweep]} = ${quantity(sweep, value)}`;
  $("value-alpha").textContent = quantity("alpha", now.degrees);
  $("value-z1").textContent = size(now.z1);
  $("value-z2").textContent = size(now.z2);
  $("value-r").textContent = size(now.r);
  $("value-P").textContent = point(now.P);
  $("value-nu").textContent = nu;
  $("value-M").textContent = M;
  slider.setAttribute("aria-valuetext", `${quantity(sweep, value)}: P = ${point(now.P)}, ν = ${nu}, M = ${M}`);
}

function listSpheres(now) {
  const list = $("sphere");
  $("choice").hidden = now.labels.length < 2;
  if (list.dataset.labels !== now.labels.join()) {
    list.dataset.labels = now.labels.join();
    list.replaceChildren(...now.labels.map((name) => new Option(name)));
  }
  list.selectedIndex = now.chosen;
}

function seek(n) {
  slider.value = n;
  update();
}

function openTab(index) {
  play(false);
  if (state.movie) state.movie.at = slider.valueAsNumber;
  state.movie = data.movies[index];
  const { movie } = state;
  movie.images ??= {};
  // P lies below the axis where sin(alpha) is positive: more room there
  movie.lean = Math.sign(Math.round(movie.frames.ideal.reduce((sum, { alpha }) => sum + Math.sin(radians(alpha)), 0)));
  [...$("tabs").children].forEach((tab, n) => {
    tab.setAttribute("aria-selected", n === index);
    tab.tabIndex = n === index ? 0 : -1;
  });
  $("panel").setAttribute("aria-labelledby", `tab-${index + 1}`);
  $("title").textContent = movie.title;
  $("detailed").textContent = `2 × ${movie.prisms} prisms`;
  $("start").textContent = brief(movie.sweep, movie.start);
  $("stop").textContent = brief(movie.sweep, movie.stop);
  document.documentElement.style.setProperty("--ratio", movie.ratio);
  slider.max = movie.frames.detailed.length - 1;
  slider.setAttribute("aria-label", NAME[movie.sweep]);
  seek(movie.at ?? 0);
  for (const sheet of [state.sheet, "detailed", "ideal"]) movie.frames[sheet].forEach((_, n) => imageAt(sheet, n));
}

function through(sheet) {
  state.sheet = sheet;
  for (const name of ["detailed", "ideal"]) $(name).setAttribute("aria-pressed", name === sheet);
  update();
}

function predict(on) {
  state.prediction = on;
  $("prediction").setAttribute("aria-checked", on);
  update();
}

// ---- Play ----

function play(on) {
  if (on && !state.playing) {
    if (slider.value === slider.max) seek(0);
    requestAnimationFrame(tick);
  }
  state.playing = on;
  state.since = performance.now();
  $("play-icon").setAttribute("d", on ? "M0.5 0H3.5V10H0.5ZM6.5 0H9.5V10H6.5Z" : "M1 0L10 5L1 10Z");
  $("play-name").textContent = on ? "Pause" : "Play";
}

function tick(time) {
  if (!state.playing) return;
  const pause = 1000 / state.movie.rate;
  if (time - state.since >= pause && $("shown") === wanted()) {
    if (slider.value === slider.max) return play(false);
    state.since = Math.max(state.since + pause, time - pause);
    seek(slider.valueAsNumber + 1);
  }
  requestAnimationFrame(tick);
}

// ---- Controls ----

function toggleSheet() {
  through(state.sheet === "ideal" ? "detailed" : "ideal");
}

function stepBy(n) {
  play(false);
  seek(slider.valueAsNumber + n);
}

const KEYS = {
  " ": () => play(!state.playing),
  ArrowLeft: () => stepBy(-1),
  ArrowRight: () => stepBy(1),
  Home: () => stepBy(-slider.max),
  End: () => stepBy(Number(slider.max)),
  p: toggleSheet,
  o: () => predict(!state.prediction),
};
for (let n = 1; n <= Math.min(9, data.movies.length); n++) KEYS[n] = () => openTab(n - 1);

// On a tab these go from tab to tab.
const KEYS_ON_TAB = {
  ArrowLeft: () => openNext(-1),
  ArrowRight: () => openNext(1),
  Home: () => openNext(-data.movies.indexOf(state.movie)),
  End: () => openNext(-1 - data.movies.indexOf(state.movie)),
};
function openNext(n) {
  const count = data.movies.length;
  const next = (data.movies.indexOf(state.movie) + n + count) % count;
  openTab(next);
  $(`tab-${next + 1}`).focus();
}

document.addEventListener("keydown", (event) => {
  const { target, key } = event;
  const tab = target.getAttribute("role") === "tab";
  if (event.ctrlKey || event.altKey || event.metaKey || target === $("sphere")) return;
  if (key === " " && target.tagName === "BUTTON" && !tab) return; // presses the button
  const action = (tab && KEYS_ON_TAB[key]) || KEYS[key.length === 1 ? key.toLowerCase() : key];
  if (!action) return;
  event.preventDefault();
  action();
});

// After a click the keys are the slider's: space plays, arrows step.
document.addEventListener("click", (event) => {
  if (event.detail && event.target.closest("button")) slider.focus({ preventScroll: true });
});

[...$("tabs").children].forEach((tab, n) => tab.addEventListener("click", () => openTab(n)));
slider.addEventListener("input", () => {
  play(false);
  update();
});
$("play").addEventListener("click", () => play(!state.playing));
$("detailed").addEventListener("click", () => through("detailed"));
$("ideal").addEventListener("click", () => through("ideal"));
$("prediction").addEventListener("click", () => predict(!state.prediction));
$("sphere").addEventListener("change", (event) => {
  state.movie.chosen = event.target.value;
  update();
});
new ResizeObserver(() => drawDiagram(moment())).observe(diagram);

for (const movie of data.movies) movie.chosen = "z₁ = z₂";
openTab(0);
through("detailed");
predict(true);
