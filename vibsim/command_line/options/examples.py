"""The examples at the end of a command's --help."""


def examples(*lines: str, before: str = "") -> str:
    """An epilog: `before` as a paragraph, then the example lines as they are."""
    block = "\n".join(["\b", "Examples:", *(f"  {line}" for line in lines)])
    return f"{before}\n\n{block}" if before else block
