"""Reports: the paper reproduced figure by figure and audited claim by claim.

    from vibsim.evidence.reports.paper import write_paper
    write_paper("paper")

Runs are simulated once and measured into a table of numbers (`measured`), judged from that table alone
(`claims`), told as HTML and text (`pages`), and drawn (`figures`).
"""
