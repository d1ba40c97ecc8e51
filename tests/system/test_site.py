"""The site: `make site`. Its links lead somewhere, it needs no network and no server, and can be read by everybody."""

import re
from html.parser import HTMLParser
from pathlib import Path
from urllib.parse import unquote, urlsplit

import api
import exhibits
import pytest
import website
from axe_playwright_python.sync_playwright import Axe
from conftest import NAMES, PROJECT

import povgen
from povgen.measure.browser import chromium

pytestmark = pytest.mark.release  # to make the site takes a minute
AA = {"runOnly": ["wcag2a", "wcag2aa", "wcag21a", "wcag21aa", "wcag22aa"], "resultTypes": ["violations"]}


@pytest.fixture(scope="module")
def site(tmp_path_factory):
    """The site, in a folder whose name has to be quoted in a URL."""
    folder = tmp_path_factory.mktemp("site") / "a site"
    website.build(folder)
    return folder


@pytest.fixture(scope="module")
def page(site):
    """A page in a Chromium. Whatever it asks for must lie in the site."""
    with chromium() as browser:
        opened = browser.new_page(viewport={"width": 1100, "height": 700})
        asked, faults = [], []
        opened.on("request", lambda request: asked.append(request.url))
        opened.on("pageerror", lambda error: faults.append(str(error)))
        # axe asks for style sheets by scripts, which a page from a file may not; a movie is not loaded to its end
        opened.on("requestfailed", lambda one: one.resource_type in ("xhr", "media") or faults.append(one.url))
        yield opened
        assert not faults and not [url for url in asked if not url.startswith((site.as_uri(), "data:", "blob:"))]


def test_a_folder_that_exists_is_kept(tmp_path):
    (tmp_path / "mine.txt").write_text("mine")
    with pytest.raises(SystemExit, match="it exists; allowed: a new folder"):
        website.main(tmp_path)
    assert (tmp_path / "mine.txt").read_text() == "mine"


class Read(HTMLParser):
    """A page's links, its anchors, and what it loads."""

    def __init__(self, path):
        super().__init__()
        self.links, self.loaded, self.anchors = set(), set(), set()
        self.feed(path.read_text("utf-8"))

    def handle_starttag(self, tag, attributes):
        found = dict(attributes)
        self.anchors |= {found[name] for name in ("id", "name") if found.get(name)}
        where = found.get("href") or found.get("src")
        if where and not where.startswith("data:"):
            (self.links if tag == "a" else self.loaded).add(where)


@pytest.fixture(scope="module")
def read(site):
    return {path: Read(path) for path in site.rglob("*.html")}


def test_every_link_leads_somewhere(site, read):
    for path, page in read.items():
        for link in page.links | page.loaded:
            parts = urlsplit(link)
            if parts.scheme:
                assert link in page.links and parts.scheme == "https", f"{path}: {link}"
                continue
            target = (path.parent / unquote(parts.path)).resolve() if parts.path else path
            assert target.is_relative_to(site) and target.is_file(), f"{path}: {link}"
            if parts.fragment and target.name != "live.html":
                assert unquote(parts.fragment) in read[target].anchors, f"{path}: {link}"


def test_every_page_is_in_the_menu(site, read):
    menu = {unquote(urlsplit(link).path) for link in read[site / "index.html"].links}
    pages = {path.relative_to(site).as_posix() for path in read}
    assert pages - menu <= {
        "index.html",
        "search.html",
        "genindex.html",
        *(f"docs/gallery/{name}.html" for name in OWN),
    }
    assert {f"api/{name}.html" for name in api.pages()} <= menu


SHOWN = exhibits.exhibits()
OWN = {name for name, exhibit in SHOWN.items() if not exhibit.address}


def test_every_picture_of_the_gallery_has_its_text_and_can_be_moved(site, read):
    pictures = re.findall(r"!\[[^]]*\]\((\S+)\)", (PROJECT / "docs/gallery.md").read_text())
    assert set(SHOWN) == {Path(link).stem for link in pictures}
    assert {"pieces", "black-tops", "rotation", "lenticular"} == OWN  # the page cannot show them
    links = read[site / "docs" / "gallery.html"].links
    for name, exhibit in SHOWN.items():
        assert f"gallery/{name}.pov" in links
        assert (f"../live.html#{exhibit.address}" if exhibit.address else f"gallery/{name}.html") in links
        text = (site / "docs" / "gallery" / f"{name}.pov").read_text()
        assert "#version 3.7" in text and f"{name}.pov" in text


def test_the_live_page_shows_the_scenes_of_the_gallery(site, page):
    """It takes every value of each address."""
    page.goto((site / "live.html").as_uri())
    page.evaluate(NAMES)
    for name, exhibit in SHOWN.items():
        if not exhibit.address:
            continue
        refusals = page.evaluate("hash => { fromHash(hash); return session.refusals; }", f"#{exhibit.address}")
        assert not refusals, f"{name}: {refusals}"


def test_the_search_works_without_a_server(site, page):
    page.goto(f"{(site / 'search.html').as_uri()}?q=Landlock")
    page.wait_for_selector("#search-results li a")
    found = page.locator("#search-results li a").all_inner_texts()
    assert "Using povgen" in found


@pytest.mark.parametrize(
    "name", ["index", "docs/gallery", "docs/lesson", "docs/worksheet", "docs/speed", "api/povgen", "search"]
)
def test_everybody_can_read_it(name, site, page):
    page.goto((site / f"{name}.html").as_uri())
    faults = Axe().run(page, options=AA).response["violations"]
    assert not faults, [(fault["id"], [node["target"] for node in fault["nodes"]][:3]) for fault in faults]


@pytest.mark.parametrize(("name", "count"), [("worksheet", 3), ("cheatsheet", 1)])
def test_what_is_to_be_printed_fits_its_pages(site, page, name, count):
    """The worksheet has two pages, and one of answers."""
    page.goto((site / "docs" / f"{name}.html").as_uri())
    printed = page.pdf(prefer_css_page_size=True)
    sizes = re.findall(rb"/Type /Page\b.*?/MediaBox \[0 0 ([\d.]+) ([\d.]+)\]", printed, re.S)
    assert [(round(float(width)), round(float(height))) for width, height in sizes] == [(595, 842)] * count  # points


def test_a_movie_plays_if_the_reader_allows_motion(site, page):
    page.goto((site / "index.html").as_uri())
    video = page.locator("video")
    assert video.get_attribute("aria-label").startswith("Moving picture")
    page.wait_for_function("document.querySelector('video').currentTime > 0.1")
    assert video.evaluate("video => [video.controls, video.duration]") == [True, 8]
    page.emulate_media(reduced_motion="reduce")
    page.reload()
    page.wait_for_function("document.querySelector('video').readyState >= 3")
    assert page.locator("video").evaluate("video => video.paused")
    page.emulate_media(reduced_motion="no-preference")


def test_the_python_interface_has_readable_types():
    pages = api.pages()
    assert all(f"\n## {name}\n" in pages["povgen"] for name in povgen.__all__)
    assert "distance from the sheets to the piece" in pages["povgen"]  # the unit and range of a parameter
    assert "eq. 7" in pages["povgen.optics.equations"]
    for text in pages.values():
        signatures = "".join(re.findall(r"^```python\n(.*?)^```", text, re.M | re.S))
        assert not re.search(r"\b(typing|numpy|povgen|collections|pathlib)\.|<|_Supports", signatures)
        assert not re.search(r"^### \w+\._|^## _", text, re.M)
