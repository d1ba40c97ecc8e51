// A piece's distance field, from the bytes in the page to the numbers in a 3D texture. povgen/liveview/volumes.py made it.

// The bytes that Python's zlib has compressed and base64 has encoded.
async function inflated(text) {
  const packed = Uint8Array.from(atob(text), (c) => c.charCodeAt(0));
  const stream = new Blob([packed]).stream().pipeThrough(new DecompressionStream("deflate"));
  return new Uint8Array(await new Response(stream).arrayBuffer());
}

// The distances to the surface, in voxels, below 0 inside. The bytes hold distances up to `most`, each as the difference
// to the one before along z. Farther away the field is extended: it may be less than the distance, not more.
export async function field({ data, most }, [nx, ny, nz]) {
  const bytes = await inflated(data);
  const distance = new Float32Array(bytes.length);
  for (let k = 0; k < bytes.length; k++) {
    if (k >= nx * ny) bytes[k] += bytes[k - nx * ny];  // modulo 256
    distance[k] = bytes[k] === 255 ? Infinity : ((bytes[k] - 128) / 127) * most;
  }
  extend(distance, nx, ny, nz, most);
  return distance;
}

// Two sweeps, each from the neighbours before. 0.9: steps along the diagonals are up to a tenth too long.
function extend(distance, nx, ny, nz, most) {
  const rows = nx * ny;
  const before = [];
  for (let z = -1; z <= 0; z++) {
    for (let y = -1; y <= (z ? 1 : 0); y++) {
      for (let x = -1; x <= (z || y ? 1 : -1); x++) before.push([x, y, z]);
    }
  }
  for (const sense of [1, -1]) {
    const steps = before.map(([x, y, z]) => ({
      at: sense * (x + nx * y + rows * z), x: sense * x, y: sense * y, z: sense * z, length: 0.9 * Math.hypot(x, y, z),
    }));
    for (let n = 0; n < distance.length; n++) {
      const k = sense > 0 ? n : distance.length - 1 - n;
      if (distance[k] < most) continue;
      const x = k % nx, y = Math.floor(k / nx) % ny, z = Math.floor(k / rows);
      let least = distance[k];
      for (const step of steps) {
        const inside = x + step.x >= 0 && x + step.x < nx && y + step.y >= 0 && y + step.y < ny
          && z + step.z >= 0 && z + step.z < nz;
        if (inside) least = Math.min(least, Math.max(distance[k + step.at], 0) + step.length);
      }
      distance[k] = least;
    }
  }
}

