"""Make a page's pictures with the code on the page: `python docs/pictures.py docs/rays.md -o docs/rays`.

They have the style of povgen's charts.
"""

import os
import re
import sys
from pathlib import Path

import matplotlib

from povgen.measure.plotting import style

if __name__ == "__main__":
    page, _, folder = sys.argv[1:]
    code = "".join(re.findall(r"^```python\n(.*?)^```", Path(page).read_text("utf-8"), re.M | re.S))
    matplotlib.use("agg")
    os.chdir(folder)
    with style():
        exec(compile(code, page, "exec"))
