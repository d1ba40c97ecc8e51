"""The live view in a real browser, for measurements: a Chromium without window, which draws without a GPU."""

import base64
import shutil
from collections.abc import Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from povgen import remedies
from povgen.errors import InputError
from povgen.files import temporary_folder
from povgen.inputs.hdr import encoded
from povgen.liveview.view import html
from povgen.scene.presets import AxialScene

if TYPE_CHECKING:
    from playwright.sync_api import Browser as Browser  # other modules may import it from here
    from playwright.sync_api import Page

Floats = NDArray[np.float32]
Size = tuple[int, int]  # width and height, pixels
# SwiftShader draws in software; Chromium uses it only if it is told to. Without GPU rasterization SwiftShader draws
# only the live view, and the page around it is drawn faster. With --no-sandbox Chromium also starts for the user root.
# The arguments after it keep Chromium off the network.
ARGUMENTS = (
    "--use-angle=swiftshader --enable-unsafe-swiftshader --disable-gpu-rasterization --no-sandbox --disable-quic "
    "--no-first-run --disable-background-networking --disable-component-update --disable-sync"
).split()
# JavaScript that encodes a typed array's bytes in base 64. A function call can take only some of the bytes at once.
ENCODE = """(numbers) => {
  const bytes = new Uint8Array(numbers.buffer);
  let text = "";
  for (let k = 0; k < bytes.length; k += 32768) text += String.fromCharCode(...bytes.subarray(k, k + 32768));
  return btoa(text);
}"""


@contextmanager
def chromium() -> Iterator["Browser"]:
    """Start a Chromium, and end it afterwards. Raises InputError if playwright or Chromium is not installed."""
    try:
        from playwright.sync_api import Error, sync_playwright
    except ImportError:
        raise InputError(
            f"the live view is measured with playwright, which is not installed: {remedies.extra('live')}"
        ) from None
    found = shutil.which("chromium")
    with sync_playwright() as playwright:
        try:
            browser = playwright.chromium.launch(executable_path=found, args=ARGUMENTS)
        except Error as error:
            if found:
                raise InputError(f"{found} does not start: {str(error).partition(chr(10))[0]}") from None
            raise InputError("no Chromium: install it as 'chromium', or by 'playwright install chromium'") from None
        try:
            yield browser
        finally:
            browser.close()


class View:
    """A page that shows a scene's live view. Pictures have their first row at the top."""

    def __init__(self, browser: "Browser", scene: AxialScene) -> None:
        """Open the page. Raises InputError if the browser cannot draw."""
        self.page: Page = browser.new_page(viewport={"width": 32, "height": 24})
        with temporary_folder() as folder:
            file = folder / "view.html"
            file.write_text(html(scene), "utf-8")
            self.page.goto(file.as_uri())
            self.page.evaluate("povgen.main.view.ready")
        if not self.page.evaluate("Boolean(povgen.main.view.gl)"):
            raise InputError(f"Chromium: {self.page.inner_text('#message')}")

    def readout(self, size: Size) -> dict[str, Floats]:
        """Return `ray`, `shown` and `met`, (height, width, 4) each. povgen/liveview/readout.glsl explains them."""
        names = ("ray", "shown", "met")
        script = f"(size) => Object.values(povgen.readout.readout(povgen.main.view, ...size)).map({ENCODE})"
        found = self.page.evaluate(script, list(size))
        return {name: _pixels(text, size) for name, text in zip(names, found, strict=True)}

    def picture(self, size: Size, rays: int, part: float = 1) -> NDArray[np.uint8]:
        """Return the picture, (height, width, 3), as sRGB bytes.

        `rays` rays are followed for each pixel. They are spread over the middle `part` of the pixel's width and height:
        with 0, all pass the pixel's centre. A transparent background is black.
        """
        script = f"(numbers) => ({ENCODE})(povgen.readout.light(povgen.main.view, ...numbers))"
        light = _pixels(self.page.evaluate(script, [*size, rays, part]), size)[..., :3] / np.float32(rays)
        return np.rint(encoded(light)).astype(np.uint8)


def _pixels(text: str, size: Size) -> Floats:
    width, height = size
    return np.frombuffer(base64.b64decode(text), np.float32).reshape(height, width, 4)[::-1]
