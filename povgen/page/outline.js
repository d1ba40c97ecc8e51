// A piece's outline, as an eye far away sees it: from the piece's distance field.

const outlines = {};
let shapes = null;

// Take the outlines from distance fields: `LiveView.shapes`.
export function outlinesOf(known) {
  shapes = known;
}

// Closed lines of points, tiles from the foot's centre: x to the right, y up. [] until the field has been read.
export function outlineOf(name) {
  const k = shapes?.names.indexOf(name);
  if (!shapes?.fields[k]) return [];
  return (outlines[name] ??= contours(silhouette(shapes.fields[k], shapes.grid), shapes.places[k]));
}

// Whether a point is inside closed lines: a line from it to the right crosses them an odd number of times.
export function within([x, y], lines) {
  let inside = false;
  for (const points of lines) {
    points.forEach(([bx, by], n) => {
      const [ax, ay] = points.at(n - 1);
      if (ay > y !== by > y && x < ax + ((y - ay) / (by - ay)) * (bx - ax)) inside = !inside;
    });
  }
  return inside;
}

// The least distance along z to the surface, at each point of the grid in x and y; below 0 inside the outline.
function silhouette(field, [nx, ny, nz]) {
  const least = new Float32Array(nx * ny).fill(Infinity);
  for (let k = 0; k < nx * ny * nz; k++) least[k % (nx * ny)] = Math.min(least[k % (nx * ny)], field[k]);
  return { least, nx, ny };
}

// The lines along which the values are 0: marching squares. Each step leads from an edge of a square to another.
function contours({ least, nx, ny }, [x0, y0, , voxel]) {
  const next = new Map();
  const points = new Map();
  // the point on the edge between two neighbours where the value is 0
  const crossing = (a, b) => {
    const [low, high] = a < b ? [a, b] : [b, a];
    const key = `${low} ${high}`;
    const part = least[low] / (least[low] - least[high]);
    const place = (axis) => (1 - part) * axis(low) + part * axis(high);
    points.set(key, [x0 + voxel * place((k) => k % nx), y0 + voxel * place((k) => Math.floor(k / nx))]);
    return key;
  };
  for (let y = 0; y + 1 < ny; y++) {
    for (let x = 0; x + 1 < nx; x++) {
      const k = x + nx * y;
      const square = [k, k + 1, k + 1 + nx, k + nx];
      const enters = [], leaves = [];
      square.forEach((a, n) => {
        const b = square[(n + 1) % 4];
        if (least[a] >= 0 && least[b] < 0) enters.push(crossing(a, b));
        if (least[a] < 0 && least[b] >= 0) leaves.push(crossing(a, b));
      });
      leaves.forEach((key, n) => next.set(key, enters[n]));
    }
  }
  const lines = [];
  while (next.size) {
    const line = [];
    for (let key = next.keys().next().value; next.has(key);) {
      line.push(points.get(key));
      const following = next.get(key);
      next.delete(key);
      key = following;
    }
    lines.push(line);
  }
  return lines.filter((line) => line.length > 8);
}
