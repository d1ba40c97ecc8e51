"""The lesson, its worksheet and the seminar: settings show what the text says, and each number is computed again."""

import re
from urllib.parse import parse_qsl

import numpy as np
import pytest
import website
from conftest import PROJECT

from povgen import Chess
from povgen.inputs.pieces import PIECES
from povgen.optics import equations
from povgen.optics.prism import Prism
from povgen.page import items

LESSON, WORKSHEET, SEMINAR = (
    (PROJECT / "docs" / f"{name}.md").read_text() for name in ("lesson", "worksheet", "seminar")
)
EYE = 6  # z2
TABLE = r"(?m)(?:^\|.*\n)+"
# What the page says with a setting: its sentence and the shares of light. With a question: all that it says at its end.
SAYS = """(hash) => {
  fromHash(hash);
  const question = QUESTIONS[state.question];
  if (!question) return [explanation(moment()), moment().glass ? povgen.phrases.lightShares(moment()) : ""].join(" ");
  const answer = question.answer();
  return [ask(question), choices(question)?.[answer] ?? answer, why(question)].join(" ");
}"""


def settings(text):
    """Return the words of each setting of a text, its address after `#`, and what follows it in its paragraph."""
    found = [*website.SETTING.finditer(text)]
    ends = [*(each.start() for each in found[1:]), len(text)]
    after = [text[each.end() : end] for each, end in zip(found, ends, strict=True)]
    after = [re.split(r"\n\n|\n- |\n\|", part)[0] for part in after]
    return [
        (" ".join(each[1].split()), each[2].partition("#")[2], part) for each, part in zip(found, after, strict=True)
    ]


def tables(text):
    """Return each table of a text: a list of rows, without the line below the first one."""
    rows = [[re.findall(r"[^|]+(?=\|)", line) for line in table.splitlines()] for table in re.findall(TABLE, text)]
    return [[[cell.strip() for cell in row] for k, row in enumerate(table) if k != 1] for table in rows]


@pytest.mark.parametrize("text", [LESSON, WORKSHEET, SEMINAR], ids=["lesson", "worksheet", "seminar"])
def test_the_page_takes_every_setting(text, node):
    assert len(settings(text)) >= 2
    for words, address, _ in settings(text):
        state, refusals, asked = node.evaluate(
            """(hash) => {
              fromHash(hash);
              const question = QUESTIONS[state.question];
              const view = Object.keys(CAMERAS).find((name) => CAMERAS[name] === session.camera);
              return [{ ...state, view }, session.refusals, question && [question.name, ask(question)]];
            }""",
            f"#{address}",
        )
        assert not refusals, address
        for name, value in parse_qsl(address, strict_parsing=bool(address)):
            if name == "question":
                assert asked[0] == value and words.strip('"') in asked[1]
            elif name == "show":
                assert all(state[each] for each in value.split(","))
            else:
                assert f"{state[name]:g}" == value if isinstance(state[name], (int, float)) else state[name] == value


def test_the_pages_lesson_asks_before_it_shows():
    """As this text does, in the same steps. Each step has the same questions and settings, in the same order."""
    lesson = next(each for each in items.load([], PIECES) if each.name == "lesson")
    for title, step in zip(lesson.words["en"]["steps"], lesson.data["steps"], strict=True):
        [section] = re.findall(rf"(?ms)^## {title}\n.*?(?=^## )", LESSON)
        found = [address.removesuffix("&piece=king") for _, address, _ in settings(section)]
        wanted = [*(f"question={name}" for name in step["asks"]), *step["shows"]]
        assert found[: len(step["asks"])] == wanted[: len(step["asks"])]
        places = [found.index(address) for address in wanted]
        assert places == sorted(places), title


def numbers(text):
    return re.findall(r"\d[\d.]*(?=°| %| times| tiles| of (?:your|it))", text)


def test_the_page_says_the_numbers_of_the_lesson(node):
    """Those after a setting, in its paragraph. An angle may also be that of the sheets, or of one to the other."""
    checked = 0
    for words, address, after in settings(LESSON):
        said = node.evaluate(SAYS, f"#{address}")
        alpha = node.evaluate("state.alpha")
        for number in numbers(" ".join([words, *after.split()])):
            known = {*re.findall(r"\d[\d.]*", said), f"{alpha:g}", f"{alpha / 2:g}", f"{node.evaluate('state.prisms')}"}
            assert number in {each.rstrip(".") for each in known}, (words, number, said)
            checked += 1
    assert checked > 25


def turned(z1, alpha=90):
    """Return nu in degrees, and the size in comparison with no sheets, of what is at z1."""
    nu, M = (f(EYE / z1, np.radians(alpha)) for f in (equations.nu, equations.M))
    return np.degrees(nu), M / equations.M(EYE / z1, 0.0)


def twice(angle):
    """Return by how many degrees two mirrorings turn, at this angle to each other."""
    before = np.array([0.1, 0.2, -1.0])
    after = equations.mirror(equations.mirror(before, 0.0), np.radians(angle))
    return np.degrees(np.angle(complex(*after[:2]) / complex(*before[:2]))) % 360


def in_air(z1, z2, step):
    """Return where the image at 180 degrees is, its size, and how far the eye's step moves it to the right."""
    imaged, size = (equations.M(z2 / z1, a) for a in (np.pi, 0.0))
    distance = z2 - z2 / imaged  # from the sheets; it is as large as the object
    moved = equations.apparent_position(0, step, z1, z2, np.pi) - equations.apparent_position(0, 0, z1, z2, np.pi)
    return distance, imaged / size, moved.real


def test_the_numbers_of_the_experiments():
    text = LESSON[LESSON.index("## Experiment 1") :]
    prism, mirrors, lamp = tables(text)
    for angle, image in prism[1:]:
        assert float(image[:-1]) == pytest.approx(twice(float(angle[:-1])) or 360)
    for angle, image, count in mirrors[1:]:
        assert float(image[:-1]) == pytest.approx(twice(float(angle[:-1])))
        assert int(count) == 360 / float(angle[:-1]) - 1
    step = float(re.search(r"head moves (\d+) cm to the right", lamp[0][-1])[1])
    for row in lamp[1:]:
        behind, before, image, size, moved = (float(re.match(r"[\d.]+", cell)[0]) for cell in row)
        distance, times, shift = in_air(behind, before, step)
        assert [image, size, -moved] == pytest.approx([distance, times, shift], abs=1e-9)
        assert row[-1].endswith("to the left")
    free = equations.apparent_position(0, step, 20, 60, 0.0).real
    acrylic = Prism(pitch=1.0, index=1.49)
    said = [
        f"acrylic prism (n = 1.49) whose slanted ends are at 45° must be {acrylic.full_aperture:.2f} times as long",
        f"only in the lower {acrylic.least_aspect:.0%}".replace("%", " %"),
        f"the lamp at 20 cm would go {free:.1f} cm to the right",
        f"(f-number 3), most light within {np.degrees(np.arctan(1.5 / (4 * 3))):.1f}° of the perpendicular",
        f"a shift by a quarter of a ridge moves the picture by {np.degrees(np.arctan(1.5 / (4 * 3))):.1f}°",
    ]
    rest = " ".join(re.sub(TABLE, "", LESSON).split())
    for sentence in said:
        assert sentence in rest
    # all other numbers with a decimal point follow a setting, or are in a table
    for part in [*said, *(" ".join(after.split()) for _, _, after in settings(LESSON))]:
        rest = rest.replace(part, "") if part else rest
    assert not re.findall(r"\d\.\d", website.SETTING.sub("", rest))


def test_the_predictions_are_questions_of_the_page(node):
    """In part 1 of the worksheet: their words, their choices, and the right ones."""
    task, answers = WORKSHEET.split("## Answers")
    right = re.search(r"\*\*1\.\*\* (.*)\.\n", answers)[1].split("; ")
    items = re.findall(r"(?m)^\d\. (.*)\n\n +☐ (.*)$", task)
    assert len(items) == len(right) == 4
    for (asked, offered), answer, name in zip(items, right, ("sky", "near", "parallax", "far"), strict=True):
        question, wanted, k = node.evaluate(
            """(name) => {
              const question = QUESTIONS.find((each) => each.name === name);
              return [ask(question), choices(question), question.answer()];
            }""",
            name,
        )
        assert asked == question and offered.split(" &emsp; ☐ ") == wanted
        assert answer.lower().startswith(wanted[k])
    assert right[1].endswith(f"by {turned(2, 66)[0]:.1f}°")


def test_the_answers_of_the_worksheet(node):
    task, answers = (tables(part) for part in WORKSHEET.split("## Answers"))
    mirrors, air, _, paper, page = task
    for empty, filled in zip((mirrors, air, page), (*answers[:2], answers[3]), strict=True):
        assert [row[0] for row in empty] == [row[0] for row in filled] and empty[0] == filled[0]
        assert not any(cell for row in empty[1:] for cell in row[1:])  # what students fill in
    assert {row[0] for row in answers[2]} < {row[0] for row in paper}
    for angle, image in list(zip(*answers[0], strict=True))[1:]:
        assert float(image[:-1]) == pytest.approx(twice(float(angle[:-1])))
    for z1, *given in list(zip(*answers[3], strict=True))[1:]:
        nu, size = turned(float(z1))
        assert given == [f"{nu:.1f}°", *(f"{x:.2f}" for x in (size, float(z1) / EYE, np.tan(np.radians(nu))))]
        said = node.evaluate(SAYS, f"#sheet=ideal&alpha=90&z2={EYE}&z1={z1}")
        assert f"turned by {given[0]} " in said and f" {given[1]} times" in said
    for z1, size, floats in list(zip(*answers[1], strict=True))[1:]:
        said = node.evaluate(SAYS, f"#sheet=ideal&alpha=180&z2={EYE}&z1={z1}")
        assert f" {size} times" in said and f"floats {floats} tile" in said
    inside = [value for table in answers for row in table for value in row]
    prose = [f"{turned(2, 66)[0]:.1f}", "0.2"]  # 0.2: how well one measures
    assert {*re.findall(r"\d+\.\d+", WORKSHEET.split("## Answers")[1])} <= {*prose, *(v.rstrip("°") for v in inside)}


def test_the_pictures_of_the_worksheet(node):
    """They show what stands below them, and the answers are those of what they show."""
    pictures, captions = next(table for table in tables(WORKSHEET) if "![" in table[1][0])[1:]
    kings = []
    for picture, caption in zip(pictures, captions, strict=True):
        scene = Chess.from_file(PROJECT / "docs" / re.search(r"\((\S+)\)", picture)[1])
        sheets = "no sheets" if scene.sheet == "none" else f"α = {scene.alpha:g}°"
        assert caption[3:] == f"{sheets}, z₁ = {scene.z1:g}" and scene.z2 == EYE and scene.piece == "king"
        alpha = 0 if scene.sheet == "none" else np.radians(scene.alpha)
        kings.append([f(EYE / scene.z1, alpha) for f in (equations.nu, equations.M)])
    answer = tables(WORKSHEET.split("## Answers")[1])[2]
    assert answer[1][1:] == ["0°", *(f"{np.degrees(nu):.1f}°" for nu, _ in kings[1:])]
    assert answer[2][1:] == ["1", *(f"{M / kings[0][1]:.2f}" for _, M in kings[1:])]
