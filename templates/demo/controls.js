// Keys, buttons and the slider.

function toggleSheet() {
  through(state.sheet === "ideal" ? "detailed" : "ideal");
}

function stepBy(n) {
  play(false);
  seek(slider.valueAsNumber + n);
}

const KEYS = {
  " ": () => play(!state.playing),
  ArrowLeft: () => stepBy(-1),
  ArrowRight: () => stepBy(1),
  Home: () => stepBy(-slider.max),
  End: () => stepBy(Number(slider.max)),
  p: toggleSheet,
  o: () => predict(!state.prediction),
};
for (let n = 1; n <= Math.min(9, data.movies.length); n++) KEYS[n] = () => openTab(n - 1);

// While a tab has the focus, these keys go from tab to tab.
const KEYS_ON_TAB = {
  ArrowLeft: () => openNext(-1),
  ArrowRight: () => openNext(1),
  Home: () => openNext(-data.movies.indexOf(state.movie)),
  End: () => openNext(-1 - data.movies.indexOf(state.movie)),
};
function openNext(n) {
  const count = data.movies.length;
  const next = (data.movies.indexOf(state.movie) + n + count) % count;
  openTab(next);
  $(`tab-${next + 1}`).focus();
}

document.addEventListener("keydown", (event) => {
  const { target, key } = event;
  const tab = target.getAttribute("role") === "tab";
  if (event.ctrlKey || event.altKey || event.metaKey || target === $("sphere")) return;
  if (key === " " && target.tagName === "BUTTON" && !tab) return; // the browser presses the button
  const action = (tab && KEYS_ON_TAB[key]) || KEYS[key.length === 1 ? key.toLowerCase() : key];
  if (!action) return;
  event.preventDefault();
  action();
});

// After a click, keys go to the slider: space plays, and the arrows step.
document.addEventListener("click", (event) => {
  if (event.detail && event.target.closest("button")) slider.focus({ preventScroll: true });
});

[...$("tabs").children].forEach((tab, n) => tab.addEventListener("click", () => openTab(n)));
slider.addEventListener("input", () => {
  play(false);
  update();
});
$("play").addEventListener("click", () => play(!state.playing));
$("detailed").addEventListener("click", () => through("detailed"));
$("ideal").addEventListener("click", () => through("ideal"));
$("prediction").addEventListener("click", () => predict(!state.prediction));
$("sphere").addEventListener("change", (event) => {
  state.movie.chosen = event.target.value;
  update();
});
new ResizeObserver(() => drawDiagram(moment())).observe(diagram);

for (const movie of data.movies) movie.chosen = "z₁ = z₂";
openTab(0);
through("detailed");
predict(true);
