"""vibsim: vibro-impact systems with dry friction under ideal and limited-power excitation."""

__version__ = "0.1.0"
