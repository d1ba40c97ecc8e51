// The user's own room in the place of the mountains: a photo, or the camera's picture. Nothing leaves the page.

import { $, element } from "./data.js";
import { say } from "./language.js";
import { setOtherSky, view } from "./picture.js";

const WIDTH = 2048;    // pixels of the picture of all directions, which is half as high
const FIELD = 100;     // degrees: the width of a plain photo, as the room shows it
const STEP = 100;      // ms between two pictures of the camera
let stream = null;

// Draw a picture on one of all directions. What is plain is in front, behind the window; the rest repeats its border, softly.
function around(source, width, height, whole) {
  const canvas = element("canvas", { width: WIDTH, height: WIDTH / 2 }), pen = canvas.getContext("2d");
  if (whole) {
    pen.drawImage(source, 0, 0, WIDTH, WIDTH / 2);
    return canvas;
  }
  const wide = (WIDTH * FIELD) / 360, high = (wide * height) / width;
  pen.filter = "blur(24px)";
  for (let x = -1; x < 360 / FIELD; x++) {  // mirrored copies all around, so that no border is seen
    pen.save();
    pen.translate(WIDTH / 2 + (x - 0.5) * wide + (x % 2 ? wide : 0), 0);
    pen.scale(x % 2 ? -1 : 1, 1);
    pen.drawImage(source, 0, 0, wide, WIDTH / 2);
    pen.restore();
  }
  pen.filter = "none";
  pen.drawImage(source, (WIDTH - wide) / 2, (WIDTH / 2 - high) / 2, wide, high);
  return canvas;
}

function show(picture) {
  view.setSky(picture);
  setOtherSky(picture);
}

function stopCamera() {
  stream?.getTracks().forEach((track) => track.stop());
  stream = null;
  $("camera").setAttribute("aria-pressed", false);
}

function noCamera() {
  stopCamera();
  $("room-message").textContent = say("share.no_camera");
}

let photo = null;
const showPhoto = () => photo && show(around(photo, photo.width, photo.height, $("all-around").checked));

$("photo").addEventListener("change", async () => {
  const [file] = $("photo").files;
  if (!file) return;
  stopCamera();
  try {
    photo = await createImageBitmap(file);
    $("all-around").checked = photo.width === 2 * photo.height;
    $("room-message").textContent = "";
    showPhoto();
  } catch {
    $("room-message").textContent = say("share.no_photo");
  }
});
$("all-around").addEventListener("change", showPhoto);

let asking = false;  // for the camera: a second press would start a camera that nothing stops
$("camera").addEventListener("click", async () => {
  if (stream) return stopCamera();
  if (asking) return;
  const video = $("camera-video");
  asking = true;
  try {
    stream = await navigator.mediaDevices.getUserMedia({ video: { facingMode: "environment" } });
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
  video.srcObject = stream;
  try {
    await video.play();
  } catch {
    if (stream === own) noCamera();
    return;
  }
  const next = () => {
    if (stream !== own) return;
    show(around(video, video.videoWidth, video.videoHeight, $("all-around").checked));
    setTimeout(next, STEP);
  };
  next();
});

$("no-room").addEventListener("click", () => {
  stopCamera();
  photo = null;
  $("photo").value = "";
  show(null);
});
