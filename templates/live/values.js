// What the shaders are given for a scene. Lengths are in tiles, angles in degrees.

import * as geometry from "./geometry.js";
import { CONSTANTS, constants, hasPrisms, idealWindows, kind, windows } from "./sheets.js";

const BACKGROUNDS = { sky: 0, black: 1, white: 2, transparent: 3 };

// What the shaders are compiled for.
export function defines(scene, { names, grid }) {
  const kinds = {
    WINDOWS: scene.window.length + 1,
    CONSTANTS,
    PIECES: geometry.pieces(scene).length,
    SPHERES: scene.name === "spheres" ? Math.max(11, geometry.spheres(scene).length) : 0,
    VOLUMES: names.length,
    CORNERS: geometry.frameSection(scene).length,
    GRID: grid.join(", "),
  };
  return Object.entries(kinds).map(([key, value]) => `#define ${key} ${value}\n`).join("");
}

const padded = (list, length) => [...list, ...Array(length - list.length).fill(0)];

// The shaders' uniforms, for a scene with these pieces: `names` of their distance fields, and `places`.
export function uniforms(scene, { names, places }) {
  const all = windows(scene), prism = geometry.prism(scene), spheres = geometry.spheres(scene);
  const pieces = geometry.pieces(scene), base = geometry.radians(scene.base_angle);
  const sheets = all.map((window) => geometry.sheets(scene, window));
  const turned = (angle) => [Math.cos(angle), Math.sin(angle)];
  const centres = sheets.find((pair) => pair.length)?.map(({ centre }) => centre) ?? [];
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
    frameSection: geometry.frameSection(scene),
    frameLip: geometry.frameLip(scene),
    hasFloor: scene.name === "chess",
    floorY: geometry.floorY(scene),
    horizon: geometry.horizon(scene),
    sheets: centres.length,
    sheetTurn: sheets.flatMap((pair) => [0, 1].map((k) => turned(pair[k]?.angle ?? 0))),
    sheetCentre: [0, 1].map((k) => centres[k] ?? 0),
    pitch: prism.pitch,
    firstBase: -scene.prisms / 2 + scene.gap / 2,
    prismHeight: prism.height / prism.pitch,
    prismHalf: prism.length / prism.pitch / 2,
    slant: [Math.cos(base), Math.sin(base)],
    glassIndex: scene.index,
    blackTops: scene.tops === "black",
    maxFaces: scene.faces,
    volumes: 1,
    pieceFoot: pieces.map((piece) => piece.foot),
    pedestal: scene.pedestal,
    pedestalHalf: pieces.map((piece) => piece.half),
    pieceColour: pieces.map((piece) => piece.color),
    pieceVolume: pieces.map((piece) => names.indexOf(piece.name)),
    volumePlace: places,
    sphereCount: spheres.length,
    spheres: Array.from({ length: most }, (_, k) => (spheres[k] ? [...spheres[k].centre, spheres[k].radius] : [0, 0, 1, 0])),
  };
}
