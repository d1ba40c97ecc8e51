"""`make docs`: pages about the Python interface."""

import re
import subprocess
import sys

from conftest import PROJECT

import povgen


def test_every_public_name_is_on_the_first_page(tmp_path):
    subprocess.run([sys.executable, "docs/api.py", tmp_path], cwd=PROJECT, check=True)
    page = (tmp_path / "povgen.html").read_text()
    assert set(povgen.__all__) <= set(re.findall(r'id="(\w+)"', page))
    assert "distance from the sheets to the piece" in page  # the unit and range of a parameter
    assert "eq. 7" in (tmp_path / "povgen" / "optics" / "rotation.html").read_text()
