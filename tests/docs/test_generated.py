"""Pages made from the code say something of everything, and the gallery's numbers are met."""

import re
import shlex

import pytest

import vibsim
from from_code import PAGES
from from_code.attribute_meanings import MEANINGS
from from_code.gallery import comment, draw
from from_code.gallery_equations import equations
from from_code.gallery_numbers import NUMBERS, SOLVER, Kind, Number, agreement
from from_code.gallery_studies import STUDIES
from from_code.markdown import plain
from tests.command_line.made import told
from tests.docs.pages import DOCS, README
from vibsim.cases import load_case
from vibsim.cases.schema_keys import LONG, SHORT, all_keys
from vibsim.cases.sources import gallery_case_names
from vibsim.command_line.main import COMMANDS, EXIT_CODES
from vibsim.evidence.benchmark import bench_result
from vibsim.fitting import plan
from vibsim.orbits.branches import curve as branch_structure
from vibsim.plots.registry import kind_named
from vibsim.results import trajectory_file
from vibsim.sweeps import sweep_file

CASES = [name.partition("/")[2] for name in gallery_case_names()]
WITH_NUMBERS = [(name, number) for name, numbers in NUMBERS.items() for number in numbers]


@pytest.fixture(scope="module", params=PAGES)
def page(request):
    return request.param, PAGES[request.param]()


def test_tables_are_whole(page):
    """All rows of a table have as many cells."""
    _, text = page
    for block in text.split("\n\n"):
        rows = [line for line in block.splitlines() if line.startswith("|")]
        assert len({len(re.findall(r"(?<!\\)\|", row)) for row in rows}) <= 1, block[:300]


def test_every_attribute_has_a_meaning():
    structures = [
        part.ATTRIBUTES for part in (trajectory_file, sweep_file, plan, bench_result, branch_structure)
    ]
    structures.append(branch_structure.LOCUS_ATTRIBUTES)
    assert {each.name for attributes in structures for each in attributes} == set(MEANINGS)


def test_every_key_is_on_the_page_of_keys():
    text = PAGES["case-keys"]()
    for form in (SHORT, LONG):
        for key in all_keys(form):
            assert f"| `{key.removesuffix('.*').rpartition('.')[2]}` |" in text, key


def test_every_command_and_exit_code_has_its_place():
    text = PAGES["commands"]()
    assert re.findall(r"^## vibsim (\w+)$", text, flags=re.MULTILINE) == [*COMMANDS]
    codes = re.findall(r"^\| (\d+) \|", PAGES["exit-codes"](), flags=re.MULTILINE)
    assert [int(code) for code in codes] == [*EXIT_CODES]


def test_every_public_name_is_on_the_page_of_python():
    text = (DOCS / "python.md").read_text(encoding="utf-8")
    listed = re.findall(r"auto(?:function|class|exception):: vibsim\.(\w+)", text)
    assert sorted(listed) == [name for name in sorted(vibsim.__all__) if not name.startswith("__")]


def test_every_case_of_the_gallery_has_a_number_and_a_source():
    assert set(CASES) == set(NUMBERS)
    for name in CASES:
        text = load_case(f"gallery/{name}").text
        assert comment(text, "Source") and comment(text, "What to look at")


def test_every_number_of_the_gallery_says_what_it_is_held_against():
    """A publication by author and year, a solver as such; 0 where only a law of conservation speaks."""
    for name, number in WITH_NUMBERS:
        cites = re.search(r"[A-Z][a-z]+ (?:and [A-Z][a-z]+ )?\(?(?:19|20)\d\d\)", number.origin)
        assert bool(cites) == (number.kind is Kind.PUBLISHED), name
        assert (number.origin == SOLVER) == (number.kind is Kind.INDEPENDENT), name
        assert (number.expected == 0) == (number.kind is Kind.NONE), name


def test_the_readme_says_of_what_kind_the_numbers_of_the_gallery_are():
    """Models by the kind of their best number."""
    best = [min((number.kind for number in numbers), key=[*Kind].index) for numbers in NUMBERS.values()]
    count = {kind: best.count(kind) for kind in Kind}
    words = (
        f"gallery of {len(NUMBERS)} models, whose numbers stand beside a published formula or number "
        f"({count[Kind.PUBLISHED]}), a closed form ({count[Kind.CLOSED_FORM]}), an independent solver "
        f"({count[Kind.INDEPENDENT]}) or a law of conservation alone ({count[Kind.NONE]})"
    )
    assert words in README.read_text(encoding="utf-8")


@pytest.mark.parametrize(("name", "number"), WITH_NUMBERS, ids=lambda value: getattr(value, "what", value))
def test_a_number_of_the_gallery_is_met(name, number):
    assert abs(number.measured(name) - number.expected) <= number.within


def test_a_number_that_is_off_stops_the_build():
    def reached(run):
        return run().attrs["t_reached_s"]

    off = Number("rest", Kind.NONE, 4.0, "s", "nobody", reached, 1e-3, "no reason")
    with pytest.raises(ArithmeticError, match=r"bouncing-ball: rest: 5\.0, expected 4\.0"):
        off.measured("bouncing-ball")


@pytest.mark.parametrize(
    ("expected", "ours", "said"),
    [(0.0, 1.338e-15, "within 2e-15"), (0.0, 4.5e-16, "within 5e-16"), (0.0, 9.1e-16, "within 1e-15"),
     (2.0, 2.0, "to the last bit"), (1.0, 1 + 2e-7, "6 digits"), (1.0, 1 + 0.9e-7, "7 digits")],
)  # fmt: skip
def test_pages_say_no_more_agreement_than_there_is(expected, ours, said):
    number = Number("it", Kind.NONE, expected, "m", "nobody", lambda run: ours, 1.0, "no reason")
    assert agreement(number, ours) == said


def test_names_of_functions_stand_apart_from_their_arguments():
    pytest.importorskip("latex2mathml")
    from from_code.mathml import mathml

    assert mathml(r"A \sin\omega t").count("<mspace") == 2
    assert mathml(r"(\sin(x) + \max(0, x))").count("<mspace") == 0


def test_no_formula_in_a_line_is_wider_than_a_narrow_page():
    """It does not break; 74 characters of LaTeX go into 400 px."""
    for path in sorted(DOCS.rglob("*.md")):
        lines = [line for line in path.read_text(encoding="utf-8").splitlines() if not line.startswith("|")]
        formulas = re.findall(r"(?<!\$)\$([^$`]+)\$(?!\$)", re.sub(r"`[^`]*`", "", "\n".join(lines)))
        assert not [formula for formula in formulas if len(formula) > 74], path


def test_what_markdown_would_read_as_markup_is_escaped():
    assert plain("a_b |x|\n <c>") == r"a\_b \|x\| \<c\>"


def test_powers_in_running_text_are_superscripts():
    pytest.importorskip("sphinx")
    pytest.importorskip("latex2mathml")
    from from_code.mathml import with_powers

    pieces = with_powers("m u^2/(2 (R/M - g)), x^(1/2), 10^-9 and x^3; a^ b")
    raised = [str(piece.astext()) for piece in pieces if piece.tagname == "superscript"]
    assert raised == ["2", "1/2", "-9", "3"]
    assert "".join(piece.astext() for piece in pieces) == "m u2/(2 (R/M - g)), x1/2, 10-9 and x3; a^ b"


def test_lines_of_code_wrap_below_their_values():
    pytest.importorskip("docutils")
    from from_code.layout import PRE, wrapping

    block = "<pre><span>$</span> vibsim run x\n  trust horizon   right\n\n  &lt;long&gt;</pre>"
    wrapped = PRE.sub(wrapping, block)
    assert re.findall(r'class="line"( style="[^"]*")?>', wrapped) == ["", ' style="--hang:18ch"', "", ""]
    assert re.sub(r"<[^>]+>", "", wrapped) == re.sub(r"<[^>]+>", "", block) + "\n"


def test_cells_of_wide_tables_know_the_heads_of_their_columns():
    pytest.importorskip("docutils")
    from from_code.layout import TABLE, stackable

    def table(heads):
        head = "".join(f'<th class="head"><p>{each}</p></th>' for each in heads)
        cells = "<td><p>1</p></td>" * len(heads)
        return f'<table class="docutils"><thead><tr>{head}</tr></thead><tr>{cells}</tr></table>'

    assert TABLE.sub(stackable, table("abc")) == table("abc")
    long_words = TABLE.sub(stackable, table(["a", "b" * 20, "c" * 20]))
    assert 'class="docutils cards"' in long_words  # 41 characters that no line can break
    stacked = TABLE.sub(stackable, table(["", "a &amp; b", "c", "d"]))
    assert 'class="docutils cards"' in stacked
    heads = [f' data-head="{each}"' for each in ("a &amp; b", "c", "d")]
    assert re.findall(r"<td([^>]*)>", stacked) == ["", *heads]


def test_pictures_have_on_screen_the_width_that_they_have_in_print():
    pytest.importorskip("docutils")
    from from_code.layout import printed_width

    assert printed_width(DOCS / "impact-diagram.png") == pytest.approx(3.38, abs=0.01)


# Pages of the gallery: their equations, their second pictures, and what they say to try.


def formulas(name):
    return re.findall(r"\$\$\n(.*)\n\$\$", equations(load_case(f"gallery/{name}").text))


def test_every_case_has_a_study():
    assert sorted(STUDIES) == CASES
    for study in STUDIES.values():
        assert kind_named(study.kind) and study.shows and study.tries


@pytest.mark.parametrize("name", CASES)
def test_equations_name_every_part(name):
    """One for each body, and every stop and friction stands in two: its own, and that of a body."""
    case = load_case(f"gallery/{name}")
    lines = formulas(name)
    accelerations = [line for line in lines if re.search(r"^\(?[mJ].*\\ddot\{(x|\\theta)\}", line)]
    assert len(accelerations) >= len(case.scene().bodies) - 2  # ground and base
    for section, letter in (("stops", "F"), ("friction", "R")):
        parts = re.search(rf"(?ms)^{section}:\n(.*?)^(?=\S)", case.text)
        for part in re.findall(r"(?m)^  (\w+):", parts[1] if parts else ""):
            symbol = f"{letter}_{{\\text{{{part.replace('_', ' ')}}}}}"
            assert sum(symbol in line for line in lines) >= 2, symbol
    for line in lines:
        assert line.count("{") == line.count("}") and "None" not in line


@pytest.mark.parametrize(
    ("name", "line"),
    [
        ("duffing-two-well",
         r"m\,\ddot{x} = - \left(k_{3}\,x^{3} - k\,x + c\,\dot{x}\right) + A \sin\omega t"),
        ("impact-oscillator", r"m\,\ddot{x} = - k\,x - F_{\text{wall}} + A \cos\omega t"),
        ("impact-pair", r"m\,\ddot{x} = F_{\text{left}} - F_{\text{right}}"),
        ("chain-with-gaps", r"m_{\text{two}}\,\ddot{x}_{\text{two}} = F_{\text{gap 1}} - F_{\text{gap 2}}"),
        ("captured-motor",
         r"(J + m_3 e^2)\,\ddot{\varphi} = m_3 e\,\ddot{x}_{1} \sin{\varphi} + K_{\text{t}}\,i"),
        ("dc-motor-start", r"J\,\ddot{\theta} = \left(k\,i\right) + \left(\left\{0 \;\text{if } t < t_{1},\; "
         r"\text{else } -T\right\}\right)"),
    ],
)  # fmt: skip
def test_equations_are_those_of_the_case(name, line):
    """Worked out by hand from the case files and docs/equations.md."""
    assert line in formulas(name)


@pytest.mark.parametrize("name", CASES)
def test_what_is_said_to_try_runs(name, tmp_path):
    for options, _ in STUDIES[name].tries:
        out = ("-o", tmp_path / "try.h5", "--force")
        told("run", f"gallery/{name}", *shlex.split(options), "--t-end", "0.02s", "-q", *out)


def test_a_case_is_drawn(tmp_path):
    draw("three-balls", tmp_path)
    names = {f"three-balls{part}.png" for part in ("", "-machine", "-study")}
    assert {path.name for path in tmp_path.iterdir()} == names
