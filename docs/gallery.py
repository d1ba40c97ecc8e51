"""Write docs/gallery.md, from docs/gallery/ and movies/: `python docs/gallery.py`."""

import tomllib
from pathlib import Path
from textwrap import wrap

PROJECT = Path(__file__).parents[1]
PAGE = PROJECT / "docs" / "gallery.md"
WIDTH = 125  # characters of a line
HEAD = """# Gallery

Add `-o FILE` to the commands.
"""
# the last sections: what `make figures` renders, and the movies
TAIL = """
## Frames of the paper's figures

![Figure 3: a chess piece at six angles α](figures/figure3.png)
![Figure 4: a chess piece at six distances](figures/figure4.png)
![Figure 6: spheres at six angles α](figures/figure6.png)

`make figures` renders them. [Their captions](figures/README.md) give the measured rotations and magnifications.

## Movies

|command|what the movie shows|
|---|---|
"""


def pictures() -> dict[str, dict[str, str]]:
    """Return what the files say, in their order, by the pictures' names."""
    files = {
        path.stem: tomllib.loads(path.read_text("utf-8")) for path in (PROJECT / "docs" / "gallery").glob("*.toml")
    }
    return dict(sorted(files.items(), key=lambda item: item[1]["order"]))


def movies() -> str:
    """Return the rows of the table of movies, with their titles."""
    files = sorted((PROJECT / "movies").glob("*.toml"))
    titles = {file.stem: tomllib.loads(file.read_text("utf-8"))["title"] for file in files}
    return "".join(f"|`povgen movie {name}`|{title}|\n" for name, title in titles.items())


def page() -> str:
    """Return the text of the page."""
    text, section = HEAD, ""
    for each in pictures().values():
        text += f"\n## {each['section']}\n" * (each["section"] != section)
        shows = "\n".join(wrap(each["shows"].strip(), WIDTH, break_long_words=False, break_on_hyphens=False))
        text += f"\n![{each['alt']}](gallery/{each['file']})\n\n{shows}\n"
        section = each["section"]
    return text + TAIL + movies()


if __name__ == "__main__":
    PAGE.write_text(page(), "utf-8")
