"""Pages that are run at the build: which, what they leave, and where pictures stand."""

import json
import re

from from_code import page_runs
from from_code.page_runs import draws, files, place_pictures, refreshed, run_page
from tests.docs.pages import DOCS, WRITTEN, name_of

PAGE = """# A page

```yaml
# ball.yaml
bodies: {ball: 1 kg}
stops: {floor: {between: [ball, ground], law: rigid, gap: 0 m, acts: extension, e: 0.5}}
forces: {weight: {on: ball, F0: -9.81 N}}
initial: {ball: {x: 1 m}}
run: {t_end: 1 s, every: 10 ms}
```

```console
$ vibsim run ball.yaml -q
$ vibsim plot ball.h5 --kind phase
stale.png
```

Between.

```python
import matplotlib.pyplot as plt

figure, axes = plt.subplots()
axes.plot([0, 1])
```
"""


def test_pictures_are_set_below_the_blocks_that_drew_them(tmp_path, monkeypatch):
    monkeypatch.setattr(page_runs, "STORE", tmp_path / "store")
    page = tmp_path / "page.md"
    page.write_text(PAGE, encoding="utf-8")
    run_page(page, tmp_path / "store" / "page")
    drawn = json.loads((tmp_path / "store" / "page" / "drawn.json").read_text(encoding="utf-8"))
    assert drawn == [["ball-phase.png"], ["python-1-1.png"]]
    content = [PAGE]
    place_pictures(None, "page", content)
    placed = re.findall(r"```\n\n!\[[^\]]*\]\(/generated/pages/page/([\w.-]+)\)", content[0])
    assert placed == ["ball-phase.png", "python-1-1.png"]
    assert re.sub(r"\n\n!\[.*\)", "", content[0]) == PAGE


def test_a_page_is_brought_up_to_date(here):
    new = refreshed(PAGE)
    assert "stale" not in new and "$ vibsim plot ball.h5 --kind phase\nball-phase.png\n```" in new
    assert set(files(PAGE)) == {"ball.yaml"}


def test_pages_that_draw_are_known():
    assert draws(PAGE) and not draws("# Nothing\n\n```console\n$ vibsim run II-B\n```\n")
    drawing = {name_of(path) for path in WRITTEN if draws(path.read_text(encoding="utf-8"))}
    for name in ("study", "motor", "base-and-stop", "run-up", "notebook", "own-case"):
        assert f"docs/tutorials/{name}.md" in drawing


def test_every_tutorial_is_in_the_contents():
    contents = (DOCS / "index.md").read_text(encoding="utf-8")
    for path in sorted((DOCS / "tutorials").glob("*.md")):
        assert f"\ntutorials/{path.stem}\n" in contents
