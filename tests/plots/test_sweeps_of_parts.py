"""Pictures of sweeps of scenes of named parts: what fits is drawn, with the names of bodies and parts."""

import numpy as np
import pytest

from tests.plots.artists import clipped_texts, colliding_legends
from vibsim.cases import load_case
from vibsim.plots.registry import fitting, kind_named
from vibsim.plots.subject import View, open_subject
from vibsim.plots.sweep_axes import label_of, value_texts
from vibsim.plots.sweep_curves import curves
from vibsim.plots.sweep_pictures import absorbed_powers, source_power
from vibsim.sweeps import sweep
from vibsim.sweeps.axes import read_axis

SWEEPS = {
    "drill": ("percussive-drill", {"feed.A": "50, 60, 70 N"}, {"compute": ["power", "lyapunov"]}),
    "map": ("impact-damper", {"left.k": "20, 50 kN/m", "drive.omega": "0.9, 1 Hz"}, {"compute": "regime"}),
    "stack": ("stack-of-blocks", {"base.omega": "3, 4 Hz"}, {"compute": "power", "ensemble": 3,
              "spread": {"table.mu": "0.01"}}),
}  # fmt: skip
FITTING = {
    "drill": {"amplitude", "orbit", "power", "lyapunov"},
    "map": {"amplitude", "orbit", "regime"},
    "stack": {"amplitude", "orbit", "power"},
}


@pytest.fixture(scope="module")
def subjects(tmp_path_factory):
    folder, opened = tmp_path_factory.mktemp("parts"), {}
    for name, (case, axes, settings) in SWEEPS.items():
        short = load_case(f"gallery/{case}", {"run.t_end": {"map": "6 s"}.get(name, "1 s")})
        sweep(short, axes, out=folder / f"{name}.h5", jobs=2, **settings)
        opened[name] = open_subject(str(folder / f"{name}.h5"))
    return opened


@pytest.mark.parametrize("name", SWEEPS)
def test_what_fits_is_drawn_and_fit_to_print(subjects, name):
    assert {kind.name for kind in fitting([subjects[name]])} == FITTING[name]
    for kind in FITTING[name]:
        figure = kind_named(kind).draw([subjects[name]], View())
        figure.draw_without_rendering()
        assert clipped_texts(figure) == [] and colliding_legends(figure) == []


def test_panels_have_the_names_of_coordinates(subjects):
    figure = kind_named("amplitude").draw([subjects["drill"]], View())
    labels = [axes.get_ylabel() for axes in figure.axes]
    assert (
        labels[0] == r"$x_\mathrm{hammer} - x_\mathrm{bit}$ (mm)" and labels[1] == r"$x_\mathrm{hammer}$ (mm)"
    )
    (line,) = [line for line in figure.axes[0].get_lines() if line.get_gid() == "relative_shank"]
    shown = subjects["drill"].result["amplitude_relative_shank"][:, 0]
    np.testing.assert_allclose(line.get_ydata() / line.get_ydata()[0], shown / shown[0], rtol=1e-14)
    assert figure.axes[-1].get_xlabel() == "Amplitude $A$ of feed (N)"
    orbit = kind_named("orbit").draw([subjects["drill"]], View())
    assert r"x_\mathrm{hammer} - x_\mathrm{bit}" in orbit.axes[0].get_ylabel()


@pytest.mark.parametrize("name", ["drill", "stack"])
def test_what_is_taken_and_stored_adds_up_to_what_is_given(subjects, name):
    (curve,) = curves([subjects[name]])
    total = sum(absorbed_powers(curve).values())
    assert (source_power(curve) > 0).all() and len(absorbed_powers(curve)) >= 3 - (name == "stack")
    np.testing.assert_allclose(total, source_power(curve), rtol=1e-9)


def test_axes_are_labelled_with_what_they_belong_to():
    case = load_case("gallery/percussive-drill")
    labels = {
        "stops.shank.gap": ("1, 2 mm", "Gap of shank (mm)"),
        "bodies.bit": ("1, 2 kg", "Mass $m$ of bit (kg)"),
        "feed.omega": ("10, 20 Hz", r"Excitation frequency $\omega/2\pi$ of feed (Hz)"),
        "rock.mu": ("0.1, 0.2", r"Coefficient of friction $\mu$ of rock"),
        "initial.bit.v": ("0, 1 m/s", "Velocity at the start $v(0)$ of bit (m/s)"),
        "run.t_end": ("1, 2 s", "t_end (s)"),
    }
    for key, (values, label) in labels.items():
        assert label_of(read_axis(case, key, values)) == label
    assert value_texts(read_axis(case, "bodies.bit", "1, 2 kg")) == ["$m$ of bit = 1 kg", "$m$ of bit = 2 kg"]
