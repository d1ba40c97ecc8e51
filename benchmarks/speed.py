"""The figures of speed in the README: CPU seconds of frames, in turn, medians, and their ratios.

Run it with `make bench`. It compares a detailed frame with the same prisms written as a union of bounded CSG
intersections (intersections.inc), and an ideal frame with the empty scene, at 640x480 without antialiasing.
"""

import os
import platform
import tempfile
from pathlib import Path
from resource import RUSAGE_CHILDREN, getrusage
from statistics import median

from povgen import Chess, Rendering, povray, to_pov

RENDERING = Rendering(size=(640, 480), antialias="off")
HAND_WRITTEN = Path(__file__).with_name("intersections.inc").read_text()


def by_hand(text: str) -> str:
    """A scene's text with its sheets as a union of intersections."""
    start, end = text.index("#macro Sheet("), text.index("Sheet(0, (Length")
    return text[:start] + HAND_WRITTEN + text[end:]


def cpu_seconds(text: str) -> float:
    """What the finished POV-Ray process used, by the operating system's account."""
    with tempfile.TemporaryDirectory() as folder:
        before = getrusage(RUSAGE_CHILDREN)
        povray.run(text, RENDERING, Path(folder))
        after = getrusage(RUSAGE_CHILDREN)
    return after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime


def main() -> None:
    detailed = to_pov(Chess())
    pairs = (
        ("detailed, 2x100 prisms", detailed, "union of bounded intersections", by_hand(detailed), 5),
        ("ideal", to_pov(Chess(sheet="ideal")), "no sheet", to_pov(Chess(sheet="none")), 25),
    )
    print(f"{platform.machine()}, {os.cpu_count()} cores, POV-Ray {povray.version()}; medians, in turn")
    for name, text, peer, other, rounds in pairs:
        times = [(cpu_seconds(text), cpu_seconds(other)) for _ in range(rounds)]
        ours, theirs = (median(column) for column in zip(*times, strict=True))
        ratio = median(a / b for a, b in times)
        print(f"{name}: {ours:.2f} CPU s; {peer}: {theirs:.2f} CPU s; ratio {ratio:.2f} ({rounds} rounds)")


if __name__ == "__main__":
    main()
