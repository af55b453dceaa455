"""A goal that hard fixtures let jump carries the tool into an object: the contact stores nothing by that."""

import numpy as np

import palpate

SCENE = """
objects: [{name: ball, sphere: {radius: 0.004}, pose: {xyz: [0.012, 0, 0]}, stiffness: 500}]
guidance:
  - {geometry: {sphere: {radius: 0.01}}, role: guide, hard: true, law: {name: spring, stiffness: 100, damping: 0}}
contact: {radius: 0.002}
mapping: {scale: 1}
arms: {follower: {bandwidth: 0}}
operator: {path: [{t: 0, xyz: [-0.003, 0, 0]}]}
stability: {passivity: 'off', rate_cap: 15000, force_cap: 20}
"""
REST, N = 400, 1500  # ticks at the start, and of each half of a cycle


def test_loop_through_the_centre_of_a_guide_and_around_it_gains_nothing():
    """The goal jumps by 20 mm into a ball, whose force the hand leaves on a half circle: -3.6 mJ a cycle before."""
    s = np.linspace(0.0, 1.0, N)
    through = 0.003 * np.c_[2 * s - 1, 0 * s, 0 * s]
    around = 0.003 * np.c_[np.cos(np.pi * s), np.sin(np.pi * s), 0 * s]
    way = np.concatenate([np.repeat(through[:1], REST, axis=0), *[through, around] * 3])
    X, done, F, last = np.eye(4), [0.0], np.zeros(3), way[0]
    with palpate.Haptics(palpate.Scene.parse(SCENE)) as haptics:
        for k, x in enumerate(way):
            X[:3, 3] = x - way[0]
            done.append(done[-1] - F @ (x - last))
            F, last = haptics.step(k * 1e-3, X)[:3], x
    ends = np.array(done)[REST :: 2 * N]
    assert np.ptp(done) > 2e-3, "control: the guide and the ball act"
    assert np.diff(ends).min() > -1e-5
