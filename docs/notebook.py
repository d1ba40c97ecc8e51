"""Make a Jupyter notebook of the lesson: `python docs/notebook.py` writes docs/lesson.ipynb from docs/lesson.md."""

import re
from pathlib import Path

import jupytext
import nbformat

LESSON = Path(__file__).with_name("lesson.md")
KERNEL = {"name": "python3", "display_name": "Python 3", "language": "python"}
SHOW = {"png": "Image", "mp4": "Video"}  # IPython's class for each kind of file


def notebook(text: str) -> nbformat.NotebookNode:
    """Return a notebook with a cell for each block of code, and a cell that shows the files that a block wrote."""
    text = re.sub(r"^```bash\n.*?^```\n", lambda block: block[0] + _show(block[0]), text, flags=re.M | re.S)
    # A hidden answer would end where its cell ends: show every answer.
    text = re.sub(r"<details><summary>(\w+)</summary>", r"**\1.**", text)
    text = re.sub(r"\n*</details>\n*", "\n\n", text)
    made = jupytext.reads(text, "md")
    made.metadata = {"kernelspec": KERNEL}
    for n, cell in enumerate(made.cells):
        cell.id = f"cell-{n}"  # jupytext's are random
    return made


def _show(commands: str) -> str:
    files = re.findall(r"-o (\S+\.(\w+))", commands)
    shown = ", ".join(f'{SHOW[kind]}("{name}")' for name, kind in files)
    return f"\n```python\nfrom IPython.display import Image, Video, display\n\ndisplay({shown})\n```\n"


if __name__ == "__main__":
    nbformat.write(notebook(LESSON.read_text()), LESSON.with_suffix(".ipynb"))
