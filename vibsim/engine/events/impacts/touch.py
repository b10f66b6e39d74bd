"""What happens where rigid stops touch at one instant, as blows, rest and the ledgers read it."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Generic

from vibsim.engine.events.impacts.newton_moreau import Contact, Impulse
from vibsim.physics.arithmetic.numbers import N


@dataclass(frozen=True)
class Catch(Generic[N]):
    """What ends give away as they come to rest on each other behind the hops that are left out.

    stop : where; loss : of energy [J]; impulse : of ground or base on the bodies [N s], zero where these move
    freely; column : of what catches them
    """

    stop: int
    loss: N
    impulse: N
    column: int


@dataclass
class Touch(Generic[N]):
    """The rigid stops that touch at an instant, and what blows did there.

    before : rates of their depths before the first blow; v, w : velocities of all columns and of the rotor
    there
    rates : behind the last one, exactly 0 where the law or rounding says so; blows : by blow, the stops that
    passed an impulse, and these; moved : columns whose velocities they changed
    catches : by group of ends that come to rest on each other
    ended : by stop where an infinite sequence of impacts ended, the speed that rounding of the time hides;
    faded : stops at which one ended without a blow; hop : the stop whose last blow was where the stretch
    began that ends here
    together : whether rounding might decide if another stop, of one of its bodies, is struck before this one
    """

    contacts: list[Contact[N]]
    before: dict[int, N]
    rates: dict[int, N]
    v: list[N]
    w: N
    together: bool
    blows: list[list[tuple[Contact[N], Impulse[N]]]] = field(default_factory=list)
    moved: set[int] = field(default_factory=set)
    catches: list[Catch[N]] = field(default_factory=list)
    ended: dict[int, N] = field(default_factory=dict)
    faded: list[int] = field(default_factory=list)
    hop: int | None = None

    @property
    def passed(self) -> list[Impulse[N]]:
        """The impulses, blow by blow."""
        return [impulse for one in self.blows for _, impulse in one]
