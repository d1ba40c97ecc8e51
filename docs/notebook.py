"""Make a Jupyter notebook of the seminar: `python docs/notebook.py` writes docs/seminar.ipynb from docs/seminar.md."""

import re
from pathlib import Path

import jupytext
import nbformat

SEMINAR = Path(__file__).with_name("seminar.md")
KERNEL = {"name": "python3", "display_name": "Python 3", "language": "python"}
SHOW = {
    "png": "Image(",
    "mp4": "Video(",
    "html": "IFrame(width=1200, height=760, src=",
}  # IPython's class for each kind


def notebook(text: str) -> nbformat.NotebookNode:
    """Return a notebook with a cell for each block of code, and a cell that shows the files that a block wrote.

    A hidden answer would end where its cell ends. Therefore all answers are at the end.
    """
    text, answers = _without_answers(text)
    text = f"{text}\n## Answers\n\n{answers}"
    text = re.sub(r"^```bash\n.*?^```\n", lambda block: block[0] + _show(block[0]), text, flags=re.M | re.S)
    made = jupytext.reads(text, "md")
    made.metadata = {"kernelspec": KERNEL}
    for n, cell in enumerate(made.cells):
        cell.id = f"cell-{n}"  # jupytext's are random
    return made


def _without_answers(text: str) -> tuple[str, str]:
    """Return the text with a reference in place of each answer, and the answers with the section of their question."""
    answers: list[str] = []

    def moved(answer: re.Match[str]) -> str:
        section = re.findall(r"^## (.*)$", text[: answer.start()], re.M)[-1]
        answers.append(f"**Answer {len(answers) + 1}** ({section}).{answer[1]}")
        return f"(Answer {len(answers)} is at the end of this notebook.)\n"

    rest = re.sub(r"<details><summary>Answer</summary>(.*?)\n*</details>\n", moved, text, flags=re.DOTALL)
    return rest, "\n\n".join(answers) + "\n"


def _show(commands: str) -> str:
    files = re.findall(r"-o (\S+\.(\w+))", commands)
    shown = ", ".join(f'{SHOW[kind]}"{name}")' for name, kind in files)
    return f"\n```python\nfrom IPython.display import IFrame, Image, Video, display\n\ndisplay({shown})\n```\n"


if __name__ == "__main__":
    nbformat.write(notebook(SEMINAR.read_text("utf-8")), SEMINAR.with_suffix(".ipynb"))
