"""Take a picture of the page to teach with: `python docs/page_picture.py -o FILE.png`.

Needs povgen[live] and a Chromium.
"""

from argparse import ArgumentParser
from pathlib import Path
from tempfile import TemporaryDirectory

from povgen.measure.browser import chromium
from povgen.page.page import demo

ADDRESS = "#sheet=ideal&alpha=66&show=position,circles,image"


def main() -> None:
    """Draw the page as it opens, with the predictions, 1280x720."""
    parser = ArgumentParser()
    parser.add_argument("-o", dest="output", required=True)
    output = parser.parse_args().output
    with TemporaryDirectory() as folder, chromium() as browser:
        made = demo(Path(folder) / "demo.html", progress=False)
        page = browser.new_page(viewport={"width": 1280, "height": 720})
        page.goto(made.as_uri() + ADDRESS)
        page.wait_for_function("povgen.picture.view.converged()", timeout=300_000)
        page.screenshot(path=output)


if __name__ == "__main__":
    main()
