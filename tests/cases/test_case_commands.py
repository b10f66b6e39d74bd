"""vibsim cases, check and schema, as a user sees them."""

import json
from pathlib import Path

import click
import pytest
import yaml
from click.testing import CliRunner

from vibsim.cases import gallery_case_names, shipped_case_names
from vibsim.cases.schema_keys import LONG, SHORT, all_keys
from vibsim.command_line.main import group

SHIPPED = [*shipped_case_names(), *gallery_case_names()]
INVALID = Path(__file__).parent / "invalid"


def vibsim(*args, stdin=None):
    """(exit code, stdout) of one command."""
    done = CliRunner().invoke(group, args, input=stdin, standalone_mode=False)
    assert done.exception is None
    return done.return_value or 0, done.stdout


def test_cases_lists_all():
    code, out = vibsim("cases")
    lines = out.splitlines()
    assert code == 0
    assert [line.split()[0] for line in lines] == [
        "name", *shipped_case_names(), *gallery_case_names(),
    ]  # fmt: skip
    assert any(
        line.split(maxsplit=4) == ["II-B", "motor", "5.5", "Hz", "Non-ideal source, motor constant 5.5 Hz"]
        for line in lines
    )


def test_cases_prints_a_case_to_start_from():
    code, out = vibsim("cases", "II-B")
    assert code == 0
    assert yaml.safe_load(out)["excitation"]["Omega0"] == "5.5 Hz"
    assert vibsim("check", "-", stdin=out)[0] == 0


def test_cases_prints_the_long_form():
    code, out = vibsim("cases", "II-B", "--resolved")
    assert code == 0
    assert yaml.safe_load(out)["motor"]["Omega0"] == "5.5 Hz"
    assert vibsim("check", "-", stdin=out) == (0, "-: ok (II-B: motor 5.5 Hz, 300 s every 5 ms)\n")
    with pytest.raises(click.UsageError, match="give the NAME of one"):
        CliRunner().invoke(group, ["cases", "--resolved"], standalone_mode=False, catch_exceptions=False)


def test_cases_as_json():
    found = {case["name"]: case for case in json.loads(vibsim("--json", "cases")[1])}
    assert sorted(found) == sorted(name.rpartition("/")[2] for name in SHIPPED)
    assert (found["I-A"]["source"], found["I-A"]["frequency"]) == ("harmonic", "3.5 Hz")


def test_check_says_ok():
    assert vibsim("check", "II-B") == (0, "II-B: ok (II-B: motor 5.5 Hz, 300 s every 5 ms)\n")
    assert vibsim("check", "-q", "II-B") == (0, "")


def test_check_with_verbose_prints_what_the_numbers_imply():
    code, out = vibsim("check", "-v", "I-A")
    assert code == 0
    assert "  free                        4.33366 Hz  blocks against each other" in out


def test_check_with_verbose_tells_of_scenes_of_parts():
    """sqrt(394.78/10)/(2 pi) = 0.999995 Hz with the stops open."""
    code, out = vibsim("check", "-v", "gallery/impact-damper")
    assert code == 0
    assert "  open 1                     0.999995 Hz  natural frequency, stops open" in out
    assert "  closed 2 " in out


def test_check_prints_every_problem_of_every_file_and_ends_with_3():
    path = INVALID / "negative_values.yaml"
    code, out = vibsim("check", "II-A", str(path))
    assert code == 3
    assert out.splitlines()[0].startswith("II-A: ok")
    assert out.splitlines()[1] == f"{path}:7:16: coupling.k1: must be >= 0, got -200 N/m"
    assert out.splitlines()[-1] == f"{path}: invalid, 4 problems"


def test_check_as_json():
    code, out = vibsim("check", "--json", "II-A", str(INVALID / "zero_mass.yaml"))
    good, bad = json.loads(out)
    assert code == 3
    assert (good["valid"], good["name"], good["facts"]["bilinear"]["unit"]) == (True, "II-A", "Hz")
    assert bad["valid"] is False
    assert bad["problems"] == [
        {
            "file": str(INVALID / "zero_mass.yaml"),
            "line": 3,
            "column": 14,
            "key": "blocks.m1",
            "message": "must be > 0, got 0 kg",
        }
    ]


NAMED = ("additionalProperties", "items")  # parts by name, harmonics by number


def keys_in(schema, section, prefix=""):
    """Dotted keys of a JSON Schema section, references followed."""
    for name, inner in section.get("properties", {}).items():
        variants = [inner, *inner.get("anyOf", []), *inner.get("oneOf", [])]
        named = next((v[word] for v in variants for word in NAMED if v.get(word)), None)
        if named is not None and name != "between":
            name, variants = f"{name}.*", [named, *named.get("anyOf", [])]
        referred = [schema["$defs"][v["$ref"].rpartition("/")[2]] for v in variants if "$ref" in v]
        for below in referred:
            yield from keys_in(schema, below, f"{prefix}{name}.")
        if not referred or len(variants) > len(referred) + 1:
            yield f"{prefix}{name}"


def test_schema_knows_every_key():
    code, out = vibsim("schema")
    schema = json.loads(out)
    assert code == 0
    whole, partial = schema["else"], schema["then"]["anyOf"]
    for form, branches in ((SHORT, (whole["else"], partial[0])), (LONG, (whole["then"], partial[1]))):
        for branch in branches:
            assert set(all_keys(form)) <= set(keys_in(schema, branch))


def test_schema_requires_what_a_case_needs_and_nothing_of_a_child():
    schema = json.loads(vibsim("schema")[1])
    assert schema["else"]["else"]["required"] == ["blocks", "coupling"]
    assert schema["else"]["then"]["required"] == ["bodies"]
    assert not any("required" in form for form in schema["then"]["anyOf"])
    assert schema["$defs"]["Motor"]["required"] == ["kind", "m3", "e", "J", "M0", "Omega0"]
    assert "required" not in schema["$defs"]["MotorPart"]


def test_schema_tells_units_ranges_defaults_and_meaning():
    schema = json.loads(vibsim("schema")[1])
    mass = schema["$defs"]["Blocks"]["properties"]["m1"]
    assert mass["description"] == "mass of block 1, the excited one"
    assert mass["anyOf"][0] == {"type": "number", "description": "in kg", "exclusiveMinimum": 0.0}
    assert mass["anyOf"][1]["description"] == "number and unit: kg, g, t"
    assert schema["$defs"]["Run"]["properties"]["t_end"]["default"] == "300 s"
    rate = schema["$defs"]["Motor"]["properties"]["Omega0"]
    assert [choice["type"] for choice in rate["anyOf"]] == ["string", "string"]  # with a unit; a formula
