"""Branches of periodic orbits: continued over a parameter, through folds, with what happens on the way.

    continue_branch(orbit, key, span)    follow an orbit both ways until the branch ends
    continue_locus(branch, {key: range}, label=...)    follow a special point of it in a second parameter
    Branch, Locus                        arrays by name along it, and its special points

Names are imported when they are used.
"""

from typing import TYPE_CHECKING

from vibsim.lazy import lazy_names

if TYPE_CHECKING:
    from vibsim.orbits.branches.branch import Branch as Branch
    from vibsim.orbits.branches.branch import read_branch as read_branch
    from vibsim.orbits.branches.continuing import continue_branch as continue_branch
    from vibsim.orbits.branches.continuing import continue_locus as continue_locus
    from vibsim.orbits.branches.locus_result import Locus as Locus
    from vibsim.orbits.branches.plan import BranchError as BranchError


__getattr__, __dir__, __all__ = lazy_names(__name__)
