"""The lines that tell of a run."""

import vibsim


def test_one_is_no_plural():
    result = vibsim.simulate("II-B", overrides={"Omega0": "6.5 Hz", "run.t_end": "20 s"})
    assert result.attrs["sticks"] == 1
    assert dict(result.lines())["motion"] == f"{result.attrs['impacts']} impacts, 1 stick"
