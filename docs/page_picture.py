"""Take a picture of the page to teach with: `python docs/page_picture.py -o FILE.png`.

Needs povgen[live] and a Chromium.
"""

from argparse import ArgumentParser
from pathlib import Path
from tempfile import TemporaryDirectory

from povgen.measure.browser import chromium
from povgen.page.page import demo

ADDRESS = "#sheet=ideal&alpha=66&z1=4&show=position,image"


def main() -> None:
    """Draw the page with the predictions, in the smallest window that shows all, for large letters: 1280x800."""
    parser = ArgumentParser()
    parser.add_argument("-o", dest="output", required=True)
    output = parser.parse_args().output
    with TemporaryDirectory() as folder, chromium() as browser:
        made = demo(Path(folder) / "demo.html", progress=False)
        page = browser.new_page(viewport={"width": 904, "height": 565}, device_scale_factor=800 / 565)
        page.goto(made.as_uri() + ADDRESS)
        page.wait_for_function("povgen.picture.view.converged()", timeout=300_000)
        page.evaluate("document.getElementById('hint').hidden = true")
        page.screenshot(path=output)


if __name__ == "__main__":
    main()
