"""What a fit is to reach and by what: observables with bounds, parameters that are free, the plan."""
