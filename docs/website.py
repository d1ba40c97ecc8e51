"""Build the site: `make site`, or `python docs/website.py FOLDER`, a new folder. It needs povgen[docs], and no network.

Sphinx makes the pages from the same Markdown files that are read in the repository, in a copy of their folders, so the
links between them stay as they are. The script adds the live page, the gallery's exhibits and the Python interface.
"""

import re
import shlex
import shutil
import sys
from html import escape
from pathlib import Path
from tempfile import TemporaryDirectory
from urllib.parse import unquote

import api
import imageio.v3 as iio
from exhibits import Exhibit, exhibits
from first_picture import RATE
from sphinx.application import Sphinx

from povgen.page.page import demo
from povgen.version import __version__
from povgen.video import encode

PROJECT = Path(__file__).parents[1]
# the pages of each part, in the order of the menu
CONTENTS = {
    "Learn": [
        "docs/tutorial",
        "docs/lesson",
        "docs/worksheet",
        "docs/model",
        "docs/seminar",
    ],
    "How to": [
        "docs/install",
        "docs/troubleshooting",
        "docs/usage",
        "docs/page",
        "docs/own",
        "docs/rooms",
        "docs/gallery",
        "docs/python",
        "docs/examples",
        "docs/rays",
        "docs/cluster",
        "docs/adding",
    ],
    "Reference": [
        "docs/terms",
        "docs/cheatsheet",
        "docs/reference",
        "docs/figures/README",
        "docs/errata",
    ],
    "Explanation": [
        "docs/sheets",
        "docs/beyond",
        "docs/light",
        "docs/lenticulars",
        "docs/tolerances",
        "docs/accuracy",
        "docs/speed",
    ],
    "The project": [
        "CONTRIBUTING",
        "docs/architecture",
        "CODE_OF_CONDUCT",
        "SECURITY",
        "docs/roadmap",
        "docs/credits",
        "docs/website",
        "CHANGELOG",
    ],
}
# a setting of the live page: [text] `demo.html#alpha=90`
SETTING = re.compile(r"\[([^][]+)\] `demo\.html((?:[?#][^`]*)?)`")
LINK = re.compile(r"(!?)\[([^][]*)\]\(([^)#\s]+)(#[^)\s]*)?\)")
SETTINGS = {
    "project": "povgen",
    "html_title": f"povgen {__version__}",
    "extensions": ["myst_parser"],
    "myst_heading_anchors": 6,  # as GitHub names them
    "root_doc": "index",
    "language": "en",
    "smartquotes": False,
    "highlight_language": "none",
    "html_theme": "furo",
    "html_static_path": ["_static"],
    "html_css_files": ["site.css"],
    "html_copy_source": False,
    "html_show_sphinx": False,
    "html_show_copyright": False,
    "html_show_search_summary": False,  # a page that is opened from a file cannot read others
}
# Cells of tables break only between words. Pictures and movies are never wider than the page. A movie's controls are
# below it.
CSS = """
table.docutils code { white-space: normal; overflow-wrap: normal; }
#options td:first-child code { white-space: nowrap; }
video { width: 100%; aspect-ratio: 13 / 11; object-fit: contain; object-position: top; background: #222; }
article a { text-decoration: underline; }
"""
# On paper a page has no menus. The worksheet is two pages with lines and cells to write in, and one of answers.
CSS += """
#worksheet-windows-that-turn-light hr { margin: 2rem 0 0; border: 0; border-bottom: 1px solid; }
@media print {
  @page { size: A4; margin: 9mm 15mm; }
  html { font-size: 9.5pt; }
  .skip-to-content, .sidebar-drawer, .toc-drawer, .mobile-header { display: none; }
  .content-icon-container, .content footer { display: none; }
  .main, .content, .article-container, .page { display: block; width: 100%; max-width: none; padding: 0; }
  article h1 { font-size: 1.6em; margin: 0 0 0.3em; padding: 0; }
  article h2 { font-size: 1.25em; margin: 0.7em 0 0.3em; padding: 0; }
  article :is(p, ul, ol) { margin: 0.3em 0; }
  article, article a { color: black; text-decoration: none; }
  article .table-wrapper { margin: 0.5em 0; overflow: visible; }
  article table.docutils { box-shadow: none; }
  article table.docutils :is(th, td) { border: 0.5pt solid black; background: none; }
  #worksheet-windows-that-turn-light table { width: 100%; margin: 0; }
  #worksheet-windows-that-turn-light thead:not(:has(p:not(:empty))) { display: none; }
  #worksheet-windows-that-turn-light hr { margin-top: 1.9em; }
  #worksheet-windows-that-turn-light :is(th, td):not(:first-child) { min-width: 4em; }
  #worksheet-windows-that-turn-light :is(th, td) { height: 1.8em; }
  #measure-on-paper, #answers { break-before: page; }
}
"""

# Faults of accessibility in Sphinx and its theme: a heading without a level, and code that keys cannot scroll.
MENDED = {'role="heading"': 'role="heading" aria-level="2"', "<pre>": '<pre tabindex="0">'}


def build(output: Path) -> None:
    """Build the site in a folder, which must not exist. Raises an error for any warning of Sphinx."""
    with TemporaryDirectory() as folder:
        source = Path(folder)
        pages = {page.relative_to(PROJECT) for page in [*PROJECT.glob("*.md"), *PROJECT.glob("docs/**/*.md")]}
        shown = exhibits()
        for page in pages:
            text = (PROJECT / page).read_text("utf-8")
            _copy_linked(text, page.parent, source)
            if page.name == "gallery.md":
                text = _with_exhibits(text, shown)
            text = _with_settings(_with_videos(text), page)
            target = source / ("index.md" if page == Path("README.md") else page)
            target.parent.mkdir(parents=True, exist_ok=True)
            if page == Path("README.md"):
                text = _with_menu(text, pages - {page})
            target.write_text(text.replace("(../README.md", "(../index.md").replace("(README.md", "(index.md"), "utf-8")
        (source / "api").mkdir()
        for module, text in api.pages().items():
            (source / "api" / f"{module}.md").write_text(text, "utf-8")
        (source / "_static").mkdir()
        (source / "_static" / "site.css").write_text(CSS, "utf-8")
        trees = Path(folder) / "trees"
        strict = {"warningiserror": True, "exception_on_warning": True}
        Sphinx(source, None, output, trees, "html", confoverrides=SETTINGS, status=None, **strict).build()
    for page in output.rglob("*.html"):
        text = page.read_text("utf-8")
        for faulty, mended in MENDED.items():
            text = text.replace(faulty, mended)
        page.write_text(text, "utf-8")
    _add_exhibits(output, shown)
    demo(output / "live.html", progress=False)
    (output / ".nojekyll").touch()  # GitHub would leave out folders whose name begins with _


def _copy_linked(text: str, folder: Path, source: Path) -> None:
    """Copy the files to which a page's links lead. Pages are written by themselves, and a WebP file becomes a movie."""
    for _, _, target, _ in LINK.findall(text):
        path = (PROJECT / folder / unquote(target)).resolve()
        if path.suffix == ".md" or "://" in target:
            continue
        copy = source / path.relative_to(PROJECT)
        copy.parent.mkdir(parents=True, exist_ok=True)
        if path.suffix != ".webp":
            shutil.copyfile(path, copy)


def _with_videos(text: str) -> str:
    """Return the text with movies in place of WebP files: a reader can stop them, or prevent that they begin."""
    play = "matchMedia('(prefers-reduced-motion: reduce)').matches || play()"

    def video(found: re.Match[str]) -> str:
        _, alt, target, _ = found.groups()
        file = Path(target).with_suffix(".mp4")
        attributes = f'controls loop muted playsinline oncanplay="{play}" aria-label="{escape(alt)}"'
        return f'<video src="{file.as_posix()}" {attributes}></video>'

    return re.sub(LINK, lambda found: video(found) if found[3].endswith(".webp") else found[0], text)


def _with_settings(text: str, page: Path) -> str:
    """Return a page's text with links to the live page in place of its settings."""
    live = "../" * (len(page.parts) - 1) + "live.html"
    return SETTING.sub(lambda found: f'<a href="{live}{escape(found[2])}">{escape(found[1])}</a>', text)


def _with_menu(text: str, pages: set[Path]) -> str:
    """Return the README with a link to the live page, and with the menu of all other pages."""
    text = text.replace("## Show it\n", '## Show it\n\n**<a href="live.html">Open the live page</a>.**\n', 1)
    listed = {name for names in CONTENTS.values() for name in names}
    more = sorted({page.with_suffix("").as_posix() for page in pages} - listed)
    parts = {**CONTENTS, **({"More": more} if more else {})}
    parts["The Python interface"] = [f"api/{module}" for module in api.pages()]
    for title, names in parts.items():
        text += f"\n```{{toctree}}\n:hidden:\n:caption: {title}\n\n" + "\n".join(names) + "\n```\n"
    return text


def _with_exhibits(text: str, shown: dict[str, Exhibit]) -> str:
    """Return the gallery with each picture's command, and links to its .pov file and to where it can be moved."""
    missing = set(shown)

    def linked(found: re.Match[str]) -> str:
        name = Path(found[2]).stem
        missing.remove(name)
        live = f"../live.html#{escape(shown[name].address)}" if shown[name].address else f"gallery/{name}.html"
        links = f'<a href="{live}">move it: {name}</a> · <a href="gallery/{name}.pov">{name}.pov</a>'
        command = "" if found[3] else f"`povgen {shlex.join(shown[name].words)}`\n\n"
        return f"{found[0]}\n\n{command}{links}\n"

    # a picture, and the paragraph below it
    text = re.sub(r"(!\[[^][]*\]\(([^)]+)\))(\n\n`povgen .+(?:\n.+)*)?", linked, text)
    assert not missing, missing
    return text


def _add_exhibits(output: Path, shown: dict[str, Exhibit]) -> None:
    gallery = output / "docs" / "gallery"
    gallery.mkdir(exist_ok=True)
    for name, exhibit in shown.items():
        (gallery / f"{name}.pov").write_text(exhibit.pov(f"{name}.pov"), "utf-8")
        if not exhibit.address:
            (gallery / f"{name}.html").write_text(exhibit.view(), "utf-8")
    for webp in (PROJECT / "docs").rglob("*.webp"):
        movie = (output / webp.relative_to(PROJECT)).with_suffix(".mp4")
        frames = (frame[..., :3] for frame in iio.imiter(webp, plugin="pillow"))  # without alpha
        encode.encode(frames, movie, RATE)


def main(output: Path) -> None:
    if output.exists():
        sys.exit(f"folder = {str(output)!r}: it exists; allowed: a new folder")
    build(output)


if __name__ == "__main__":
    main(Path(sys.argv[1]))
