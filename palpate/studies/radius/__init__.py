"""``palpate study radius``: which radius of the sphere for which feature and which noise (simulated).

A relief of ridges, z = a cos(2 pi x / lambda) with a = lambda / 10, so that a ridge of width w = lambda / 2 is as high
as it is round: its radius of curvature is about w / 2. The sphere follows it as a light hand would, at the height at
which it rolls over the true relief less a depth, at 50 mm/s. Noise shifts the vertices of a 0.5 mm grid at random, as
a depth camera does.

What a radius keeps of the relief, and what it lets through of the noise, are two figures; the map holds both. The rule
of ``palpate.contact.touchable`` is read off this map.
"""
