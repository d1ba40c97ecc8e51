// The diagram: figure 5(b) and (c) of the paper, with xi to the right and psi up.

const diagram = $("diagram");

function drawDiagram(now) {
  const { lean } = state.movie;
  const { width, height } = diagram.getBoundingClientRect();
  const rem = parseFloat(getComputedStyle(document.documentElement).fontSize);
  const unit = Math.min(width / 2.4, height / 1.44);
  const at = ([xi, psi]) => [unit * (xi - 0.5), unit * (-0.14 * lean - psi)];
  const [L, E, P] = [at([0, 0]), at([1, 0]), at(scaled(Math.min(1, 40 / abs(now.P)), now.P))];
  const beside = (place) => Math.min(distanceToLine(place, P, L), distanceToLine(place, P, E)) > 1.5 * rem;
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
    parts.push(words("far", [0, 0.33 * height], "P is infinitely far away:"));
    parts.push(words("far", [0, 0.33 * height + 1.4 * rem], "no light from L reaches E"));
  }
  parts.push(dot("dot", L, 0.3 * rem, "L"), words("point", plus(L, [-0.8 * rem, -0.8 * rem]), "L"));
  parts.push(dot("dot", E, 0.3 * rem, "E"), words("point", plus(E, [0.8 * rem, -0.8 * rem]), "E"));
  diagram.setAttribute("viewBox", `${-width / 2} ${-height / 2} ${width} ${height}`);
  diagram.replaceChildren(...parts);

  const corners = `L = 0, E = 1 and P = ${finite(now.P) ? point(now.P) : "∞, infinitely far away"}`;
  const nu = angle(equations.nu(now.r, now.alpha));
  const name = `Triangle of ${corners}; α = ${fixed(now.degrees, 1)}° at P, ν = ${nu} at E, r = ${size(now.r)}.`;
  diagram.setAttribute("aria-label", name);
}

// The axes, the circles of constant alpha (through L and E) and of constant r (around L or E), and all their names.
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

// The triangle L, P, E, with the vector P from L, the vector 1 - P to E, the angle alpha at P and the angle nu at E.
function triangle(now, at, rem, width, height) {
  const [L, E, far] = [at([0, 0]), at([1, 0]), abs(now.P) > 40];
  const toE = arg(equations.oneMinusP(now.r, now.alpha));
  const out = edge(at(now.P), width, height, 1.2 * rem);
  // if P is far outside, only the directions to P are drawn
  const P = far ? null : at(now.P);
  const fromL = P ?? step(L, arg(now.P), 1e4);
  const fromE = P ?? step(E, toE + Math.PI, 1e4);
  const parts = [line("base", L, E), ...vector("ray", L, fromL, rem), ...vector("of-nu", fromE, E, rem)];

  const nu = equations.nu(now.r, now.alpha);
  const side = nu < 0 ? -1 : 1; // L lies on the other side of E - P
  const length = abs(minus(fromE, E));
  const radius = Math.min(3.2 * rem, 0.5 * length);
  if (Math.abs(nu) > 0.03 && radius > 0.6 * rem) {
    parts.push(arc("of-nu", E, radius, Math.PI, nu));
    const beside = Math.abs(nu) * radius < 1.6 * rem; // no room inside the arc
    const where = beside ? Math.PI - (side * 0.7 * rem) / radius : Math.PI + nu / 2;
    parts.push(words("of-nu", step(E, where, radius + (beside ? 0 : 0.8 * rem)), "ν"));
  }
  if (length > 7.5 * rem) {
    const along = step(E, toE + Math.PI, Math.min(0.42 * length, 6 * rem));
    const room = 0.9 + 0.9 * Math.abs(Math.sin(toE)); // the text is wider than it is high
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
  // P's name goes on the side away from L and E
  const away = plus(turn(arg(now.P)), turn(toE + Math.PI));
  const aside = abs(away) > 0.05 ? arg(away) : -Math.PI / 2;
  parts.push(dot("dot", P, 0.34 * rem, "P"), words("point", step(P, aside, 1.1 * rem), "P"));
  return parts;
}
