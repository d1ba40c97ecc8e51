// What the shaders are given for a scene, as in povgen/scene/shader.py. Lengths are in tiles, angles in degrees.

import * as geometry from "./geometry.js";
import { camera, cross, floorY, horizon, isTurned, objects, openings } from "./presets.js";
import { CONSTANTS, constants, hasPrisms, kind } from "./sheets.js";

const BACKGROUNDS = { sky: 0, black: 1, white: 2, transparent: 3 };
// of a window that has no Dove prisms
const NO_PRISMS = { aperture: 1, prisms: 1, index: 1.5, base_angle: 45, gap: 0.01, aspect: 1 };
const NO_SHAPE = { ...geometry.prism(NO_PRISMS), edges: [] };

const shapeOf = (window) => (hasPrisms(window) ? geometry.shape(window) : NO_SHAPE);
// The greatest number of edges of a window's profile; 0: all are Dove prisms.
const edgeCount = (shapes) => Math.max(...shapes.map(({ edges }) => edges.length));

// What the shaders are compiled for.
export function defines(scene, { names, grid }) {
  const all = openings(scene), things = objects(scene, names), edges = edgeCount(all.map(shapeOf));
  const { cards, ...surroundings } = scene.pictures, drawn = things.map((thing) => thing.kind);
  /** @type {Record<string, any>} */
  const kinds = {
    WINDOWS: all.length,
    CONSTANTS,
    OBJECTS: things.length,
    VOLUMES: names.length,
    GRID: grid.join(", "),
    ...Object.fromEntries(drawn.map((kind) => [`ALL_${kind.toUpperCase()}`, `ivec2(${drawn.indexOf(kind)}, ${drawn.lastIndexOf(kind) + 1})`])),
    ...(edges && { PROFILE_EDGES: edges }),
    ...(cards && { CARDS: cards.places.length }),
    ...(all.some(({ round }) => round) && { ROUND_WINDOWS: 1 }),
    ...(all.some(isTurned) && { TURNED_WINDOWS: 1 }),
    ...(things.some(isTurned) && { TURNED_OBJECTS: 1 }),
    ...(all.some(hasPrisms) && { PRISMS: 1 }),
    ...(all.some((window) => kind(window) >= 0) && { LAWS: 1 }),
    ...(scene.pupil && { PUPIL: 1 }),
    ...(!scene.objects && { AXIAL: 1 }),
    ...Object.fromEntries(Object.keys(surroundings).map((part) => [`${part.toUpperCase()}_PICTURE`, 1])),
  };
  return Object.entries(kinds).map(([key, value]) => `#define ${key} ${value}\n`).join("");
}

// The distance of the eye from the picture's plane.
const distance = ({ eye, middle, right, up }) => cross(right, up).reduce((sum, each, k) => sum + each * (middle[k] - eye[k]), 0);

/** @type {(list: any[], length: number, rest?: any) => any[]} */
const padded = (list, length, rest = 0) => [...list, ...Array(length - list.length).fill(rest)];

// The shaders' uniforms, for a scene with these pieces: `names` of their distance fields, and `places`.
export function uniforms(scene, { names, places }) {
  const { eye, middle, right, up, height } = camera(scene), ground = floorY(scene), { cards, floor } = scene.pictures;
  const things = objects(scene, names);
  return {
    eye,
    viewMiddle: middle,
    viewRight: right,
    viewUp: up,
    viewHeight: height,
    pupil: scene.pupil / 2,
    outOfFocus: scene.pupil ? 1 - scene.inverse_focus * distance(camera(scene)) : 0,
    background: BACKGROUNDS[scene.background],
    frameRim: scene.rim,
    hasFloor: ground !== null,
    skyPicture: 2,
    floorPicture: 3,
    cardPictures: 4,
    mountains: 5,
    cardPlace: cards?.places ?? [],
    floorTiles: floor?.tiles ?? [1, 1],
    floorMean: floor?.mean ?? [0, 0, 0],
    floorY: ground ?? 0,
    horizon: horizon(scene),
    maxFaces: scene.faces,
    volumes: 1,
    volumePlace: places,
    objectPlace: things.map((thing) => thing.place),
    objectAxes: things.map((thing) => thing.axes),
    objectNumbers: things.map((thing) => thing.numbers),
    objectColour: things.map((thing) => thing.colour),
    ...windowUniforms(openings(scene)),
  };
}

// Those of windows and sheets. A window has two sheets of glass; a missing one has zeros.
function windowUniforms(all) {
  const shapes = all.map(shapeOf), most = edgeCount(shapes);
  const prisms = all.map((window, k) => (hasPrisms(window) && !shapes[k].edges.length ? window.values : NO_PRISMS));
  const dove = prisms.map(geometry.prism), sheets = all.map(geometry.sheets);
  const everyEdge = shapes.flatMap(({ edges }) => padded(edges, most, [0, 0, 0, 0, 0]));
  const turned = (angle) => [Math.cos(angle), Math.sin(angle)];
  return {
    kind: all.map(kind),
    constants: all.flatMap((window) => padded(hasPrisms(window) ? [] : constants(window), CONSTANTS)),
    windowPlace: all.map(({ place }) => place),
    windowAxes: all.map(({ axes }) => axes),
    windowHalf: all.map(({ half }) => half),
    windowRound: all.map(({ round }) => round),
    windowDepth: all.map(({ depth }) => depth),
    windowFramed: all.map(({ framed }) => framed),
    sheetCounts: sheets.map((pair) => pair.length),
    sheetTurns: sheets.flatMap((pair) => [0, 1].map((k) => turned(pair[k]?.angle ?? 0))),
    sheetAxes: sheets.flatMap(() => [1, 0, 0, 0, 1, 0, 0, 0, 1, 1, 0, 0, 0, 1, 0, 0, 0, 1]),  // povgen refuses errors of building
    sheetCentres: sheets.flatMap((pair) => [0, 1].map((k) => pair[k]?.centre ?? 0)),
    pitches: shapes.map(({ pitch }) => pitch),
    firstBases: all.map(({ values }, k) => ((shapes[k].edges.length ? 0 : prisms[k].gap) - values.aperture / shapes[k].pitch) / 2),
    prismHeights: dove.map(({ height, pitch }) => height / pitch),
    prismHalves: shapes.map(({ length, pitch }) => length / pitch / 2),
    slants: prisms.flatMap(({ base_angle }) => Array(2).fill(turned(geometry.radians(base_angle)))),
    glassIndices: shapes.flatMap(({ index }) => [index, index]),
    blackTops: prisms.map(({ tops }) => tops === "black"),
    ...(most && {
      profileCounts: shapes.map(({ edges }) => edges.length),
      profileEdges: everyEdge.map((edge) => edge.slice(0, 4)),
      profileRadii: everyEdge.map((edge) => edge[4]),
    }),
  };
}
