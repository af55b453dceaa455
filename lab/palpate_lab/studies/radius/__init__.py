"""``palpate study radius``: effect of the sphere's radius on features of a surface and on sensor noise (simulated).

The surface is a relief of ridges, z = a cos(2 pi x / lambda) with a = lambda / 10. A ridge of width w = lambda / 2 has
a radius of curvature of about w / 2. The sphere slides at 50 mm/s, a constant depth below the height at which it would
roll over the true relief. Noise shifts the vertices of a 0.5 mm grid along z at random, as a depth camera does.

The study measures the fraction of the relief's height that the sphere reproduces, and the errors of the force that the
noise causes. The rule in ``palpate.scene.contact.touchable`` is fitted to these measurements.
"""
