// The choices beyond the paper: a second window, and ideal sheets that do not rotate light about their normal.

// What is chosen beside the paper's window, and the values with which it begins.
const BEYOND = {
  none: { windows: 1, sheet: "ideal" },
  series: { windows: 2, sheet: "ideal", alpha: 120, alpha2: 120, d: 2, z1: 2, z2: 8 },
  axis: { windows: 1, sheet: "axis", alpha: 20, axis: [0, 1, 0], ...pick(OPENING, "z2") },
  refraction: { windows: 1, sheet: "refraction", alpha: 40, ratio: 0.7, ...pick(OPENING, "z2") },
  lenslets: { windows: 1, sheet: "lenslets", alpha: 180, ratio: 2, ...pick(OPENING, "z2") },
  mirror: { windows: 1, sheet: "mirror", alpha: 90, ...pick(OPENING, "z2") },
};
// The names of inputs that differ from those of the paper's window.
const LABELS = {
  none: { alpha: "the light is turned by", z1: "object behind the window", z2: "eye in front of it", ratio: "" },
  series: { alpha: "the first window turns the light by", z1: "object behind the second window", z2: "eye in front of the first" },
  refraction: { ratio: "ratio of indices n₁/n₂: object’s side over eye’s" },
  lenslets: { ratio: "ratio of focal lengths f₁/f₂: object’s side over eye’s" },
  mirror: { alpha: "twice the angle of the mirror line" },
};
const OTHER_SHEETS = ["axis", "refraction", "lenslets", "mirror"];

let own = {};  // the user's own values of the choices that have been left

// Choose the paper's window, or what is beyond it. Each choice keeps its own values.
function chooseBeyond(name) {
  own[chosenBeyond()] = pick(state, "windows", "sheet", "alpha", "alpha2", "d", "ratio", "axis", "z1", "z2");
  replace({ ...BEYOND[name], ...own[name] }, ["windows", "sheet"]);
}

const chosenBeyond = () => (OTHER_SHEETS.includes(state.sheet) ? state.sheet : inSeries() ? "series" : "none");

// Whether there is a second window. One sheet of prisms, and the other sheets, are alone.
const inSeries = () => state.windows === 2 && ["none", "detailed", "ideal"].includes(state.sheet);

// The distance from the second window to the first, and its angle in radians: [[distance, angle]]; [] without one.
const behindFirst = ({ window, sheet }) => window.map(({ z, alpha }) => [z, sheet === "none" ? 0 : radians(alpha)]);

// ---- Sentences ----

const REAL = 0.02;  // tiles: an imaginary part of Z below this blurs an image by less than the height of one of 100 prisms

// "2 tiles in front of the first window". An image behind the eye cannot be seen standing in the air.
function imagePlace(W, z2, name) {
  const distance = `${brief(Math.abs(W))} ${Math.abs(W) === 1 ? "tile" : "tiles"}`;
  return `${distance} ${W < 0 ? "in front of" : "behind"} ${name}${-W > z2 ? ", behind your eye" : ""}`;
}

function seenThrough(now) {
  const { sheet, M, degrees } = now;
  if (sheet === "none" && contents(now).has("thing")) return `Nothing is in the windows: the ${thing()} is seen as it is, ${timesText(M)} times as large as if it stood in the first window.`;
  if (now.Z) return seenInSeries(now);
  const does = Math.abs(Math.sin(radians(degrees) / 2)) < 1e-9 && sheet === "axis" ? "At this angle the sheet does nothing." : WORK[sheet](now);
  if (now.nearPole) return `${does} ${poleSentence(now)}`;
  if (!contents(now).has("thing")) return `${does} ${absent(now)}`;
  if (!(M > 0) || !Number.isFinite(M)) return does;
  const which = state.scene === "spheres" ? ` at z₁ = ${brief(now.z1)}` : "";
  if (sheet === "lenslets") return `${does} The ${thing()}${which} appears ${timesText(M)} times as large as if it stood in the window.`;
  return `${does} The ${thing()}${which} has ${timesText(M * M)} times the area that it would have in the window.`;  // it can be distorted
}

// What each of the other sheets does.
const WORK = {
  axis({ scene: { axis }, degrees }) {
    const what = `The sheet rotates light by ${fixed(degrees, 1)}° about the axis (${axis.map(brief).join(", ")})`;
    return axis[0] || axis[1] ? `${what}. No prisms are known that do this.` : `${what}: that is the paper’s window.`;
  },
  refraction({ scene: { ratio }, degrees }) {
    if (degrees % 360 === 0) return `Snell’s law: the sheet multiplies the sine of the angle by ${brief(ratio)}.`;
    const what = `The sheet refracts light, with a complex ratio of indices: it multiplies the sine of the angle by ${brief(ratio)}, and turns light by`;
    return `${what} ${fixed(degrees, 1)}°. ${ratio === 1 ? "That is the paper’s window." : "No prisms are known that do this."}`;
  },
  lenslets({ scene: { ratio }, degrees, z1, z2 }) {
    const turned = Math.abs(degrees) % 360 === 180;
    if (!turned) return `The sheet multiplies the light’s slope by ${brief(ratio)}, and turns it by ${fixed(degrees, 1)}°. Real lenslets turn it by 180°.`;
    return `Pairs of lenslets multiply the light’s slope by −f₁/f₂ = −${brief(ratio)}. They form an image ${imagePlace(-z1 / ratio, z2, "the window")}.`;
  },
  mirror: ({ degrees }) => `The sheet mirrors the light’s slope about a line at ${fixed(degrees / 2, 1)}°, as one sheet of prisms does.`,
};

function seenInSeries(now) {
  const { sheet, M, nu, z1 } = now;
  if (now.beside) return `Light from L to the eye passes beside the second window: there the ${thing()} is not where the windows would show it.`;
  if (now.nearPole) return poleSentence(now);
  if (!contents(now).has("thing")) return absent(now);
  const which = state.scene === "spheres" ? `sphere at z₁ = ${brief(z1)} appears, about E,` : `${thing()} appears`;
  const large = `${timesText(M)} times as large as if it stood in the first window`;
  const unsafe = sheet === "detailed" && unsure(now) ? ` ${doubt(now)}` : "";
  return `Through both windows, the ${which} ${turnedBy(nu)}, and ${large}. ${imageSentence(now)}${unsafe}`;
}

// Z - z2 is the image's distance behind the first window, if it is real: docs/beyond.md.
function imageSentence({ scene, Z, z1, z2, total }) {
  if (Math.abs(Z[1]) <= REAL) {
    const W = Z[0] - z2;
    if (Math.abs(W) < REAL) return "Z is real: the image is in the first window.";
    return `Z is real: the image is ${imagePlace(W, z2, "the first window")}.`;
  }
  const imaged = z1 + Z[1] / Math.sin(total);  // where Z is real
  const least = geometry.depth(scene) / 2 + (scene.name === "chess" ? data.pedestals[state.piece] : 0);
  const instead = imaged > least && imaged < RANGES.z1[1] ? ` What stands at z₁ = ${brief(imaged)} has one.` : "";
  return `Z is not real: the ${thing()} has no image.${instead}`;
}
