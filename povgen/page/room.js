// The user's own room in the place of the mountains: a photo, or the camera's picture. Nothing leaves the page.

import { radians } from "../liveview/geometry.js";
import { $, element, on } from "./data.js";
import { say } from "./language.js";
import { setOtherSky, view } from "./picture.js";
import { session } from "./state.js";
import { tour } from "./tour.js";

// The width in pixels of the picture of all directions, which is half as high: of a photo, while it is being moved, and the least.
const WIDTH = { PHOTO: 4096, MOVED: 1024, LEAST: 512 };
const SLOW = 200;     // ms: if the camera's picture takes longer, the next one has half the width
const AROUND = 64;    // pixels of what is around a photo
const PLACE = ["x", "y", "size", "turn"];  // of a photo: degrees; the size is that of its shorter side
let photo = null;
let stream = null;
let room = null;   // the picture in the place of the mountains
let drawn = null;  // and the one that the views have

// What is around a photo: mirrored copies of it, so that no border is seen, of few pixels, so that they are blurred.
function surroundings(source) {
  const canvas = element("canvas", { width: AROUND, height: AROUND / 2 }), pen = canvas.getContext("2d"), wide = AROUND / 4;
  for (let n = -2; n <= 2; n++) {
    pen.setTransform(n % 2 ? -1 : 1, 0, 0, 1, AROUND / 2 + (n + (n % 2 ? 0.5 : -0.5)) * wide, 0);
    pen.drawImage(source, 0, 0, wide, AROUND / 2);
  }
  return canvas;
}

// Draw a picture on one of all directions, behind the window, as the user has placed it.
function around(source, [width, height], most) {
  const wide = Math.min(most, view.gl?.getParameter(view.gl.MAX_TEXTURE_SIZE) ?? most), degree = wide / 360;
  const canvas = element("canvas", { width: wide, height: wide / 2 }), pen = canvas.getContext("2d");
  const [x, y, size, turn] = PLACE.map((name) => Number($(`room-${name}`).value));
  const whole = $("all-around").checked;
  const [far, top, high] = whole ? [source, 0, wide / 2] : [surroundings(source), -wide / 4 - y * degree, wide];
  pen.imageSmoothingQuality = "high";
  for (const copy of [-1, 0, 1]) pen.drawImage(far, copy * wide + x * degree, top, wide, high);
  if (whole) return canvas;
  const scale = (size * degree) / Math.min(width, height);
  pen.translate(wide / 2 + x * degree, wide / 4 - y * degree);
  pen.rotate(radians(turn));
  pen.drawImage(source, (-scale * width) / 2, (-scale * height) / 2, scale * width, scale * height);
  return canvas;
}

function show(picture) {
  room = picture;
  drawBehind();
}

// The guided start speaks of the mountains and the floor: it shows them.
export function drawBehind() {
  const touring = tour.step >= 0, picture = touring ? null : room;
  session.floor = touring || $("room-floor").checked;
  if (picture === drawn) return;
  drawn = picture;
  view.setSky(picture);
  setOtherSky(picture);
}

const showPhoto = (most = WIDTH.PHOTO) => photo && show(around(photo, [photo.width, photo.height], most));

function drawTools() {
  $("room-place").hidden = !photo && !stream;
  for (const name of PLACE.slice(1)) $(`room-${name}`).disabled = $("all-around").checked;
}

// The camera's last picture stays, as a photo.
function stopCamera() {
  const video = $("camera-video"), { videoWidth: width, videoHeight: height } = video;
  if (stream && width) {
    photo = element("canvas", { width, height });
    photo.getContext("2d").drawImage(video, 0, 0);
    showPhoto();
  }
  stream?.getTracks().forEach((track) => track.stop());
  stream = null;
  $("camera").setAttribute("aria-pressed", false);
  drawTools();
}

function noCamera() {
  stopCamera();
  $("room-message").textContent = say("share.no_camera");
}

$("photo").addEventListener("change", async () => {
  const [file] = $("photo").files;
  if (!file) return;
  stopCamera();
  try {
    photo = await createImageBitmap(file, { imageOrientation: "from-image" });
    $("all-around").checked = photo.width === 2 * photo.height;
    $("room-message").textContent = "";
    drawTools();
    showPhoto();
  } catch {
    $("room-message").textContent = say("share.no_photo");
  }
});
$("all-around").addEventListener("change", () => {
  drawTools();
  showPhoto();
});
$("room-place").addEventListener("input", () => showPhoto(WIDTH.MOVED));
$("room-place").addEventListener("change", () => showPhoto());
on("room-floor", "change", drawBehind);
$("room-close").addEventListener("click", () => {
  $("room-open").click();
  $("room-open").focus();
});

let asking = false;  // for the camera: a second press would start a camera that nothing stops
$("camera").addEventListener("click", async () => {
  if (stream) return stopCamera();
  if (asking) return;
  const video = $("camera-video");
  asking = true;
  try {
    stream = await navigator.mediaDevices.getUserMedia({ video: { facingMode: "environment", width: { ideal: 1280 } } });
  } catch {
    return noCamera();
  } finally {
    asking = false;
  }
  const own = stream;  // if the camera is switched off and on, `stream` is another one
  for (const track of own.getTracks()) track.addEventListener("ended", stopCamera);  // it was unplugged
  $("room-message").textContent = "";
  $("camera").setAttribute("aria-pressed", true);
  photo = null;
  drawTools();
  video.srcObject = stream;
  try {
    await video.play();
  } catch {
    if (stream === own) noCamera();
    return;
  }
  follow(video, own);
});

// Show the camera's pictures, each when the one before has been drawn.
function follow(video, own, wide = WIDTH.PHOTO / 2) {
  const start = performance.now();
  show(around(video, [video.videoWidth, video.videoHeight], wide));
  const prepared = !view.behind;
  const wait = () => {
    if (stream !== own) return;
    if (view.moving) requestAnimationFrame(wait);
    else follow(video, own, prepared && performance.now() - start > SLOW ? Math.max(WIDTH.LEAST, wide / 2) : wide);
  };
  requestAnimationFrame(wait);
}

on("no-room", "click", () => {
  stopCamera();
  photo = null;
  $("photo").value = "";
  for (const name of PLACE) $(`room-${name}`).value = $(`room-${name}`).defaultValue;
  $("room-floor").checked = true;
  $("all-around").checked = false;
  drawTools();
  show(null);
});
