import pytest


@pytest.fixture(autouse=True, scope="package")
def run_once():
    """Time every method once: the least of several is for real benches."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("vibsim.evidence.benchmark.running.ENOUGH", 0.0)
        yield
