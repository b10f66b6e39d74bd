"""What may stand at which key of a case, in either form; see `schema` for the short one."""
