// What goes beyond the paper: a second window, and ideal sheets that do not rotate light about their normal.

// What is chosen beside the paper's window, and the values with which it begins.
const NEIGHBOURS = {
  none: { windows: 1, sheet: "ideal", ...pick(OPENING, "alpha", "z2") },
  series: { windows: 2, sheet: "ideal", alpha: 120, alpha2: 120, d: 2, z1: 2, z2: 8 },
  axis: { windows: 1, sheet: "axis", alpha: 20, axis: [0, 1, 0] },
  refraction: { windows: 1, sheet: "refraction", alpha: 40, ratio: 0.7 },
  lenslets: { windows: 1, sheet: "lenslets", alpha: 180, ratio: 2 },
  mirror: { windows: 1, sheet: "mirror", alpha: 90 },
};
const OTHER_SHEETS = ["axis", "refraction", "lenslets", "mirror"];

const neighbour = () => (OTHER_SHEETS.includes(state.sheet) ? state.sheet : inSeries() ? "series" : "none");

// Whether there is a second window. One sheet of prisms, and the other sheets, are alone.
const inSeries = () => state.windows === 2 && ["none", "detailed", "ideal"].includes(state.sheet);

// The distance from the second window to the first, and its angle in radians: [[distance, angle]]; [] without one.
const behindFirst = ({ window, sheet }) => window.map(({ z, alpha }) => [z, sheet === "none" ? 0 : radians(alpha)]);

// ---- The maps of directions: povgen/optics/ideal.py ----

// The direction [x, y, z] of an eye's ray behind one of the other sheets, or null if no light passes.
function bent(d, { sheet, alpha: degrees, ratio, axis }) {
  const alpha = radians(degrees);
  const transverse = [d[0], d[1]], length = Math.hypot(...d);
  const back = times(transverse, turn(-alpha));
  let found;
  if (sheet === "mirror") found = [...times(conj(transverse), turn(alpha)), d[2]];
  else if (sheet === "lenslets") found = [...scaled(1 / ratio, back), d[2]];
  else if (sheet === "refraction") {
    const sine = scaled(1 / (ratio * length), back);
    found = [...sine, Math.sqrt(1 - abs(sine) ** 2)];
  } else {
    const [x, y, z] = axis.map((part) => part / Math.hypot(...axis));
    const [c, s] = turn(-alpha);
    const along = (x * d[0] + y * d[1] + z * d[2]) * (1 - c);
    found = [
      c * d[0] + s * (y * d[2] - z * d[1]) + x * along,
      c * d[1] + s * (z * d[0] - x * d[2]) + y * along,
      c * d[2] + s * (x * d[1] - y * d[0]) + z * along,
    ];
  }
  return found[2] > 0 ? found : null;
}

// Where light from L to E crosses one of the other sheets: Newton's method, as in povgen/optics/ideal.py. [NaN, NaN] if no
// path was found.
function crossing(L, E, z1, z2, scene) {
  const missed = (slope) => {
    const ray = bent([...slope, 1], scene);
    if (!ray) return [NaN, NaN];
    return minus(plus(E, plus(scaled(z2, slope), scaled(z1 / ray[2], [ray[0], ray[1]]))), L);
  };
  const size = 1 + abs(minus(L, E)) + z1 + z2;
  let slope = [0, 0], off = missed(slope);
  for (let k = 0; k < 60 && abs(off) > 1e-13 * size; k++) {
    const [right, up] = [[1e-7, 0], [0, 1e-7]].map((h) => scaled(5e6, minus(missed(plus(slope, h)), missed(minus(slope, h)))));
    const determinant = right[0] * up[1] - right[1] * up[0];
    let step = scaled(-1 / determinant, [off[0] * up[1] - off[1] * up[0], right[0] * off[1] - right[1] * off[0]]);
    let next = missed(plus(slope, step));
    for (let n = 0; n < 30 && !(abs(next) <= abs(off)); n++) {
      step = scaled(0.5, step);
      next = missed(plus(slope, step));
    }
    if (!finite(next)) break;
    slope = plus(slope, step);
    off = next;
  }
  return abs(off) < 1e-9 * size ? plus(E, scaled(z2, slope)) : [NaN, NaN];
}

// ---- Sentences ----

function seenThrough(now) {
  const { sheet, M, nu, scene, degrees } = now;
  const alpha = `${fixed(degrees, 1)}°`;
  if (sheet === "none") return `Nothing is in the windows: the ${thing()} is seen as it is.`;
  if (sheet === "axis") return `The sheet rotates light by ${alpha} about the axis (${scene.axis.map(brief).join(", ")}). No prisms are known that do this.`;
  if (sheet === "mirror") return `The sheet mirrors the light’s slope about a line at α/2 = ${fixed(degrees / 2, 1)}°, as one sheet of prisms does.`;
  if (sheet === "refraction") {
    return `The sheet refracts light, with the complex ratio of indices η: it multiplies the sine of the angle by ${brief(scene.ratio)}, and turns`
      + ` light by ${alpha}.${scene.ratio === 1 ? "" : " No prisms are known that do this."}`;
  }
  if (sheet === "lenslets") {
    return `The sheet multiplies the light’s slope by ${brief(scene.ratio)}, and turns it by ${alpha}. Pairs of lenslets with f₁/f₂ =`
      + ` ${brief(scene.ratio)} do it for α = 180°.`;
  }
  if (sheet === "detailed" && unsure(now)) return UNSURE;
  const large = Number.isFinite(M) ? `${timesText(M)} times as large as if it stood in the first window` : "infinitely large";
  return `Through both windows, the ${thing()} appears ${turnedBy(nu)}, and ${large}. ${imageSentence(now)}`;
}

// W = Z - z2 is the image's distance behind the first window, if it is real: docs/beyond.md.
function imageSentence({ Z, z2 }) {
  const W = [Z[0] - z2, Z[1]];
  if (Math.abs(W[1]) > 0.02 * Math.max(1, abs(W))) {
    return `Z − z₂ = ${point(W)} is not real: they form no image.`;
  }
  return `Z is real: they form an image, ${brief(Math.abs(W[0]))} tiles ${W[0] < 0 ? "in front of" : "behind"} the first window.`;
}

// ---- The diagram of the complex depth: Z = z2 + d e^(-i alpha) + z1 e^(-i(alpha + alpha2)), step by step ----

function depthDiagram({ z1, z2, alpha, behind: [[d, alpha2]] }, { width, height }, rem) {
  const steps = [
    ["z₂", [z2, 0], "of-r q-z2"], ["d", scaled(d, turn(-alpha)), "of-alpha q-d q-alpha"],
    ["z₁", scaled(z1, turn(-alpha - alpha2)), "of-nu q-z1 q-alpha2"],
  ];
  const ends = steps.reduce((points, [, step]) => [...points, plus(points.at(-1), step)], [[0, 0]]);
  const [low, high] = [Math.min, Math.max].map((most) => [0, 1].map((k) => most(...ends.map((end) => end[k]))));
  const left = 9 * rem;  // the switch is there
  const unit = Math.min((width - left - 5 * rem) / Math.max(high[0] - low[0], 0.1), (height - 5 * rem) / Math.max(high[1] - low[1], 0.1));
  const middle = scaled(0.5, plus(low, high));
  const at = (z) => [left / 2 + unit * (z[0] - middle[0]), unit * (middle[1] - z[1])];
  const y = at([0, 0])[1];
  const parts = [line("axis", [left - width / 2, y], [width, y]), words("scale", [width / 2 - 1.6 * rem, y + 0.9 * rem], "real")];
  steps.forEach(([name, step_, kind], k) => {
    const [from, to] = [at(ends[k]), at(ends[k + 1])];
    parts.push(...vector(`ray q ${kind}`, from, to, rem));
    const aside = step(scaled(0.5, plus(from, to)), heading(from, to) + Math.PI / 2, rem);
    parts.push(words(`point q ${kind}`, aside, name));
  });
  return [...parts, ...corner("Z", at(ends[3]), [at(ends[2])], rem)];
}
