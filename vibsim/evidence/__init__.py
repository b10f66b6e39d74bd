"""The evidence that vibsim is right and fast: peers, verification, benchmark, and the paper's reports.

Its independence is its worth: it runs vibsim as anybody may and leans on nothing of how the engine makes its
modes.
"""
