"""The lesson as a Jupyter notebook: `python docs/notebook.py` writes docs/lesson.ipynb from docs/lesson.md."""

import re
from pathlib import Path

import nbformat
from nbformat.v4 import new_code_cell, new_markdown_cell, new_notebook

LESSON = Path(__file__).with_name("lesson.md")
SHOW = {"png": "Image", "mp4": "Video"}


def notebook(text: str) -> nbformat.NotebookNode:
    """Each block of code as a cell; after shell commands a cell that shows the pictures and movies that they wrote."""
    cells = []
    for n, part in enumerate(re.split(r"^(```\w+\n.*?^```\n)", text, flags=re.M | re.S)):
        kind, code = n % 2, re.sub(r"^```\w+\n|^```\n", "", part, flags=re.M).strip()
        if not kind:
            cells.append(new_markdown_cell(_unfolded(part)))
        elif part.startswith("```bash"):
            cells.append(new_code_cell(f"%%bash\n{code}"))
            written = re.findall(r"-o (\S+\.(\w+))", code)
            shown = ", ".join(f'{SHOW[kind]}("{name}")' for name, kind in written)
            cells.append(new_code_cell(f"from IPython.display import Image, Video, display\n\ndisplay({shown})"))
        else:
            cells.append(new_code_cell(code))
    for n, cell in enumerate(cells):
        cell.id = f"cell-{n}"
    kernel = {"kernelspec": {"name": "python3", "display_name": "Python 3", "language": "python"}}
    return new_notebook(cells=[cell for cell in cells if cell.source], metadata=kernel)


def _unfolded(text: str) -> str:
    """Markdown without what hides an answer, which cannot reach over cells."""
    return re.sub(
        r"<details><summary>(\w+)</summary>|</details>", lambda m: f"**{m[1]}.**" if m[1] else "", text
    ).strip()


if __name__ == "__main__":
    nbformat.write(notebook(LESSON.read_text()), LESSON.with_suffix(".ipynb"))
