"""Reports: the paper reproduced figure by figure and audited claim by claim.

    from vibsim.evidence.reports.paper import write_paper
    write_paper("paper")

Runs are simulated once (`paper_runs`), drawn (`paper_figures`), measured into a table of numbers
(`paper_numbers`), judged from that table alone (`claims`), and told as HTML and text (`html_page`,
`text_page`).
"""
