// The player: from one frame or movie to another.

function imageAt(sheet, n) {
  const { frames, images } = state.movie;
  images[sheet] ??= [];
  if (!images[sheet][n]) {
    const image = new Image();
    image.id = "shown";
    image.decoding = "sync"; // so that picture and diagram are painted together
    image.src = frames[sheet][n].file;
    images[sheet][n] = image;
  }
  return images[sheet][n];
}
const wanted = () => imageAt(state.sheet, slider.valueAsNumber);

// Show the frame that the slider selects. Picture, diagram and numbers change together, when the picture is loaded.
function update() {
  const image = wanted();
  if (image.complete) show(image);
  else image.onload = image.onerror = () => image === wanted() && show(image);
}

function show(image) {
  const now = moment();
  const { sweep } = state.movie;
  const value = sweep === "alpha" ? now.degrees : now[sweep];
  const [nu, M] = [angle(equations.nu(now.r, now.alpha)), size(equations.M(now.r, now.alpha))];
  if (image !== $("shown")) $("shown").replaceWith(image);
  image.alt = describe(now);
  drawPrediction(now);
  drawDiagram(now);
  listSpheres(now);
  $("explanation").textContent = explanation(now);
  $("value").textContent = `${SYMBOL[sweep]} = ${quantity(sweep, value)}`;
  $("value-alpha").textContent = quantity("alpha", now.degrees);
  $("value-z1").textContent = size(now.z1);
  $("value-z2").textContent = size(now.z2);
  $("value-r").textContent = size(now.r);
  $("value-P").textContent = point(now.P);
  $("value-nu").textContent = nu;
  $("value-M").textContent = M;
  slider.setAttribute("aria-valuetext", `${quantity(sweep, value)}: P = ${point(now.P)}, ν = ${nu}, M = ${M}`);
}

function listSpheres(now) {
  const list = $("sphere");
  $("sphere-choice").hidden = now.labels.length < 2;
  if (list.dataset.labels !== now.labels.join()) {
    list.dataset.labels = now.labels.join();
    list.replaceChildren(...now.labels.map((name) => new Option(name)));
  }
  list.selectedIndex = now.chosen;
}

function seek(n) {
  slider.value = n;
  update();
}

function openTab(index) {
  play(false);
  if (state.movie) state.movie.at = slider.valueAsNumber;
  state.movie = data.movies[index];
  const { movie } = state;
  movie.images ??= {};
  // if sin(alpha) is mostly positive, P is mostly below the axis: leave more room there
  movie.lean = Math.sign(Math.round(movie.frames.ideal.reduce((sum, { alpha }) => sum + Math.sin(radians(alpha)), 0)));
  [...$("tabs").children].forEach((tab, n) => {
    tab.setAttribute("aria-selected", n === index);
    tab.tabIndex = n === index ? 0 : -1;
  });
  $("panel").setAttribute("aria-labelledby", `tab-${index + 1}`);
  $("title").textContent = movie.title;
  $("detailed").textContent = `2 × ${movie.prisms} prisms`;
  $("start").textContent = brief(movie.sweep, movie.start);
  $("stop").textContent = brief(movie.sweep, movie.stop);
  document.documentElement.style.setProperty("--ratio", movie.ratio);
  slider.max = movie.frames.detailed.length - 1;
  slider.setAttribute("aria-label", NAME[movie.sweep]);
  seek(movie.at ?? 0);
  for (const sheet of [state.sheet, "detailed", "ideal"]) movie.frames[sheet].forEach((_, n) => imageAt(sheet, n));
}

function through(sheet) {
  state.sheet = sheet;
  for (const name of ["detailed", "ideal"]) $(name).setAttribute("aria-pressed", name === sheet);
  update();
}

function predict(on) {
  state.prediction = on;
  $("prediction").setAttribute("aria-checked", on);
  update();
}

// ---- Play ----

function play(on) {
  if (on && !state.playing) {
    if (slider.value === slider.max) seek(0);
    requestAnimationFrame(tick);
  }
  state.playing = on;
  state.since = performance.now();
  $("play-icon").setAttribute("d", on ? "M0.5 0H3.5V10H0.5ZM6.5 0H9.5V10H6.5Z" : "M1 0L10 5L1 10Z");
  $("play-name").textContent = on ? "Pause" : "Play";
}

function tick(time) {
  if (!state.playing) return;
  const pause = 1000 / state.movie.rate;
  if (time - state.since >= pause && $("shown") === wanted()) {
    if (slider.value === slider.max) return play(false);
    state.since = Math.max(state.since + pause, time - pause);
    seek(slider.valueAsNumber + 1);
  }
  requestAnimationFrame(tick);
}
