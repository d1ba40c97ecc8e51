// What the shaders are given for a scene. Lengths are in tiles, angles in degrees.

import * as geometry from "./geometry.js";
import { CONSTANTS, constants, hasPrisms, idealWindows, kind, windows } from "./sheets.js";

const BACKGROUNDS = { sky: 0, black: 1, white: 2, transparent: 3 };

// What the shaders are compiled for.
export function defines(scene, { names, grid }) {
  /** @type {Record<string, any>} */
  const kinds = {
    WINDOWS: scene.window.length + 1,
    CONSTANTS,
    PIECES: geometry.pieces(scene).length,
    SPHERES: scene.name === "spheres" ? Math.max(11, geometry.spheres(scene).length) : 0,
    VOLUMES: names.length,
    GRID: grid.join(", "),
    ...Object.fromEntries(Object.keys(scene.pictures).map((part) => [`${part.toUpperCase()}_PICTURE`, 1])),
  };
  const edges = edgeCount(scene);
  if (edges) kinds.PROFILE_EDGES = edges;
  return Object.entries(kinds).map(([key, value]) => `#define ${key} ${value}\n`).join("");
}

// The greatest number of edges of a window's profile; 0: all are Dove prisms.
const edgeCount = (scene) => Math.max(...windows(scene).map((window) => geometry.shape(window).edges.length));

const padded = (list, length) => [...list, ...Array(length - list.length).fill(0)];

// The shaders' uniforms, for a scene with these pieces: `names` of their distance fields, and `places`.
export function uniforms(scene, { names, places }) {
  const all = windows(scene), spheres = geometry.spheres(scene), pieces = geometry.pieces(scene);
  const prisms = all.map(({ values }) => geometry.prism(values));
  const shapes = all.map(geometry.shape), edges = edgeCount(scene);
  const everyEdge = shapes.flatMap((shape) => padded(shape.edges, edges).map((edge) => edge || [0, 0, 0, 0, 0]));
  const sheets = all.map(geometry.sheets);
  const turned = (angle) => [Math.cos(angle), Math.sin(angle)];
  const most = Math.max(11, spheres.length);
  return {
    simulated: idealWindows(scene).length,
    kind: all.map(kind),
    constants: all.flatMap((window) => padded(hasPrisms(window) ? [] : constants(window), CONSTANTS)),
    eye: [...scene.eye, -scene.z2],
    viewHeight: scene.view,
    background: BACKGROUNDS[scene.background],
    window: scene.aperture,
    windowZ: all.map(({ z }) => z),
    frameDepth: geometry.depth(scene),
    frameRim: scene.rim,
    hasFloor: scene.name === "chess" && scene.floor !== "none",
    skyPicture: 2,
    floorPicture: 3,
    floorTiles: scene.pictures.floor?.tiles ?? [1, 1],
    floorMean: scene.pictures.floor?.mean ?? [0, 0, 0],
    floorY: geometry.floorY(scene),
    horizon: geometry.horizon(scene),
    sheetCounts: sheets.map((pair) => pair.length),
    sheetTurns: sheets.flatMap((pair) => [0, 1].map((k) => turned(pair[k]?.angle ?? 0))),
    sheetAxes: sheets.flatMap(() => [1, 0, 0, 0, 1, 0, 0, 0, 1, 1, 0, 0, 0, 1, 0, 0, 0, 1]),  // povgen refuses errors of building
    sheetCentres: sheets.flatMap((pair) => [0, 1].map((k) => pair[k]?.centre ?? 0)),
    pitches: shapes.map(({ pitch }) => pitch),
    firstBases: all.map(({ values }, k) => (shapes[k].edges.length ? -values.aperture / shapes[k].pitch : values.gap - values.prisms) / 2),
    prismHeights: prisms.map(({ height, pitch }) => height / pitch),
    prismHalves: shapes.map(({ length, pitch }) => length / pitch / 2),
    slants: all.flatMap(({ values }) => Array(2).fill(turned(geometry.radians(values.base_angle)))),
    glassIndices: shapes.flatMap(({ index }) => [index, index]),
    blackTops: all.map((window, k) => hasPrisms(window) && !shapes[k].edges.length && window.values.tops === "black"),
    maxFaces: scene.faces,
    volumes: 1,
    pieceFoot: pieces.map((piece) => piece.foot),
    pedestal: scene.pedestal ?? 0,
    pedestalHalf: pieces.map((piece) => piece.half),
    pieceColour: pieces.map((piece) => piece.color),
    pieceVolume: pieces.map((piece) => names.indexOf(piece.name)),
    volumePlace: places,
    sphereCount: spheres.length,
    spheres: Array.from({ length: most }, (_, k) => (spheres[k] ? [...spheres[k].centre, spheres[k].radius] : [0, 0, 1, 0])),
    ...(edges && {
      profileCounts: shapes.map((shape) => shape.edges.length),
      profileEdges: everyEdge.map((edge) => edge.slice(0, 4)),
      profileRadii: everyEdge.map((edge) => edge[4]),
    }),
  };
}
