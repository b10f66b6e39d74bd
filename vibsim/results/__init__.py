"""Results: a run recorded, written, read back and asked for its state at any instant.

    result = simulate(load_case("II-B"))
    result.save("II-B.h5")
    open_trajectory_file("II-B.h5")["x2"]

Names are imported when they are used: h5py takes longer to import than most runs take to run.
"""

from typing import TYPE_CHECKING

from vibsim.lazy import lazy_names

if TYPE_CHECKING:
    from vibsim.results.hdf5_reading import ResultFileError as ResultFileError
    from vibsim.results.result import Result as Result
    from vibsim.results.simulation import is_result_file as is_result_file
    from vibsim.results.simulation import kind_of as kind_of
    from vibsim.results.simulation import names_a_result as names_a_result
    from vibsim.results.simulation import open_trajectory_file as open_trajectory_file
    from vibsim.results.simulation import simulate as simulate
    from vibsim.results.simulation import simulate_to_file as simulate_to_file

__getattr__, __dir__, __all__ = lazy_names(__name__)
