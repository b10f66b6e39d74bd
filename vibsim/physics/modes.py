"""Names and codes of the events, the same in both engines and in every file."""

EVENT_KINDS = {
    "start": 0,
    "contact_begin": 1,
    "contact_end": 2,
    "reversal": 3,
    "stick_begin": 4,
    "stick_end": 5,
    "violation_begin": 6,
    "violation_end": 7,
    "end": 8,
    "impact": 9,
    "transmitted": 10,
    "chatter": 11,
    "rest_begin": 12,
    "rest_end": 13,
}
IMPACTS = ("contact_begin", "impact")  # of elastic stops, and of rigid ones
RIGID_KINDS = ("impact", "transmitted", "chatter", "rest_begin", "rest_end")  # of rigid stops alone
EVENT_NAMES = {code: name for name, code in EVENT_KINDS.items()}
