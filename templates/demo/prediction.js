// The prediction, drawn over the picture, in hundredths of a tile from the window's centre.

const overlay = $("overlay");

function drawPrediction(now) {
  const { sweep, L, E, view, ratio } = state.movie;
  const prism = state.sheet === "ideal" ? { slab_shift: 0, separation: 0 } : state.movie.prism;
  const [width, height] = [100 * view * ratio, 100 * view];
  const at = ([x, y]) => [100 * x, -100 * y];
  overlay.setAttribute("viewBox", `${-width / 2} ${-height / 2} ${width} ${height}`);
  overlay.replaceChildren();
  if (!state.prediction) return;

  const shapes = [];
  if (sweep !== "alpha" || now.objects.length > 1) {
    const still = sweep === "z2" ? now.z1 : now.z2;
    const place = (log) => {
      const moved = still * Math.exp(log);
      const [z1, z2] = sweep === "z2" ? [still, moved] : [moved, still];
      return at(apparentPosition(z1, z2, now.alpha));
    };
    const infinite = equations.infiniteZ1(still, now.alpha, prism).map((moved) => Math.log(moved / still));
    shapes.push(curve("of-alpha", branches(place, -8, 8, infinite)));
  }
  if (sweep === "alpha") {
    const infinite = equations.infiniteAlpha(now.z1, now.z2, prism);
    const place = (alpha) => at(apparentPosition(now.z1, now.z2, alpha));
    shapes.push(curve("of-r", branches(place, -Math.PI, Math.PI, infinite)));
  }

  const tops = [dot("dot", at(L), 3.5), words("", plus(at(L), [0, -19]), "L")];
  tops.push(dot("dot", at(E), 3.5), words("", plus(at(E), [0, -19]), "E"));
  now.objects.forEach((z1, k) => {
    const place = at(apparentPosition(z1, now.z2, now.alpha));
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
