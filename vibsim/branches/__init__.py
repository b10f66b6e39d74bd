"""Branches of periodic orbits: continued over a parameter, through folds, with what happens on the way.

    continue_branch(orbit, key, span)    follow an orbit both ways until the branch ends
    continue_locus(branch, label, key, span)    follow a special point of it in a second parameter
    Branch, Locus                        arrays by name along it, and its special points

Names are imported when they are used.
"""

from typing import TYPE_CHECKING

from vibsim.lazy_names import lazy_names

if TYPE_CHECKING:
    from vibsim.branches.branch import Branch as Branch
    from vibsim.branches.continuing import continue_branch as continue_branch
    from vibsim.branches.continuing import continue_locus as continue_locus
    from vibsim.branches.loci.locus_result import Locus as Locus
    from vibsim.branches.plan import BranchError as BranchError
    from vibsim.branches.store.branch_file import read_branch as read_branch

__getattr__, __dir__, __all__ = lazy_names(
    __name__,
    {
        "vibsim.branches.branch": ["Branch"],
        "vibsim.branches.continuing": ["continue_branch", "continue_locus"],
        "vibsim.branches.loci.locus_result": ["Locus"],
        "vibsim.branches.plan": ["BranchError"],
        "vibsim.branches.store.branch_file": ["read_branch"],
    },
)
