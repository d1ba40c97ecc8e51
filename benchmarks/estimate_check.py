"""How far `--dry-run` is from what commands take: `python benchmarks/estimate_check.py [SEED] [COUNT]`.

It draws commands at random, asks `--dry-run` for each, and runs it with an empty cache. It prints both CPU seconds and
their ratio, and last how many ratios are within 1.5.
"""

import os
import random
import re
import subprocess
import sys
import tempfile
from pathlib import Path
from resource import RUSAGE_CHILDREN, getrusage

from povgen.sheets import SHEETS

WITHIN = 1.5


def command(draw: random.Random) -> list[str]:
    """Return a command that takes at most some minutes."""
    scene = draw.choice(("chess", "chess", "spheres"))
    sheet = draw.choice((*SHEETS, "detailed", "detailed", "ideal"))
    words = ["--sheet", sheet, "--alpha", str(draw.randint(1, 179))]
    words += ["--law", "x - 0.3*X*z, y, z"] if sheet == "law" else []
    words += ["--renderer", "gl"] if draw.random() < 0.3 else ["--fresnel"] if draw.random() < 0.3 else []
    words += ["--antialias", draw.choice(("1,0.3,2", "2x", "off"))] if draw.random() < 0.3 else []
    if draw.random() < 0.3:
        return ["movie", scene, "--sweep", "z2=3:9", "--frames", "6", "--quality", "draft", *words]
    words += ["--z2", f"{draw.uniform(2, 20):.1f}"]
    quality = "standard" if "--fresnel" in words else draw.choice(("draft", "standard", "high"))
    return ["frame", scene, "--quality", quality, *words]


def run(words: list[str], folder: str) -> tuple[float, str]:
    """Return the CPU seconds of a command with an empty cache, and what it prints."""
    usage = getrusage(RUSAGE_CHILDREN)
    povgen = str(Path(sys.executable).with_name("povgen"))
    environment = {**os.environ, "POVGEN_CACHE": tempfile.mkdtemp(dir=folder)}
    done = subprocess.run([povgen, *words], cwd=folder, env=environment, capture_output=True, text=True, check=True)
    after = getrusage(RUSAGE_CHILDREN)
    return after.ru_utime + after.ru_stime - usage.ru_utime - usage.ru_stime, done.stdout


def main() -> None:
    seed, count = (int(word) for word in (*sys.argv[1:], *("1", "20")[len(sys.argv) - 1 :]))
    draw, near = random.Random(seed), 0
    for _ in range(count):
        words = command(draw)
        with tempfile.TemporaryDirectory() as folder:
            _, said = run([*words, "--dry-run"], folder)
            taken, _ = run([*words, "-o", "made.png" if words[0] == "frame" else "made.mp4"], folder)
        frames = int(re.match(r"(?:a|\d+)", said)[0].replace("a", "1"))
        told = frames * float(re.search(r"about ([0-9.]+) CPU", said)[1])
        near += 1 / WITHIN < taken / told < WITHIN
        print(f"{told:7.2f} {taken:7.2f} {taken / told:5.2f}  {' '.join(words)}", flush=True)
    print(f"{near} of {count} within {WITHIN}")


if __name__ == "__main__":
    main()
