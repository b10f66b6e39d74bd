"""Peers: what vibsim is measured against. Each integrates the paper's equations in its own way.

A peer is made for a scene and its settings (what a compiler would do happens there) and then run:

    peer = EventSolver(scene, "DOP853", rtol=1e-9)
    attempt = peer.run(times, TimeLimit(20.0))

They share the equations, written plainly in `vibsim.evidence.peers.equations`, and nothing of vibsim's
kernel. scipy and heyoka are imported by the modules that need them.
"""
