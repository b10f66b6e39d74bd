"""vibsim: vibro-impact systems with dry friction under ideal and limited-power excitation.

    import vibsim

    case = vibsim.load_case("II-B", {"excitation.Omega0": "6.5 Hz"})
    result = vibsim.simulate(case)
    result["x2"], result.events["t"], result.at(12.3456)
    result.save("II-B.h5")
    vibsim.open_result("II-B.h5")
    vibsim.analyse(result).capture.verdict
    vibsim.lyapunov(case).exponents
    vibsim.orbit(case).multipliers

    sweep = vibsim.sweep("II-B", {"excitation.Omega0": "3:7:0.05 Hz"}, out="sommerfeld.h5")
    sweep["omega0"], sweep["mean_speed"]

    vibsim.edge("basins.h5", 0, 1).orbit, vibsim.fatal_shock("basins.h5", 0).size

    branch = vibsim.continue_branch("I-A", "excitation.omega", "3:4 Hz")
    branch["parameter"], branch["multipliers"], branch.specials

Names are imported when they are used, so `import vibsim` costs next to nothing.
"""

from vibsim.lazy import FRONT, lazy_names

TYPE_CHECKING = False  # to type checkers it is true; typing itself takes longer to load than all of this
if TYPE_CHECKING:
    from vibsim.analysis import Analysis as Analysis
    from vibsim.analysis import Lyapunov as Lyapunov
    from vibsim.analysis import analyse as analyse
    from vibsim.analysis import lyapunov as lyapunov
    from vibsim.cases import Case as Case
    from vibsim.cases import CaseError as CaseError
    from vibsim.cases import load_case as load_case
    from vibsim.engine.errors import EngineError as EngineError
    from vibsim.fitting import FitError as FitError
    from vibsim.fitting import FitResult as FitResult
    from vibsim.fitting import fit as fit
    from vibsim.orbits import Orbit as Orbit
    from vibsim.orbits import OrbitError as OrbitError
    from vibsim.orbits import monodromy as monodromy
    from vibsim.orbits import search_orbits as search_orbits
    from vibsim.orbits.branches.branch import Branch as Branch
    from vibsim.orbits.branches.continuing import continue_branch as continue_branch
    from vibsim.orbits.branches.continuing import continue_locus as continue_locus
    from vibsim.orbits.branches.locus_result import Locus as Locus
    from vibsim.orbits.branches.plan import BranchError as BranchError
    from vibsim.orbits.search import orbit as orbit
    from vibsim.plots.picture import plot as plot
    from vibsim.plots.subject import PlotError as PlotError
    from vibsim.results import Result as Result
    from vibsim.results import ResultFileError as ResultFileError
    from vibsim.results import simulate as simulate
    from vibsim.results.labelled import Labelled as Labelled
    from vibsim.results.labelled import MissingExtra as MissingExtra
    from vibsim.results.result import Events as Events
    from vibsim.results.simulation import open_result as open_result
    from vibsim.sweeps import PlanError as PlanError
    from vibsim.sweeps import SweepResult as SweepResult
    from vibsim.sweeps import join as join
    from vibsim.sweeps import sweep as sweep
    from vibsim.sweeps.basin_edges import BasinEdge as BasinEdge
    from vibsim.sweeps.basin_edges import edge as edge
    from vibsim.sweeps.basin_shocks import FatalShock as FatalShock
    from vibsim.sweeps.basin_shocks import fatal_shock as fatal_shock

__version__ = "0.1.0"

FRONT |= {
    "plot": "vibsim.plots.picture:plot",
    "open sweep": "vibsim.sweeps:open_sweep",
    "open fit": "vibsim.fitting:open_fit",
    "open branch": "vibsim.orbits.branches.branch:read_branch",
    "open locus": "vibsim.orbits.branches.locus_result:read_locus",
    "open bench": "vibsim.evidence.benchmark:open_bench",
}

__getattr__, __dir__, __all__ = lazy_names(__name__)
__all__ += ["__version__"]
