"""What the teaching page has for a lesson: questions, challenges, guided tours and lessons. Each is a TOML file.

povgen's own are in questions/, tours/ and lessons/; a teacher can add more (docs/adding.md). Each file has sentences in
one or more languages. Where a language is missing, English is in its place, or else the first language of the file.
"""

import re
from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any, Literal

from pydantic import Field

from povgen.errors import InputError, shown
from povgen.liveview import languages
from povgen.page.address import ALL_KINDS, RANGES, settings
from povgen.scene.files import table_of, text_of
from povgen.validation import Model

OWN = sorted(
    path for name in ("questions", "tours", "lessons") for path in Path(__file__).parent.glob(f"{name}/*.toml")
)
LANGUAGES = sorted(path.stem for path in languages.FOLDER.glob("*.toml"))
# what a question can ask for, and its sentences can state: povgen/page/questions.js computes it
QUANTITIES = ["nu", "far", "M", "size", "image", "shift", "height", "reach", "field", "slope"]
NUMBERS = [name for name in RANGES if name not in ("axis", "focus")]  # settings that are numbers
MOMENTS = ["start", "end", "change", "ratio", "free_start", "free_end"]
Pair = tuple[float, float]
Positive = Annotated[float, Field(gt=0)]
Texts = tuple[str, ...]


class Question(Model):
    """A question, or a challenge, which has a goal in place of an answer."""

    start: str = Field(default="", description="the settings of the page with the question, as in the page's address")
    end: str = Field(default="", description="the settings that are different with the answer")
    answer: int | float | str | None = Field(
        default=None, description="the number of the right choice, a number, or what the page computes, as in end.nu"
    )
    tolerance: Positive | None = Field(default=None, description="how far from the answer a number may be")
    unit: Literal["degrees", "tiles", "times"] | None = Field(default=None, description="degrees, tiles or times")
    goal: dict[str, Pair] | None = Field(default=None, description="the least and greatest value of quantities")
    match: bool = Field(default=False, description="whether the picture of `end` is to be made, by alpha and z1")
    expert: bool = Field(default=False, description="whether only experts are asked")


class QuestionWords(Model):
    """A question's sentences in one language."""

    ask: str = Field(description="the question")
    choices: Texts = Field(default=(), description="what can be chosen, 2 to 20", max_length=20)
    unit: str | None = Field(default=None, description="the unit, in words of this question")
    why: str = Field(description="why the answer is right")
    wrong: Texts = Field(default=(), description="why it is wrong: each choice, or a number too small and too large")
    formula: str | None = Field(default=None, description="what only experts read")
    says: str | None = Field(default=None, description="what is said first of the picture with the answer")


class Step(Model):
    """A step of a tour."""

    shows: str = Field(default="", description="settings, as in the page's address")
    moves: dict[str, Pair] = Field(default={}, description="first and last values of settings that change")
    through: Pair | None = Field(default=None, description="the place of the window where the piece stays to be seen")
    twin: float = Field(default=0, description="where the piece stands a second time: x, tiles")
    seconds: Positive = Field(description="how long it lasts")


class Tour(Model):
    """A guided tour."""

    intro: Step | None = Field(default=None, description="a step before the first one")
    tour: tuple[Step, ...] = Field(description="the steps", min_length=1)


class TourWords(Model):
    """A tour's sentences in one language."""

    title: str = Field(description="the title")
    intro: str | None = Field(default=None, description="what is said before the first step")
    steps: Texts = Field(description="a text for each step", min_length=1)


class Part(Model):
    """A step of a lesson, or of a gallery of settings."""

    minutes: Positive | None = Field(default=None, description="how long it lasts")
    shows: Texts = Field(default=(), description="settings, each as in the page's address")
    asks: Texts = Field(default=(), description="names of questions: they come first")


class Lesson(Model):
    """A lesson, or a gallery of settings."""

    lesson: tuple[Part, ...] = Field(description="the steps", min_length=1)


class LessonWords(Model):
    """A lesson's sentences in one language."""

    title: str = Field(description="the title")
    steps: Texts = Field(description="a title for each step", min_length=1)
    names: Texts = Field(default=(), description="what a class is told of each setting that the steps show, in turn")
    believed: Texts = Field(default=(), description="what students believe at first, for each step; can be empty")


@dataclass(frozen=True)
class Item:
    """A question, a tour or a lesson: its name, what the page does, and its sentences by their languages."""

    section: str
    name: str
    data: dict[str, Any]
    words: dict[str, dict[str, Any]]


def load(added: Iterable[str | Path], pieces: Collection[str]) -> list[Item]:
    """Return povgen's own items, in the order of their files' names, and those that are added. Raises InputError."""
    found: dict[tuple[str, str], Item] = {}
    for path in [*OWN, *added]:
        text, file, _ = text_of(path, "question, tour or lesson", "a TOML file")
        try:
            name = re.sub(r"^\d+-", "", Path(path).stem)
            if not re.fullmatch(r"[\w-]+", name):
                raise InputError("the name of the file has a sign that is no letter; allowed: also digits, - and _")
            each = _item(name, table_of(text, "the file"), pieces)
            if found.setdefault((each.section, name), each) is not each:
                raise InputError(f"the page has {name!r} already; allowed: another name of the file")
        except InputError as error:
            raise InputError(f"{file}: {error}") from None
    known = [name for section, name in found if section == "questions"]
    for (section, name), item in found.items():
        for step in item.data["steps"] if section == "lessons" else ():
            _allowed(f"{name}.toml: asks", step["asks"], known)
    return [*found.values()]


def _item(name: str, table: dict[str, Any], pieces: Collection[str]) -> Item:
    words = {key: table.pop(key) for key in LANGUAGES if isinstance(table.get(key), Mapping)}
    for key, value in table.items():
        if isinstance(value, dict) and key not in ("goal", "intro"):
            raise InputError(f"[{key}]: no language of the page; allowed: {', '.join(LANGUAGES)}")
    if not words:
        raise InputError(f"no sentences; allowed: a table for a language, one of [{'], ['.join(LANGUAGES)}]")
    if "tour" in table:
        return _tour(name, table, words, pieces)
    return _lesson(name, table, words, pieces) if "lesson" in table else _question(name, table, words, pieces)


def _question(name: str, table: dict[str, Any], words: dict[str, Any], pieces: Collection[str]) -> Item:
    question = Question(**table)
    data = {key: value for key, value in question if value is not None and value is not False}
    data |= {key: settings(getattr(question, key), pieces) for key in ("start", "end")}
    if sum([question.answer is not None, question.goal is not None, question.match]) != 1:
        raise InputError("no answer, or more than one; allowed: one of answer, goal and match")
    if question.match and not {"alpha", "z1"} <= data["end"].keys():
        raise InputError(f"end = {shown(question.end)}: no picture to match; allowed: with alpha and z1")
    texts = _words(QuestionWords, words)
    counts = {len(text.get("choices", ())) for text in texts.values()}
    if len(counts) > 1 or counts == {1}:
        raise InputError(f"the languages have {shown(sorted(counts))} choices; allowed: the same number, 2 to 20")
    [count] = counts
    _check_answer(question, count)
    for language, text in texts.items():
        for sentence in (each for value in text.values() for each in ([value] if isinstance(value, str) else value)):
            _allowed(f"[{language}]", [x for x in re.findall(r"\{([^}]*)\}", sentence) if x != "turned"], _COMPUTED)
        if text.get("wrong") and len(text["wrong"]) != (count or 2):
            raise InputError(f"[{language}]: {len(text['wrong'])} reasons in `wrong`; allowed: {count or 2}")
    return Item("questions", name, data, texts)


def _check_answer(question: Question, count: int) -> None:
    answer = question.answer
    said = f"answer = {shown(answer)}"
    if question.goal is not None:
        _allowed("goal", question.goal, _VALUES)
    if isinstance(answer, str):
        _allowed(said, [answer], _COMPUTED)
        if count not in (0, 3):
            raise InputError(f"{said}: {count} choices; allowed: 3, for more, as much, and less")
    elif answer is not None and count and answer not in range(1, count + 1):
        raise InputError(f"{said}: allowed: 1 to {count}, the number of the right choice")
    if answer is not None and not count and not (question.tolerance and question.unit):
        raise InputError(f"{said}: without choices, a number is asked for; allowed: with tolerance and unit")


_VALUES = [*QUANTITIES, *NUMBERS]
_COMPUTED = [f"{moment}.{value}" for moment in MOMENTS for value in _VALUES]


def _allowed(what: str, given: Iterable[str], allowed: Collection[str]) -> None:
    for each in given:
        if each not in allowed:
            names = ", ".join(allowed) if allowed is not _COMPUTED else f"one of {MOMENTS}, a point, one of {_VALUES}"
            raise InputError(f"{what}: {shown(each)} is unknown; allowed: {names}")


def _tour(name: str, table: dict[str, Any], words: dict[str, Any], pieces: Collection[str]) -> Item:
    tour = Tour(**table)
    steps = []
    for step in (*([tour.intro] if tour.intro else []), *tour.tour):
        _allowed("moves", step.moves, NUMBERS)
        steps.append({**dict(step), "shows": settings(step.shows, pieces)})
    intro = steps.pop(0) if tour.intro else None
    texts = _words(TourWords, words, steps=len(steps))
    if tour.intro and not all("intro" in text for text in texts.values()):
        raise InputError("intro: no text for it; allowed: `intro` in each language")
    return Item("tours", name, {"intro": intro, "steps": steps}, texts)


def _lesson(name: str, table: dict[str, Any], words: dict[str, Any], pieces: Collection[str]) -> Item:
    parts = Lesson(**table).lesson
    for text in (each for part in parts for each in part.shows):
        settings(text, pieces)
    steps = [{**dict(part), "shows": [text.rpartition("#")[2] for text in part.shows]} for part in parts]
    counts = {"steps": len(parts), "believed": len(parts), "names": sum(len(part.shows) for part in parts)}
    return Item("lessons", name, {"steps": steps}, _words(LessonWords, words, **counts))


def _words(model: type[Model], words: Mapping[str, dict[str, Any]], **counts: int) -> dict[str, dict[str, Any]]:
    """Return the sentences that each language states. `counts`: how many a list has, if there is one."""
    found = {}
    for language, table in words.items():
        try:
            text = {key: [*value] if isinstance(value, tuple) else value for key, value in model(**table) if value}
            for key, count in counts.items():
                if key in text and len(text[key]) != count:
                    one = "setting" if key == "names" else "step"
                    raise InputError(f"{key}: {len(text[key])} texts; allowed: {count}, one for each {one}")
        except InputError as error:
            raise InputError(f"[{language}]: {error}") from None
        found[language] = text
    return found


def tables(found: Sequence[Item]) -> dict[str, dict[str, Any]]:
    """Return the sentences of the page by the names of the languages, with those of these items."""
    made = languages.tables(ALL_KINDS)
    for language, table in made.items():
        for item in found:
            texts = item.words.get("en") or next(iter(item.words.values()))
            unit = {"unit": table["units"][item.data["unit"]]} if "unit" in item.data else {}
            table.setdefault(item.section, {})[item.name] = unit | texts | item.words.get(language, {})
    return made


def data(found: Sequence[Item], section: str) -> list[dict[str, Any]]:
    """Return what the page does in a section: "questions", "tours" or "lessons"."""
    return [{"name": item.name, **item.data} for item in found if item.section == section]
