// What is shown: the movie, the model of the sheets, and the numbers of the frame.

const $ = (id) => document.getElementById(id);
const slider = $("slider");
const state = { movie: null, sheet: "detailed", prediction: true, playing: false };

// A sphere's name in the list of spheres.
function label(z1, z2) {
  const n = Math.round(Math.log2(z1 / z2));
  return state.movie.powers ? `z₁ = ${n ? `2${raised(n)} ` : ""}z₂` : `z₁ = ${size(z1)}`;
}

// The numbers of the frame that the slider selects, for the chosen object.
function moment() {
  const frame = state.movie.frames[state.sheet][slider.valueAsNumber];
  const labels = frame.z1.map((z1) => label(z1, frame.z2));
  const chosen = Math.max(0, labels.indexOf(state.movie.chosen));
  const z1 = frame.z1[chosen];
  const [r, alpha] = [frame.z2 / z1, radians(frame.alpha)];
  return { ...frame, degrees: frame.alpha, objects: frame.z1, labels, chosen, z1, r, alpha, P: equations.P(r, alpha) };
}

// The point of the plane z = 0 at which the sheets show L, in tiles.
function apparentPosition(z1, z2, alpha) {
  const { L, E, prism } = state.movie;
  const fine = state.sheet === "ideal";
  return fine ? equations.ideal(L, E, z1, z2, alpha) : equations.prisms(L, E, z1, z2, alpha, prism);
}

// The angle nu by which the sheets show an object rotated, and its magnification M.
function appearance(z1, z2, alpha) {
  if (state.sheet === "detailed") return equations.turned(z1, z2, alpha, state.movie.prism);
  return { nu: equations.nu(z2 / z1, alpha), M: equations.M(z2 / z1, alpha) };
}

// Whether the prediction is wrong by pixels. The limits are in povgen/scene/limits.py.
function unsure(now) {
  if (state.sheet === "ideal") return equations.M(now.r, now.alpha) > data.limits.condition;
  const thin = equations.ideal(state.movie.L, state.movie.E, now.z1, now.z2, now.alpha);
  const moved = abs(minus(apparentPosition(now.z1, now.z2, now.alpha), thin));
  return !((moved / state.movie.view) * 960 <= data.limits.correction); // NaN at the pole
}
