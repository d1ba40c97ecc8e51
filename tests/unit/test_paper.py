"""The short paper says what the documentation says, and cites what its bibliography holds."""

import re

from conftest import PROJECT

PAPER = (PROJECT / "paper" / "paper.md").read_text()


def test_measured_values_are_those_of_the_documentation():
    accuracy, speed = ((PROJECT / "docs" / f"{name}.md").read_text() for name in ("accuracy", "speed"))
    paper = " ".join(PAPER.split())

    def value(row):
        (found,) = re.findall(rf"^\|[^|]*\| {re.escape(row)} \| ([\d.]+)", accuracy, re.M)
        return float(found)

    (error,) = re.findall(r"within ([\d.]+) pixels of equation 7", paper)
    assert float(error) == round(value("apparent position against eq. 7, 60 scenes, worst"), 3)
    pixels = [float(text) for text in re.findall(r"([\d.]+) % of (?:all|the) pixels", paper)]
    rays = "of the pixels whose ray leaves, those that agree"
    assert pixels == [value(f"2x100, 4 alphas: {rays}"), value(f"2 windows of 2x100, 4 scenes: {rays}")]
    assert value("2x100, 4 alphas: pixels on the designed path that agree") == 100
    (fraction,) = re.findall(r"^\| 8° to 150° \| [\d.]+ px \| ([\d.]+)", accuracy, re.M)
    assert f"about {100 * float(fraction):.0f} % of the error of the paper's equation 7" in paper
    (minutes, seconds) = re.search(r"`gl`, two cores, no graphics processor \| (\d+) min (\d+) s", speed).groups()
    assert f"takes {minutes} minutes {seconds} seconds" in paper


def test_everything_cited_is_in_the_bibliography():
    known = set(re.findall(r"^@\w+\{(\w+),", (PROJECT / "paper" / "paper.bib").read_text(), re.M))
    assert set(re.findall(r"@(\w+)", PAPER)) == known
    assert len(PAPER.split()) < 1000  # as the journal asks
