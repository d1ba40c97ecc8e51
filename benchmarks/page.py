"""How many pictures a second the teaching page draws in software while alpha is dragged: `python benchmarks/page.py`.

Needs povgen[live] and a Chromium. The machine should do nothing else.
"""

import time
from pathlib import Path
from statistics import median

from povgen.files import temporary_folder
from povgen.measure.browser import chromium
from povgen.page.page import demo

SIZE = {"width": 1280, "height": 800}
BEFORE, MEASURED = 4, 10  # seconds: the page first finds how many pixels it can draw at once
# Each picture's width and height, pixels, and its time, ms.
LISTEN = """() => {
  window.drawn = [];
  const { context } = povgen.picture.view, show = context.show;
  context.show = (sum, size, count) => {
    drawn.push([...size, performance.now()]);
    return show.call(context, sum, size, count);
  };
}"""


def main() -> None:
    """Print a line for the ideal sheet and one for two sheets of prisms."""
    with temporary_folder() as folder, chromium() as browser:
        file = demo(Path(folder) / "demo.html", progress=False)
        for sheet in ("ideal", "detailed"):
            page = browser.new_page(viewport=SIZE)
            page.goto(f"{file.as_uri()}#sheet={sheet}")
            page.wait_for_function("povgen.picture.view.converged()", timeout=600_000)
            page.evaluate(LISTEN)
            box = page.locator("#slider-alpha").bounding_box()
            assert box
            start, y = time.monotonic(), box["y"] + box["height"] / 2
            while (passed := time.monotonic() - start) < BEFORE + MEASURED:
                part = 0.5 + 0.4 * abs(1 - passed / 2 % 2)  # from 0 to 144 degrees and back, in 4 s
                page.mouse.move(box["x"] + box["width"] * part, y)
                if passed < 1:
                    page.mouse.down()
                time.sleep(1 / 60)
            drawn = page.evaluate("drawn")
            late = [each for each in drawn if each[2] > drawn[-1][2] - 1000 * MEASURED]
            gaps = [after[2] - before[2] for before, after in zip(late, late[1:], strict=False)]
            width, height = (median(each[k] for each in late) for k in (0, 1))
            whole = page.evaluate("povgen.picture.view.canvas.width")
            print(
                f"{sheet}: {len(late) / MEASURED:.1f} pictures a second, {width:.0f}x{height:.0f} pixels on a canvas "
                f"{whole} wide; {median(gaps):.0f} ms apart, at most {max(gaps):.0f} ms"
            )
            page.close()


if __name__ == "__main__":
    main()
