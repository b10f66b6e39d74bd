"""What is drawn of a case of the gallery beside its run, and what a reader may try."""

from typing import NamedTuple


class Study(NamedTuple):
    """A second picture of a case, and what to try.

    Attributes
    ----------
    sweep : options of `vibsim sweep` behind the name of the case; empty: the picture is of the run
    kind : of the picture, as of `vibsim plot --kind`
    shows : what the picture shows, in words
    tries : options of `vibsim run` behind the name of the case, each with what to expect
    """

    sweep: str
    kind: str
    shows: str
    tries: tuple[tuple[str, str], ...]


UP_AND_DOWN = " --carry-state --direction both"

STUDIES: dict[str, Study] = {
    "ball-on-shaken-table": Study(
        "--param base.a=0.5:1.1/61mm --t-end 12s --section 40",
        "bifurcation",
        "Bifurcation diagram over the amplitude of the table: one bounce per period, up to a doubling",
        (("-s base.a='0.9 mm'", "one bounce per period still, at another phase of the table"),),
    ),
    "belt-oscillator": Study(
        "--param belt.belt=1.2:2.2/41m/s --t-end 200s" + UP_AND_DOWN,
        "amplitude",
        "Amplitude over the speed of the belt: up, stick and slip end; down, equilibrium stays",
        (("-s belt.belt='2 m/s'", "the block comes to rest on the moving belt"),),
    ),
    "bilinear-oscillator": Study(
        "--param drive.omega=0.6:2/71rad/s --t-end 400s" + UP_AND_DOWN,
        "amplitude",
        "Frequency response, up and down: the stop stiffens the resonance",
        (("-s wall.gap='0 m'", "the frequency no longer depends on the amplitude"),),
    ),
    "block-on-belt": Study(
        "",
        "phase",
        "Phase portrait: the straight piece is the block sticking to the belt",
        (
            ("-s belt.belt='1 m/s'", "a shorter period of stick and slip"),
            ("-s belt.d='0.5 s/m'", "friction falls more slowly: a shorter period too"),
        ),
    ),
    "bouc-wen": Study(
        "",
        "phase",
        "Phase portrait: hysteresis takes the energy of the swings",
        (("-s spring.r=1", "a linear spring, without memory: it swings for ever"),),
    ),
    "bouncing-ball": Study(
        "",
        "phase",
        "Phase portrait: parabolas that shrink by e, infinitely many until the ball rests",
        (("-s floor.e=0.5", "rest after sqrt(2 h/g) (1 + e)/(1 - e)"),),
    ),
    "brake-squeal": Study(
        "",
        "phase",
        "Phase portraits along and into the belt: sliding loses its stability by mode coupling",
        (("-s belt.belt='0.4 m/s'", "a faster belt, and a faster vibration"),),
    ),
    "cantilever": Study(
        "--omega 6:20:0.2 --t-end 30s" + UP_AND_DOWN,
        "amplitude",
        "Frequency response, up and down: two motions side by side above the natural frequency",
        (("-s initial.tip.v='0.2 m/s'", "another start, and the motion that strikes: 4.78 mm"),),
    ),
    "captured-motor": Study(
        "",
        "motor-speed",
        "Speed of the motor, held at half the bilinear frequency",
        (("-s i.L='1 mH'", "a faster current hardly changes the speed at which it is held"),),
    ),
    "chain-with-gaps": Study(
        "",
        "phase",
        "Phase portraits: the velocity is handed on from body to body",
        (("-s bodies.one='2 kg'", "the first body goes on, and strikes again"),),
    ),
    "chattering-oscillator": Study(
        "--param drive.omega=0.25:0.6/71rad/s --t-end 400s --section 20",
        "bifurcation",
        "Orbit diagram over the frequency: windows of motions that chatter and rest",
        (("-s wall.e=0.5", "fewer bounces before each rest"),),
    ),
    "coupled-clutches": Study(
        "",
        "velocity",
        "Speeds of the four discs, which lock one after another",
        (("-s clutch1.static=1", "holding no more than sliding"),),
    ),
    "dc-motor-start": Study(
        "",
        "states",
        "Current of the motor: run-up, and the load that is switched on",
        (("-s states.i.L='15 mH'", "the current follows ten times more slowly"),),
    ),
    "drifting-capsule": Study(
        "",
        "relative",
        "Relative motion of hammer and capsule, with the anvil",
        (
            ("-s anvil.gap='4 mm'", "the capsule goes farther"),
            ("-s floor.mu=0.05", "on a smoother floor it goes less far"),
        ),
    ),
    "drifting-oscillator": Study(
        "",
        "relative",
        "Relative motion of mass and slider: contact, progress, separation",
        (("-s drive.F0='4 N'", "twice the static force, and less progress"),),
    ),
    "driven-pendulum": Study(
        "--param drive.A=0.4:0.62/81Nm --t-end 1200s --section 60",
        "bifurcation",
        "Bifurcation diagram over the torque",
        (("-s weight.c='0.2 N m s/rad'", "with more damping the swings are periodic"),),
    ),
    "duffing-hardening": Study(
        "",
        "phase",
        "Phase portrait: a closed curve, narrower than a circle at the ends",
        (("-s mass.x='2 m'", "twice the amplitude, a higher frequency"),),
    ),
    "duffing-softening": Study(
        "",
        "phase",
        "Phase portrait near the separatrix, whose corners are saddle points",
        (("-s mass.x='0.5 m'", "half the amplitude, a higher frequency"),),
    ),
    "duffing-two-well": Study(
        "--param drive.A=0.2:0.4/81N --t-end 1500s --section 60",
        "bifurcation",
        "Bifurcation diagram over the force: from one well to both",
        (("-s drive.A='0.2 N'", "the mass stays in one well"),),
    ),
    "energy-harvester": Study(
        "--omega 40:70:1 --t-end 1s" + UP_AND_DOWN,
        "amplitude",
        "Frequency response: above the resonance the stops keep the amplitude near their gap",
        (("-s u.R='600 kohm'", "another load at the electrodes"),),
    ),
    "energy-sink": Study(
        "--param drive.omega=50:60/61rad/s --t-end 20s",
        "amplitude",
        "Frequency response with the ball: a dip at the natural frequency, where the body alone has its peak",
        (
            ("-s stops=none", "the body alone: 33 mm"),
            ("-s left.e=0.8 -s right.e=0.8", "impacts that lose less"),
        ),
    ),
    "friction-oscillator": Study(
        "--param drive.omega=0.3:2/61rad/s --t-end 300s" + UP_AND_DOWN,
        "amplitude",
        "Frequency response with dry friction",
        (("-s drive.A='1.1 N'", "the mass sticks twice in each period"),),
    ),
    "gear-pair": Study(
        "",
        "phase",
        "Phase portrait: at x = 1 the teeth part and meet again",
        (("-s load.F='0.05 N'", "a lighter load, a smaller vibration"),),
    ),
    "hertz-ball": Study(
        "",
        "phase",
        "Phase portrait: approach, Hertz contact, rebound with the same speed",
        (("-s ball.v='2 m/s'", "the contact is shorter by 2^(1/5)"),),
    ),
    "hertz-chain": Study(
        "",
        "velocity",
        "Velocities of the four balls: a pulse goes through the chain",
        (("-s bodies.striker='2 kg'", "the third ball leaves faster, and the others follow it"),),
    ),
    "impact-damper": Study(
        "--param drive.omega=0.9:1.1/61Hz --t-end 120s",
        "amplitude",
        "Frequency response with the ball: a dip at the natural frequency, a peak beside it",
        (("-s stops=none", "the body alone: 25.3 mm"),),
    ),
    "impact-oscillator": Study(
        "--param drive.omega=2.4:3.8/141rad/s --t-end 1200s --section 60",
        "bifurcation",
        "Bifurcation diagram over the frequency: period doubling, chaos, two periods",
        (("-s drive.omega='2.8 rad/s'", "chaos"), ("-s wall.gap='0.4 m'", "beyond the fold: another motion")),
    ),
    "impact-oscillator-coco": Study(
        "--param drive.omega=0.6:2/71rad/s --t-end 300s" + UP_AND_DOWN,
        "amplitude",
        "Frequency response, up and down",
        (("-s wall.e=0.5", "impacts at another speed and phase"),),
    ),
    "impact-pair": Study(
        "--param base.a=3:12/61mm --t-end 20s --section 40",
        "bifurcation",
        "Bifurcation diagram over the amplitude of the base",
        (("-s left.e=0.5 -s right.e=0.5", "slower, and still one impact on each wall per period"),),
    ),
    "lugre-friction": Study(
        "",
        "states",
        "Deflection of the bristles: it rises while the mass sticks, and breaks away",
        (("-s V='0.5 m/s'", "a faster base: steady sliding"),),
    ),
    "pendulum-on-cart": Study(
        "",
        "rotor-speed",
        "Speed of the pendulum",
        (("-s buffer.gap='10 mm'", "the cart strikes its buffer again and again"),),
    ),
    "percussive-drill": Study(
        "--param feed.omega=10:40/61Hz --t-end 5s --section 20",
        "bifurcation",
        "Orbit diagram over the frequency of the hammer",
        (("-s feed.F0='40 N'", "pressed harder, the bit advances more than twice as far"),),
    ),
    "relief-valve": Study(
        "--param q=0.5:10/96 --t-end 400s",
        "amplitude",
        "Amplitude over the flow: with impacts, without them, and at rest",
        (
            ("-s q=8", "flutter without an impact"),
            ("-s q=1", "every fourth cycle is alike"),
            ("-s q=10", "held open"),
        ),
    ),
    "pile-driver": Study(
        "",
        "velocity",
        "Velocities of ram and pile: impact, drive, and stop",
        (("-s head.e=0.2", "a softer head drives the pile less far"),),
    ),
    "stack-of-blocks": Study(
        "",
        "velocity",
        "Velocities of the three blocks: each joint slips at its own acceleration",
        (("-s base.a='5 mm'", "the two lower blocks move with the table, the upper one still slips"),),
    ),
    "three-balls": Study(
        "",
        "velocity",
        "Velocities of the three balls at the impact",
        (("-s first_gap.e=0.5 -s second.e=0.5", "what the Newton-Moreau law makes of inelastic impacts"),),
    ),
    "two-balls-and-a-spring": Study(
        "",
        "velocity",
        "Velocities of both balls at the bounces",
        (("-s spring.k='100 kN/m'", "a stiffer spring: a faster vibration after the bounce"),),
    ),
    "two-exciters": Study(
        "",
        "rotor-speed",
        "Speeds of both rotors: through the resonance of the frame into one speed",
        (("-s rotors.right.Omega0='11.5 Hz'", "synchronisation is lost"),),
    ),
    "two-masses-with-friction": Study(
        "--param drive.omega=0.2:2/61rad/s --t-end 300s",
        "amplitude",
        "Frequency response: friction cuts the first resonance, and cannot hold the second",
        (("-s floor.mu=1", "the second mass comes to stick for good"),),
    ),
    "ueda-oscillator": Study(
        "--param drive.A=5:12/81N --t-end 1200s --section 60",
        "bifurcation",
        "Bifurcation diagram over the force: Ueda's chaos and its windows",
        (("-s initial.mass.x='2.501 m'", "a start 1 mm away: another motion after some 40 s"),),
    ),
    "van-der-pol": Study(
        "",
        "phase",
        "Phase portrait: from near rest to the limit cycle",
        (("-s damper.mu='5 N s/m'", "relaxation oscillations"),),
    ),
}
