"""Results as Process Run Crates: what RO-Crate 1.1 and the profile ask for, and that it is true."""

import hashlib
import json
from pathlib import Path

import h5py
import pytest

import vibsim
import vibsim.command_line.commands.export as export
from tests.command_line.made import call, refused


@pytest.fixture(autouse=True)
def folder(here):
    assert call("run", "II-B", "-s", "c=0.02", "--t-end", "2s", "-q").exit_code == 0


def graph(folder):
    document = json.loads((Path(folder) / "ro-crate-metadata.json").read_text())
    assert document["@context"][0] == "https://w3id.org/ro/crate/1.1/context"
    return {entity["@id"]: entity for entity in document["@graph"]}


def test_a_crate_holds_case_versions_output_and_checksums():
    done = call("export", "II-B.h5", "--ro-crate", "-o", "crate")
    assert (done.exit_code, done.stderr) == (0, "crate written\n")
    entities, attrs = graph("crate"), vibsim.open_result("II-B.h5").attrs
    about = entities["ro-crate-metadata.json"]
    assert about["about"] == {"@id": "./"} and about["conformsTo"] == {"@id": "https://w3id.org/ro/crate/1.1"}
    root = entities["./"]
    assert root["@type"] == "Dataset" and root["conformsTo"]["@id"].startswith(
        "https://w3id.org/ro/wfrun/process"
    )
    assert {"name", "description", "datePublished"} <= set(root)
    action = entities[root["mentions"]["@id"]]
    assert action["@type"] == "CreateAction" and action["result"] == {"@id": "II-B.h5"}
    assert entities[action["instrument"]["@id"]]["softwareVersion"] == attrs["vibsim_version"]
    assert action["actionStatus"]["@id"].endswith("CompletedActionStatus")
    parts = [part["@id"] for part in root["hasPart"]]
    inside = {path.name for path in Path("crate").iterdir()}
    assert set(parts) == inside - {"ro-crate-metadata.json"} and len(parts) == 3
    for part in parts:
        content = (Path("crate") / part).read_bytes()
        assert entities[part]["sha256"] == hashlib.sha256(content).hexdigest()
        assert entities[part]["contentSize"] == str(len(content))
    for entity in entities.values():  # every reference leads somewhere
        for value in entity.values():
            for link in value if isinstance(value, list) else [value]:
                if isinstance(link, dict) and not link["@id"].startswith("http"):
                    assert link["@id"] in entities


def test_the_case_in_a_crate_runs_again_to_the_same_bits():
    assert call("export", "II-B.h5", "--ro-crate", "-o", "crate", "-q").exit_code == 0
    assert call("run", "crate/case-resolved.yaml", "-o", "again.h5", "-q").exit_code == 0
    one, other = vibsim.open_result("II-B.h5"), vibsim.open_result("again.h5")
    assert one["x1"].tobytes() == other["x1"].tobytes()
    assert one.attrs["case_sha256"] == other.attrs["case_sha256"]


def test_crates_of_sweeps_and_of_interrupted_runs():
    assert call("sweep", "II-B", "--omega0", "5,6", "--t-end", "2s", "-o", "s.h5", "-q").exit_code == 0
    assert call("export", "s.h5", "--ro-crate", "-o", "sweep-crate", "-q").exit_code == 0
    assert "s.h5" in graph("sweep-crate")
    with h5py.File("II-B.h5", "r+") as file:
        file.attrs["complete"] = 0
    assert call("export", "II-B.h5", "--ro-crate", "-o", "crate", "-q").exit_code == 0
    assert graph("crate")["#run"]["actionStatus"]["@id"].endswith("FailedActionStatus")


def test_what_is_there_is_kept():
    Path("crate").mkdir()
    (Path("crate") / "mine.txt").write_text("precious")
    for words in ([], ["--force"]):
        assert "exists" in refused("export", "II-B.h5", "--ro-crate", "-o", "crate", *words, code=6)
    assert (Path("crate") / "mine.txt").read_text() == "precious"
    assert call("export", "II-B.h5", "--ro-crate", "-o", "other", "-q").exit_code == 0
    assert call("export", "II-B.h5", "--ro-crate", "-o", "other", "-q").exit_code == 6
    assert call("export", "II-B.h5", "--ro-crate", "-o", "other", "-q", "--force").exit_code == 0
    (Path("other") / "notes.txt").write_text("precious")
    assert call("export", "II-B.h5", "--ro-crate", "-o", "other", "--force").exit_code == 6
    assert (Path("other") / "notes.txt").read_text() == "precious"
    assert "takes the file whole" in refused("export", "II-B.h5", "--ro-crate", "-o", "third", "--events")
    assert call("export", "II-B.h5", "--ro-crate", "-o", "no/folder").exit_code == 6
    assert not list(Path().glob("*.partial"))


def test_a_crate_that_another_replaces_while_it_is_looked_at(monkeypatch):
    """What is read of a folder that is moved meanwhile is not a crate; the one in its place is."""
    assert call("export", "II-B.h5", "--ro-crate", "-o", "crate", "-q").exit_code == 0
    looked = export._holds_nothing_else

    def replaced(folder):
        if Path("aside").exists():
            return looked(folder)
        folder.rename("aside")
        assert call("export", "II-B.h5", "--ro-crate", "-o", "crate", "-q").exit_code == 0
        return False

    monkeypatch.setattr(export, "_holds_nothing_else", replaced)
    done = call("export", "II-B.h5", "--ro-crate", "-o", "crate", "--force", "-q")
    assert (done.exit_code, done.stderr) == (0, "")
