"""All rules of the long form that concern several keys at once."""

from collections.abc import Callable, Iterator, Mapping
from typing import Any

from vibsim.cases.parts.connections import (
    base_is_there,
    ends_differ,
    ends_exist,
    loads_act_on_bodies,
    states_exist,
)
from vibsim.cases.parts.contents import (
    a_file_has_room,
    closed_form_is_there,
    friction_has_a_load,
    links_do_something,
    products_fit,
    sources_are_harmonic,
    there_is_a_body,
)
from vibsim.cases.parts.draft import Draft, Finding
from vibsim.cases.parts.friction_laws import coefficients_fit_the_law, friction_falls
from vibsim.cases.parts.laws_of_stops import starts_are_outside, stops_have_their_law
from vibsim.cases.parts.names import names_are_different, names_are_names, names_are_no_columns

RULES: tuple[Callable[[Draft], Iterator[Finding]], ...] = (
    there_is_a_body,
    a_file_has_room,
    names_are_names,
    names_are_different,
    names_are_no_columns,
    ends_exist,
    ends_differ,
    base_is_there,
    loads_act_on_bodies,
    states_exist,
    links_do_something,
    coefficients_fit_the_law,
    friction_falls,
    stops_have_their_law,
    starts_are_outside,
    friction_has_a_load,
    sources_are_harmonic,
    closed_form_is_there,
    products_fit,
)


def findings(flat: Mapping[str, Any], values: Mapping[str, Any]) -> list[Finding]:
    """What the rules find.

    flat : dotted key -> value that can be read; values : the nested texts of the case
    """
    draft = Draft(flat, values)
    return [finding for rule in RULES for finding in rule(draft)]
