"""The long form of a case: a scene written as a list of named parts."""
