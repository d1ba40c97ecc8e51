"""The tables of the teaching page's sentences."""

import re
import tomllib
from pathlib import Path

import pytest
import translations  # docs/translations.py
from conftest import PROJECT

from povgen.inputs.pieces import PIECES
from povgen.liveview.languages import FOLDER
from povgen.page import items, page
from povgen.page.address import ALL_KINDS, KEPT

ITEMS = items.load([], PIECES)
TABLES = items.tables(ITEMS)
SCRIPTS = {
    path.name: path.read_text("utf-8") for path in Path(page.__file__).parent.iterdir() if path.suffix in (".js", ".j2")
}
PLURALS = {"zero", "one", "two", "few", "many", "other"}


def sentences(table, path=()):
    """Return the sentences by their keys. Plurals of a sentence are one entry, choices of an answer too."""
    found = {}
    for name, value in table.items():
        key = (*path, name)
        if isinstance(value, dict) and not (value.keys() <= PLURALS and "other" in value):
            found |= sentences(value, key)
        else:
            found[".".join(key)] = value
    return found


def marks(text):
    """Return what a translation has to keep: the words in braces, without forms, and the tags."""
    return sorted(set(re.findall(r"\{([\w/]+)", text))), sorted(re.findall(r"</?\w+>", text))


def parts(value):
    return value["other"] if isinstance(value, dict) else "\n".join(value) if isinstance(value, list) else value


ENGLISH = {key: value for key, value in sentences(TABLES["en"]).items() if not key.startswith("things.")}


def test_an_item_of_povgens_own_has_all_languages():
    """A sentence that is missing would be English there."""
    assert len(ITEMS) > 24
    for item in ITEMS:
        found = {language: {*text} - {"unit"} for language, text in item.words.items()}
        assert found == dict.fromkeys(TABLES, {*item.words["en"]} - {"unit"}), item.name


@pytest.mark.parametrize("language", TABLES)
def test_a_language_has_all_sentences_with_the_same_words_in_braces(language):
    own = {key: value for key, value in sentences(TABLES[language]).items() if not key.startswith("things.")}
    assert own.keys() == ENGLISH.keys()
    for key, value in own.items():
        names, tags = marks(parts(value))
        wanted = marks(parts(ENGLISH[key]))
        kept = [name for name in names if name in wanted[0] or (name, key.split(".")[0]) != ("thing", "turned")]
        assert (kept, tags) == wanted, key  # how something appears turned can depend on its gender
        assert parts(value).strip() and type(value) is type(ENGLISH[key]), key
        if isinstance(value, list):
            assert len(value) == len(ENGLISH[key]), key
        if isinstance(value, dict):
            assert all({*marks(text)[0]} <= {*marks(value["other"])[0]} for text in value.values()), key


def test_a_reader_sees_every_sentence_beside_its_translation():
    text = translations.page("de", "ar")
    rows = dict(re.findall(r"<tr><th>(.*?)</th>(.*)</tr>", text))
    assert rows["page.reset"] == '<td lang="de" dir="ltr">Zurücksetzen</td><td lang="ar" dir="rtl">إعادة الضبط</td>'
    assert rows["page.keys"].startswith('<td lang="de" dir="ltr">&lt;kbd&gt;Leertaste')
    lone = {key for key, value in sentences(TABLES["de"]).items() if isinstance(value, str)}
    assert lone < rows.keys() and {"tours.start.steps 10", "counts.tiles.few", "things.pawn.des"} < rows.keys()


def test_no_line_of_french_breaks_before_a_mark():
    """French has a space before these marks. It must not break: U+00A0 or the narrower U+202F."""
    for key, value in sentences(TABLES["fr"]).items():
        texts = value.values() if isinstance(value, dict) else [value] if isinstance(value, str) else value
        text = "\n".join(texts)
        assert not re.search(r" [:;?!»]|« |[^\s\u00a0\u202f][?!;»]|«[^\u00a0]", text), key


@pytest.mark.parametrize("language", TABLES)
def test_every_slider_has_a_label_of_the_table(language):
    """A kind that no table has is called by its title."""
    found = tomllib.loads((FOLDER / f"{language}.toml").read_text("utf-8"))["kinds"]
    assert len(found) > 10
    for name in found.keys() & ALL_KINDS:
        wanted = {each.name for each in ALL_KINDS[name].parameters if each.name not in KEPT} - {"alpha"}
        assert wanted <= found[name].get("labels", {}).keys(), name


@pytest.mark.parametrize("language", TABLES)
def test_a_thing_has_every_form_that_a_sentence_uses(language):
    table = TABLES[language]
    things = table["things"]
    assert things.keys() == TABLES["en"]["things"].keys() >= {*PIECES}
    for key, value in sentences(table).items():
        texts = value.values() if isinstance(value, dict) else [value] if isinstance(value, str) else value
        for thing, form in re.findall(r"\{(thing|window)\.(\w+)\}", "\n".join(texts)):
            for name, forms in things.items():
                if name.endswith("window") == (thing == "window") and name != "mountains":
                    assert form in forms, (key, name, form)
            if key.startswith("turned."):
                assert form in things["mountains"], (key, form)


def test_every_sentence_is_used():
    text = "\n".join(SCRIPTS.values())
    made = {"kinds", "things", "questions", "tours", "lessons", "failures"}  # their keys are names of other parts
    for key in ENGLISH:
        section, _, name = key.partition(".")
        if section not in made and name:
            parts = re.split(r"[._]", name)
            assert key in text or re.search(rf"{section}\.[\w.]*\$", text) or re.search(rf"\b{parts[-1]}\b", text), key


def test_no_sentence_is_in_the_template():
    template = re.sub(
        r"\{[{%#].*?[}%#]\}|<style.*?</style>|<script.*?</script>|<!--.*?-->", "", SCRIPTS["index.html.j2"], flags=re.S
    )
    for text in re.findall(r">([^<>]*)<", template):
        assert not re.search(r"[A-Za-z]{3}", text), text
    assert not re.search(r'\s(aria-label|title|alt|placeholder)="[^"{]*[a-z]', template)


def test_no_sentence_is_in_the_scripts():
    """A sentence has two words beside each other, in quotes, that are not names of classes or of selectors."""
    found = []
    for name, text in SCRIPTS.items():
        if not name.endswith(".js"):
            continue
        text = re.sub(r"//[^\n]*|/\*.*?\*/|^import [^\n]*", "", text, flags=re.M | re.S)
        for literal in re.findall(r'"((?:[^"\\\n]|\\.)*)"|`((?:[^`\\]|\\.)*)`', text):
            words = re.sub(r"\$\{[^}]*\}", " ", "".join(literal))
            if re.search(r"[A-Z][a-z]+ [a-z]|\b(the|of|is|are|at|and|in|for|by|with|from) ", words):
                found.append((name, words))
    assert not found


def test_the_labels_that_the_docs_name_are_those_of_the_page():
    page = (PROJECT / "docs" / "page.md").read_text("utf-8")
    named = set(re.findall(r"(?<!\*)\*([^*`]+)\*", page)) - {"vary α", "vary z₁"}  # movies
    labels = {line.lower() for text in map(parts, ENGLISH.values()) for line in text.split("\n")}
    assert len(named) > 20 and not [name for name in named if name.lower() not in labels]
