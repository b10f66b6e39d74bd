"""Newton on the return map, and where it begins: ends of runs, random starts, growing motions."""
