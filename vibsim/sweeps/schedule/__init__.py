"""Who computes which points when: batches for threads, processes or machines, in any order."""
